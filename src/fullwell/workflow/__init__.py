"""The verbs: characterize, chart, simulate, loop, demo."""
