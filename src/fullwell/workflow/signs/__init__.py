"""What raw values tell of themselves: rails, code steps, colour filters, defects, processing in the camera."""
