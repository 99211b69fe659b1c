"""Parameters become figures of merit."""
