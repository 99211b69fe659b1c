"""The verbs: characterize, demo."""
