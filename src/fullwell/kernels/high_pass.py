"""The high-pass filter of EMVA 1288 Release 4.0: a plane less its mean over 7 x 7, 11 x 11 and a 3 x 3 binomial.

All three are separable, so a column passes running sums of 7 and of 11 rows and a binomial of 3, a row the same. Only
pixels whose whole surroundings lie in the plane are filtered: 9 are lost on every side. `high_pass_reference` says the
same in plain NumPy.
"""

from typing import Final

import numpy as np
from numba import njit
from numpy.typing import NDArray

REACH: Final = 9
"""Pixels that the filter looks to either side, and that are lost there."""

_DIVISOR: Final = 308.0 * 308.0


@njit(cache=True, nogil=True)
def _along_row(sums: NDArray[np.float64], sevens: NDArray[np.float64], elevens: NDArray[np.float64]) -> None:
    """Write sums of 7, and of these sums of 11, along a row of length N, N - 6 and N - 16."""
    for c in range(sevens.size):
        pair = sums[c] + sums[c + 1]
        sevens[c] = pair + (sums[c + 2] + sums[c + 3]) + (sums[c + 4] + sums[c + 5]) + sums[c + 6]
    for c in range(elevens.size):
        first = (sevens[c] + sevens[c + 1]) + (sevens[c + 2] + sevens[c + 3])
        second = (sevens[c + 4] + sevens[c + 5]) + (sevens[c + 6] + sevens[c + 7])
        elevens[c] = first + second + (sevens[c + 8] + sevens[c + 9]) + sevens[c + 10]


@njit(cache=True, nogil=True)
def high_pass(plane: NDArray[np.float64] | NDArray[np.uint16], out: NDArray[np.float64]) -> None:
    """Filter a plane.

    Parameters
    ----------
    plane
        Shape (M, N), at least 19 x 19, of any type; whole numbers below 2^36 are filtered without rounding but for the
        last division [DN].
    out
        Shape (M - 18, N - 18) [DN].

    """
    rows, width = plane.shape
    ring7 = np.zeros((11, width), np.float64)
    ring11 = np.zeros((3, width), np.float64)
    sum7 = np.zeros(width, np.float64)
    sum11 = np.zeros(width, np.float64)
    column = np.empty(width, np.float64)
    sevens = np.empty(width - 6, np.float64)
    elevens = np.empty(width - 16, np.float64)
    for row in range(rows):
        new, old = plane[row], plane[row - 7 if row >= 7 else row]
        kept = 1.0 if row >= 7 else 0.0
        into7 = ring7[(row - 6) % 11]
        for c in range(width):
            sum7[c] += np.float64(new[c]) - kept * np.float64(old[c])
        if row < 6:
            continue
        for c in range(width):
            sum11[c] += sum7[c] - into7[c]
            into7[c] = sum7[c]
        if row < 16:
            continue
        into11 = ring11[(row - 16) % 3]
        for c in range(width):
            into11[c] = sum11[c]
        if row < 18:
            continue
        above, middle = ring11[(row - 18) % 3], ring11[(row - 17) % 3]
        for c in range(width):
            column[c] = above[c] + 2.0 * middle[c] + into11[c]
        _along_row(column, sevens, elevens)
        centre, target = plane[row - 9], out[row - 18]
        for c in range(target.size):
            smooth = elevens[c] + 2.0 * elevens[c + 1] + elevens[c + 2]
            target[c] = np.float64(centre[c + 9]) - smooth / _DIVISOR


@njit(cache=True, nogil=True)
def add_products(
    first: NDArray[np.float64],
    second: NDArray[np.float64],
    products: NDArray[np.float64],
    sums: NDArray[np.float64],
) -> None:
    """Add up two filtered planes column by column.

    Parameters
    ----------
    first, second
        Shape (rows, columns).
    products
        Of each column: sum of the products, shape (columns,), added to.
    sums
        Of each column: sums of the first and of the second, shape (2, columns), added to.

    """
    for row in range(first.shape[0]):
        a, b = first[row], second[row]
        for c in range(products.size):
            products[c] += a[c] * b[c]
            sums[0, c] += a[c]
            sums[1, c] += b[c]


@njit(cache=True, nogil=True)
def pair_sums(first: NDArray[np.uint16], second: NDArray[np.uint16], sums: NDArray[np.int64]) -> None:
    """Add up two frames of a plane: both sums, squared differences, products.

    Parameters
    ----------
    first, second
        Shape (M, N) [DN].
    sums
        Shape (4,), added to [DN, DN, DN^2, DN^2].

    """
    for row in range(first.shape[0]):
        total_a, total_b, squares, products = np.int64(0), np.int64(0), np.int64(0), np.int64(0)
        a, b = first[row], second[row]
        for c in range(a.size):
            x, y = np.int64(a[c]), np.int64(b[c])
            total_a += x
            total_b += y
            squares += (x - y) * (x - y)
            products += x * y
        sums[0] += total_a
        sums[1] += total_b
        sums[2] += squares
        sums[3] += products
