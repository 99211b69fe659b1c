"""Sums of squares of unsigned integers that overflow nothing."""

import numpy as np
from numpy.typing import NDArray

_LIMB_BITS = 24
_LIMB = np.uint64((1 << _LIMB_BITS) - 1)
_CHUNK = 1 << 16


def sum_of_squares(values: NDArray[np.uint64]) -> int:
    """Return the exact sum of the squares of an array.

    Each value is three limbs of 24 bits; a product of two has 48 bits, so 65536 of them fit a 64-bit word.

    Parameters
    ----------
    values
        Array of any shape.

    Examples
    --------
    >>> sum_of_squares(np.array([2**64 - 1, 3], dtype=np.uint64)) == (2**64 - 1) ** 2 + 9
    True

    """
    flat = values.reshape(-1)
    total = 0
    for start in range(0, flat.size, _CHUNK):
        part = flat[start : start + _CHUNK]
        limbs = [(part >> np.uint64(_LIMB_BITS * k)) & _LIMB for k in range(3)]
        for i, left in enumerate(limbs):
            for j, right in enumerate(limbs):
                total += int((left * right).sum(dtype=np.uint64)) << (_LIMB_BITS * (i + j))
    return total


def total_of(values: NDArray[np.uint64]) -> int:
    """Return the exact sum of an array.

    Examples
    --------
    >>> total_of(np.array([2**64 - 1, 2**64 - 1], dtype=np.uint64)) == 2 * (2**64 - 1)
    True

    """
    low = (values & np.uint64(0xFFFFFFFF)).sum(dtype=np.uint64)
    high = (values >> np.uint64(32)).sum(dtype=np.uint64)
    return (int(high) << 32) + int(low)
