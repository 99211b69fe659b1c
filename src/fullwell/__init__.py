"""Fullwell measures image sensors from raw files, every figure with an honest uncertainty."""

__version__ = "0.1.0"

__all__ = ["__version__"]
