"""Exact sums of products of each two frames. `statistics.single_frames.frame_products` says the same in plain NumPy.

Where no code of some pixels is large, products are summed in whole numbers of 32 bits. Others are summed in double
precision: products of 16-bit codes are below 2^32, so that sums of fewer than 2^21 of them are exact in any order, and
the loop may be reassociated.
"""

from typing import Final

import numpy as np
from numba import njit
from numpy.typing import NDArray

from fullwell.kernels.stack import Band, Stack

_BLOCK: Final = 2048
"""Pixels of all frames that are worked on at once, in the first-level cache as they are."""
_PIECE: Final = 512
"""Pixels of all frames that are there at once in double precision, and the fewest that are worth a sum of 32 bits."""


@njit(cache=True, nogil=True)
def _highest(x: NDArray[np.uint16]) -> int:
    highest = np.uint16(0)
    for c in range(x.size):
        highest = max(highest, x[c])
    return int(highest)


@njit(cache=True, nogil=True)
def _narrow_product(x: NDArray[np.int16], y: NDArray[np.int16]) -> np.uint32:
    # The compiler multiplies and adds pairs of 16 bits in one instruction where all has a sign.
    total = np.int32(0)
    for c in range(x.size):
        total = np.int32(total + np.int32(np.int32(x[c]) * np.int32(y[c])))
    return np.uint32(total)


@njit(cache=True, nogil=True, fastmath={"reassoc", "contract"})
def _wide_product(x: NDArray[np.float64], y: NDArray[np.float64]) -> float:
    total = 0.0
    for c in range(x.size):
        total += x[c] * y[c]
    return total


@njit(cache=True, nogil=True)
def _add_narrow(stack: Stack, at: NDArray[np.int64], n: int, totals: NDArray[np.uint64]) -> None:
    """Add the products of n pixels of small codes."""
    for f in range(at.size):
        x = stack.codes[at[f] : at[f] + n].view(np.int16)
        for g in range(f, at.size):
            totals[f, g] += np.uint64(_narrow_product(x, stack.codes[at[g] : at[g] + n].view(np.int16)))


@njit(cache=True, nogil=True)
def _add_wide(
    stack: Stack, at: NDArray[np.int64], n: int, block: NDArray[np.float64], totals: NDArray[np.uint64]
) -> None:
    """Add the products of n pixels of any codes."""
    for f in range(at.size):
        codes, target = stack.codes[at[f] : at[f] + n], block[f]
        for c in range(n):
            target[c] = np.float64(codes[c])
    for f in range(at.size):
        for g in range(f, at.size):
            totals[f, g] += np.uint64(_wide_product(block[f, :n], block[g, :n]))


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
    last = band.bottom * stack.width
    wide = np.empty((stack.starts.size, _PIECE), np.float64)
    for left in range(band.top * stack.width, last, _BLOCK):
        right = min(left + _BLOCK, last)
        highest = 1
        for start in stack.starts:
            highest = max(highest, _highest(stack.codes[start + left : start + right]))
        room = 0xFFFFFFFF // (highest * highest)
        step = max(room, _PIECE)
        for first in range(left, right, step):
            at, n = stack.starts + first, min(step, right - first)
            if room >= _PIECE:
                _add_narrow(stack, at, n, totals)
            else:
                _add_wide(stack, at, n, wide, totals)
