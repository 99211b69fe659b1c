"""A mosaic becomes a picture."""
