"""Where a simulated camera comes from, and its raw files on disk."""
