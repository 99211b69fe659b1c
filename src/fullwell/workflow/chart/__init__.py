"""Shots of a test chart, read, located, measured and drawn."""
