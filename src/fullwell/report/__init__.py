"""Figures become pages and files."""
