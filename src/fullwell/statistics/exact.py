"""Sums of squares of unsigned integers that overflow nothing."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

Whole = NDArray[Any]
"""Whole numbers: of 64 bits, or Python's own."""

_LIMB_BITS = 24
_LIMB = np.uint64((1 << _LIMB_BITS) - 1)
_CHUNK = 1 << 16


def sum_of_squares(values: NDArray[np.uint64]) -> int:
    """Return the exact sum of the squares of an array.

    Where a 64-bit word does not hold it, each value is three limbs of 24 bits; a product of two has 48 bits, so 65536
    of them fit a word.

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
    if int(flat.max(initial=0)) ** 2 * flat.size < 1 << 64:
        return int((flat * flat).sum(dtype=np.uint64))
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


def exact_integers(values: NDArray[np.uint64]) -> Whole:
    """Return whole numbers of which a sum does not overflow: as Python's own where 64 bits may not do.

    Examples
    --------
    >>> int(exact_integers(np.array([2**63, 2**63], dtype=np.uint64)).sum()) == 2**64
    True

    """
    return values.astype(np.int64 if values.sum(dtype=np.float64) < 1 << 62 else np.object_)
