"""Linear combinations of maps, a few rows at a time so that what is added up stays in the cache.

`pixel_maps_reference` says the same in plain NumPy.
"""

import numpy as np
from numba import njit
from numpy.typing import NDArray

Rows = NDArray[np.uint16 | np.uint32 | np.float32]
"""The same rows of one map, shape (rows, width)."""


@njit(cache=True, nogil=True)
def add_one(rows: Rows, top: int, coefficients: NDArray[np.float64], totals: NDArray[np.float64]) -> None:
    """Add a multiple of one map to each total.

    Parameters
    ----------
    rows
        Rows of the map.
    top
        Which row of the mosaic the first is.
    coefficients
        Shape (totals, cell, cell), by phase of row and column.
    totals
        Shape (totals, at least as many rows, width), added to.

    """
    cell = coefficients.shape[1]
    for r in range(rows.shape[0]):
        x = rows[r]
        for j in range(totals.shape[0]):
            even, odd = coefficients[j, (top + r) % cell, 0], coefficients[j, (top + r) % cell, cell - 1]
            total = totals[j, r]
            for c in range(x.size):
                total[c] += (odd if c & 1 else even) * np.float64(x[c])


@njit(cache=True, nogil=True)
def add_four(
    four: tuple[Rows, Rows, Rows, Rows], top: int, coefficients: NDArray[np.float64], totals: NDArray[np.float64]
) -> None:
    """Add multiples of four maps to each total, which is read and written once.

    Parameters
    ----------
    four
        The same rows of four maps.
    top
        Which row of the mosaic the first is.
    coefficients
        Shape (totals, 4, cell, cell), by phase of row and column.
    totals
        Shape (totals, at least as many rows, width), added to.

    """
    first, second, third, fourth = four
    cell = coefficients.shape[2]
    for r in range(first.shape[0]):
        x0, x1, x2, x3 = first[r], second[r], third[r], fourth[r]
        for j in range(totals.shape[0]):
            a = coefficients[j, :, (top + r) % cell, 0]
            b = coefficients[j, :, (top + r) % cell, cell - 1]
            a0, a1, a2, a3 = a[0], a[1], a[2], a[3]
            b0, b1, b2, b3 = b[0], b[1], b[2], b[3]
            total = totals[j, r]
            for c in range(x0.size):
                odd = c & 1
                total[c] += (
                    (b0 if odd else a0) * np.float64(x0[c])
                    + (b1 if odd else a1) * np.float64(x1[c])
                    + (b2 if odd else a2) * np.float64(x2[c])
                    + (b3 if odd else a3) * np.float64(x3[c])
                )
