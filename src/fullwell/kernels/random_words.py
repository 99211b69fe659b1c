"""Random words by counter: Philox4x32-10 (Salmon et al., SC11, 2011) behind every random number.

A block is 128 bits, mixed from a 64-bit key (the seed) and a counter of four words: place, draw, frame, stream. Draw 0
is shared by two neighbouring pixels, 64 bits each, since most pixels need no more; whoever needs more takes draws 1, 2,
... of its own, whose place is the pixel itself.
"""

from typing import Final

import numpy as np
from numba import njit
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
Words = NDArray[np.uint64]

CHUNK: Final = 512
"""Pixels whose words are made at once; they stay in the fastest cache."""

_MASK: Final = np.uint64(0xFFFFFFFF)
_HALF: Final = np.uint64(32)
_MULTIPLIER_0: Final = np.uint64(0xD2511F53)
_MULTIPLIER_1: Final = np.uint64(0xCD9E8D57)
_WEYL_0: Final = np.uint64(0x9E3779B9)
_WEYL_1: Final = np.uint64(0xBB67AE85)
_ONE: Final = np.uint64(0x3FF0000000000000)  # the bits of 1.0


@njit(cache=True, inline="always")
def philox(  # noqa: PLR0917 - compiled functions take their words by position
    c0: np.uint64, c1: np.uint64, c2: np.uint64, c3: np.uint64, k0: np.uint64, k1: np.uint64
) -> tuple[np.uint64, np.uint64, np.uint64, np.uint64]:
    """Return the four 32-bit words of one block, each in 64 bits."""
    for _ in range(10):
        low = _MULTIPLIER_0 * c0
        high = _MULTIPLIER_1 * c2
        c0 = (high >> _HALF) ^ c1 ^ k0
        c2 = (low >> _HALF) ^ c3 ^ k1
        c1 = high & _MASK
        c3 = low & _MASK
        k0 = (k0 + _WEYL_0) & _MASK
        k1 = (k1 + _WEYL_1) & _MASK
    return c0, c1, c2, c3


@njit(cache=True, inline="always")
def from_one(fraction: np.uint64) -> float:
    """Return the number from 1 to below 2 that has these 52 bits behind its point: no conversion, so many at once."""
    return np.uint64(fraction | _ONE).view(np.float64)


@njit(cache=True, inline="always")
def unit(word: np.uint64) -> float:
    """Return the upper 52 bits of a word as a number strictly between 0 and 1: the middle of its step, exactly."""
    return from_one(word >> np.uint64(12)) - (1.0 - 2.0**-53)


@njit(cache=True, error_model="numpy")
def fill_words(key: Words, pixel: int, count: int, words: Words) -> int:
    """Make the 64 bits of draw 0 of some pixels in a row.

    Parameters
    ----------
    key
        Key, frame and stream.
    pixel
        Number of the first pixel.
    count
        Pixels, at most as many as `words` holds but for one.
    words
        Where to.

    Returns
    -------
    int
        Where in ``words`` the first pixel's are: 1 where it is the second of its block, else 0.

    """
    block = pixel >> 1
    zero = np.uint64(0)
    for i in range(((pixel + count - 1) >> 1) - block + 1):
        w0, w1, w2, w3 = philox(np.uint64(block + i), zero, key[2], key[3], key[0], key[1])
        words[2 * i] = w0 << _HALF | w1
        words[2 * i + 1] = w2 << _HALF | w3
    return pixel & 1


@njit(cache=True)
def drawn(key: Words, pixel: int, draw: np.uint64) -> tuple[np.uint64, np.uint64]:
    """Return the two words of 64 bits of a pixel's draw 1, 2, ..."""
    w0, w1, w2, w3 = philox(np.uint64(pixel), draw, key[2], key[3], key[0], key[1])
    return w0 << _HALF | w1, w2 << _HALF | w3
