"""Compiled loops and their readable NumPy twins: the JIT's only door."""

from pathlib import Path

from fullwell.kernels.compile_cache import forget_other_code

forget_other_code(Path(__file__).parent)
