"""The verbs: characterize, simulate, demo."""
