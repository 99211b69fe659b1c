"""Exact sums of products of each two frames. `statistics.single_frames.frame_products` says the same in plain NumPy.

Products of 16-bit codes are below 2^32, so sums of fewer than 2^21 of them are exact in double precision in any order;
the loops may be reassociated.
"""

import numpy as np
from numba import njit
from numpy.typing import NDArray

from fullwell.kernels.stack import Band, Stack

_BLOCK = 512
"""Pixels of all frames that are worked on at once, in the first-level cache."""


@njit(cache=True, nogil=True, fastmath={"reassoc", "contract"})
def _product(x: NDArray[np.float64], y: NDArray[np.float64]) -> float:
    total = 0.0
    for c in range(x.size):
        total += x[c] * y[c]
    return total


@njit(cache=True, nogil=True)
def add_frame_products(stack: Stack, band: Band, totals: NDArray[np.uint64]) -> None:
    """Add the products of some rows.

    Parameters
    ----------
    stack
        L frames.
    band
        Which rows.
    totals
        Shape (L, L), of which the upper triangle is added to [DN^2].

    """
    frames = stack.starts.size
    first, last = band.top * stack.width, band.bottom * stack.width
    block = np.empty((frames, _BLOCK), np.float64)
    for left in range(first, last, _BLOCK):
        n = min(_BLOCK, last - left)
        for f in range(frames):
            codes, target = stack.codes[stack.starts[f] + left : stack.starts[f] + left + n], block[f]
            for c in range(n):
                target[c] = np.float64(codes[c])
        for f in range(frames):
            for g in range(f, frames):
                totals[f, g] += np.uint64(_product(block[f, :n], block[g, :n]))
