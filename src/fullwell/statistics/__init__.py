"""Frames become numbers: streamed, exact, mergeable; no fit, no physics."""
