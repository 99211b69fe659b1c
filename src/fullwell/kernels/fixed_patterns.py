"""Fixed patterns laid on an array: what each pixel, its row and its column add, in one pass.

`fixed_patterns_reference` says the same in plain NumPy.
"""

import numpy as np
from numba import njit
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
Pattern = NDArray[np.float32]


@njit(cache=True, nogil=True, error_model="numpy")
def add_pattern(scale: float, pixels: Pattern, rows: FloatArray, columns: FloatArray, out: FloatArray) -> None:
    """Add the multiple of a pattern, and the values of rows and columns.

    Parameters
    ----------
    scale
        Multiple of the pattern, of the unit of `out`.
    pixels
        The pattern, of the shape of `out` [1].
    rows, columns
        One value per row and per column, of the unit of `out`.
    out
        Added to, shape (rows, columns).

    """
    for r in range(out.shape[0]):
        row, line, pattern = rows[r], out[r], pixels[r]
        for c in range(line.size):
            line[c] += scale * np.float64(pattern[c]) + (row + columns[c])


@njit(cache=True, nogil=True, error_model="numpy")
def multiply_by_response(scale: float, pixels: Pattern, rows: FloatArray, columns: FloatArray, out: FloatArray) -> None:
    """Multiply by one plus a pattern's multiple and the values of rows and columns, or by 0 where that is negative.

    Parameters
    ----------
    scale
        Multiple of the pattern [1].
    pixels
        The pattern, of the shape of `out` [1].
    rows, columns
        One value per row and per column [1].
    out
        Multiplied, shape (rows, columns).

    """
    for r in range(out.shape[0]):
        row, line, pattern = 1.0 + rows[r], out[r], pixels[r]
        for c in range(line.size):
            response = scale * np.float64(pattern[c]) + (row + columns[c])
            line[c] *= max(0.0, response)
