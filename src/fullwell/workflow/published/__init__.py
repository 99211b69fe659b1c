"""The published Pixel study's own figures and tables, from a user's frames (METHOD 3.2, 5.3; RESULTS 4)."""
