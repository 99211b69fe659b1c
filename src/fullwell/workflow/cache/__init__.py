"""Finished series are kept beside the results, so that a run that was cut short, or has more to read, reads on."""
