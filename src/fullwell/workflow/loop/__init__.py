"""The loop closed: a camera is simulated as it was measured, measured again, and laid beside its truth."""
