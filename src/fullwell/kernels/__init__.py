"""Compiled loops and their readable NumPy twins: the JIT's only door."""
