"""What `fixed_patterns` computes, in plain NumPy: to read, and to test the compiled loops against."""

import numpy as np

from fullwell.kernels.fixed_patterns import FloatArray, Pattern


def add_pattern(scale: float, pixels: Pattern, rows: FloatArray, columns: FloatArray, out: FloatArray) -> None:
    """Add a pattern's multiple and values of rows and columns; see `fixed_patterns.add_pattern`."""
    out += scale * pixels.astype(np.float64) + (rows[:, np.newaxis] + columns)


def multiply_by_response(scale: float, pixels: Pattern, rows: FloatArray, columns: FloatArray, out: FloatArray) -> None:
    """Multiply by the response of each pixel; see `fixed_patterns.multiply_by_response`."""
    out *= np.maximum(scale * pixels.astype(np.float64) + (1.0 + rows[:, np.newaxis] + columns), 0.0)
