"""Images become an experiment."""
