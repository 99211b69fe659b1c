"""Products of each row of a plane with functions of its columns, in one pass over the plane."""

import numpy as np
from numba import njit
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]


@njit(cache=True, nogil=True, error_model="numpy", fastmath={"reassoc", "contract", "nsz"})
def row_products(
    plane: NDArray[np.uint16 | np.uint32], first: FloatArray, second: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return the sums over each row of its values, times 1 and times two functions.

    Parameters
    ----------
    plane
        Shape (V, H), of any strides.
    first, second
        By column, shape (H,).

    Returns
    -------
    tuple
        Three arrays of shape (V,).

    """
    rows = plane.shape[0]
    ones, firsts, seconds = np.empty(rows), np.empty(rows), np.empty(rows)
    for r in range(rows):
        row = plane[r]
        one = one_first = one_second = 0.0
        for c in range(first.size):
            value = np.float64(row[c])
            one += value
            one_first += value * first[c]
            one_second += value * second[c]
        ones[r], firsts[r], seconds[r] = one, one_first, one_second
    return ones, firsts, seconds
