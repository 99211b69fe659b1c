"""Raw files become DNG or TIFF: planned, recoded, written, and what could not be kept is said."""
