"""The loop closed: parameters become raw files that re-enter by the front door."""
