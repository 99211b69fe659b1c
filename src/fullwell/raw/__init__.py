"""A file becomes an array and what is known about it."""
