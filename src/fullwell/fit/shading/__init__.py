"""Lens shading: smooth surfaces fitted to the bins of a plane, the choice among them, and what they say (METHOD 6)."""
