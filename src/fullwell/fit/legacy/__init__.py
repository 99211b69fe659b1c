"""The published estimators, biased as they are, under their own names: beside the recommended ones, never instead."""
