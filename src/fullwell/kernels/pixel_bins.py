"""Sums over small squares of a plane, without pixels that are far from the others of their square.

Codes are integers, so the median of a square is found by counting how many pixels lie at or below a code and halving
the range, which needs no sorting. `pixel_bins_reference` says the same in plain NumPy.
"""

from typing import Final, NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

LARGEST_SIDE: Final = 64
"""Of a bin [pixel]."""
SIGMAS: Final = 6.0
"""From the median of its bin, beyond which a pixel is defective."""
TO_SIGMA: Final = 1.4826
"""Standard deviation of normal noise over its median absolute deviation."""


class Limits(NamedTuple):
    """What is left out.

    Parameters
    ----------
    least_reach
        No pixel is defective that is as near to the median of its bin [DN, summed over frames].
    most
        A bin with a sound pixel above is left out [DN, summed over frames].

    """

    least_reach: float
    most: float


class BinSums(NamedTuple):
    """Of each bin: pixels that count, what they sum up to, pixels left out, and whether the bin is.

    All have shape (bin rows, bin columns); a bin that is left out has no pixels of either kind.
    """

    n: NDArray[np.int64]
    totals: NDArray[np.uint64]
    defective: NDArray[np.int64]
    saturated: NDArray[np.bool_]


@njit(cache=True, nogil=True)
def _gather(plane: NDArray[np.uint16 | np.uint32], corner: tuple[int, int], size: int, x: NDArray[np.uint32]) -> int:
    """Copy the pixels of a bin and return how many there are."""
    top, left = corner
    right = min(left + size, plane.shape[1])
    n = 0
    for r in range(top, min(top + size, plane.shape[0])):
        for c in range(left, right):
            x[n] = plane[r, c]
            n += 1
    return n


@njit(cache=True, nogil=True)
def _middle(x: NDArray[np.uint32]) -> np.uint32:
    """Return the lower median."""
    low, high = x[0], x[0]
    for i in range(x.size):
        low, high = min(low, x[i]), max(high, x[i])
    half = np.uint32((x.size + 1) // 2)
    while low < high:
        between = np.uint32(low + (high - low) // np.uint32(2))
        below = np.uint32(0)
        for i in range(x.size):
            below = np.uint32(below + np.uint32(x[i] <= between))
        if below >= half:
            high = between
        else:
            low = np.uint32(between + np.uint32(1))
    return low


@njit(cache=True, nogil=True)
def _sound(x: NDArray[np.uint32], away: NDArray[np.uint32], least_reach: float) -> int:
    """Move the pixels that are not defective to the front and return how many there are."""
    n = x.size
    while True:
        low, high = x[0], x[0]
        for i in range(n):
            low, high = min(low, x[i]), max(high, x[i])
        if np.float64(high - low) <= least_reach:
            return n
        median = _middle(x[:n])
        for i in range(n):
            away[i] = x[i] - median if x[i] > median else median - x[i]
        reach = max(least_reach, SIGMAS * TO_SIGMA * np.float64(_middle(away[:n])))
        kept = 0
        for i in range(n):
            x[kept] = x[i]
            if np.float64(away[i]) <= reach:
                kept += 1
        if kept == n:
            return n
        n = kept


@njit(cache=True, nogil=True)
def bin_rows(
    plane: NDArray[np.uint16 | np.uint32], size: int, rows: tuple[int, int], limits: Limits, found: BinSums
) -> None:
    """Write some rows of bins, from the first to one past the last.

    Parameters
    ----------
    plane
        Sums over frames, shape (rows, columns) [DN].
    size
        Edge of a bin, at most `LARGEST_SIDE` [pixel].
    rows
        First row of bins and one past the last.
    limits
        What is left out.
    found
        Written to.

    """
    whole_x, whole_away = np.empty(size * size, np.uint32), np.empty(size * size, np.uint32)
    for row in range(rows[0], rows[1]):
        for column in range(found.n.shape[1]):
            n = _gather(plane, (row * size, column * size), size, whole_x)
            kept = _sound(whole_x[:n], whole_away, limits.least_reach)
            total, high = np.uint64(0), np.uint32(0)
            for i in range(kept):
                total += np.uint64(whole_x[i])
                high = max(high, whole_x[i])
            out = np.float64(high) > limits.most
            found.saturated[row, column] = out
            found.n[row, column] = 0 if out else kept
            found.defective[row, column] = 0 if out else n - kept
            found.totals[row, column] = np.uint64(0) if out else total
