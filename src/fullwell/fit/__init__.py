"""Numbers become parameters with uncertainty."""
