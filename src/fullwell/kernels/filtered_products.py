"""Two frames, each passed through the high-pass filter, multiplied pixel by pixel and added up, in whole numbers.

The filter is that of `high_pass`, times 308^2. Some columns at a time go down the frames, or down those rows of them
that are in memory, once what is kept of the rows above is there. Sums of 7 along a row have
room in 16 bits; what follows wraps around at 2^32, which leaves the filtered rows exact. What is kept lies in one
array, in parts of a constant size: so the compiler sees that parts do not overlap, and works on eight columns at once.
"""

from typing import Final, NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from fullwell.kernels.high_pass import REACH

WIDEST_RANGE: Final = 65535 // 7
"""Range of the codes of a plane up to which `add_filtered_products` is exact [DN]."""

_COLUMNS: Final = 2032
"""Columns that are filtered together: few enough that all that is kept of them stays in the second-level cache."""
_PART: Final = _COLUMNS + 24
_WEIGHT: Final = np.uint32(308 * 308)
_WORD: Final = np.int64(0xFFFFFFFF)

# Parts of what is kept of a frame: sums down 7 and 11 rows, of two of the latter, and what becomes of a row along it.
_SEVEN: Final = 0
_ELEVEN: Final = _PART
_TWO: Final = 2 * _PART
_COLUMN: Final = 3 * _PART
_PAIR: Final = 4 * _PART
_FOUR: Final = 5 * _PART
_ALONG: Final = 6 * _PART
_SUMS: Final = 7 * _PART


class PassedRows(NamedTuple):
    """What is kept of the rows of two frames that were passed, by block of columns and frame.

    Parameters
    ----------
    sums
        The parts, modulo 2^32, shape (blocks, 2, 7 * _PART).
    sevens
        Sums of 7 along the last 8 rows, shape (blocks, 2, 8, _PART).
    ring
        Sums of these down 7 rows, of the last 11 rows, shape (blocks, 2, 11, _PART).
    out
        The filtered rows, shape (2, _COLUMNS).

    """

    sums: NDArray[np.uint32]
    sevens: NDArray[np.uint16]
    ring: NDArray[np.uint32]
    out: NDArray[np.int32]


class _Kept(NamedTuple):
    """What is kept of some columns of one frame."""

    sums: NDArray[np.uint32]
    sevens: NDArray[np.uint16]
    ring: NDArray[np.uint32]
    out: NDArray[np.int32]


class Part(NamedTuple):
    """Rows of a plane of two frames.

    Parameters
    ----------
    first, second
        Rows that are in memory, shape (rows, N) [DN].
    begin
        Which row of the plane they begin with.
    top, bottom
        Which are to be filtered; the `REACH` above them, if there are any, must be in memory too.

    """

    first: NDArray[np.uint16]
    second: NDArray[np.uint16]
    begin: int
    top: int
    bottom: int


def nothing_passed(columns: int) -> PassedRows:
    """Return what is kept before the first row of planes of some columns."""
    blocks = -(-(columns - 2 * REACH) // _COLUMNS)
    return PassedRows(
        np.zeros((blocks, 2, _SUMS), np.uint32),
        np.zeros((blocks, 2, 8, _PART), np.uint16),
        np.zeros((blocks, 2, 11, _PART), np.uint32),
        np.zeros((2, _COLUMNS), np.int32),
    )


@njit(cache=True, nogil=True)
def _add_sevens(x: NDArray[np.uint16], sevens: NDArray[np.uint16], offset: np.uint16, n: int) -> None:
    """Write the sums of 7 along a row."""
    for c in range(n):
        first, second = np.uint16(x[c] + x[c + 1]), np.uint16(x[c + 2] + x[c + 3])
        third = np.uint16(np.uint16(x[c + 4] + x[c + 5]) + x[c + 6])
        sevens[c] = np.uint16(np.uint16(first + second) + np.uint16(third - offset))


@njit(cache=True, nogil=True)
def _pass_down(
    new: NDArray[np.uint16], old: NDArray[np.uint16], ring: NDArray[np.uint32], sums: NDArray[np.uint32], n: int
) -> None:
    """Bring the sums down the columns past a row: those of 7, of 11 of these, and 1, 2, 1 times these."""
    for c in range(n):
        seven = np.uint32(np.uint32(sums[c + _SEVEN] + np.uint32(new[c])) - np.uint32(old[c]))
        before = sums[c + _ELEVEN]
        eleven = np.uint32(np.uint32(before + seven) - ring[c])
        two = np.uint32(before + eleven)
        sums[c + _COLUMN] = np.uint32(sums[c + _TWO] + two)
        sums[c + _SEVEN] = seven
        sums[c + _ELEVEN] = eleven
        sums[c + _TWO] = two
        ring[c] = seven


@njit(cache=True, nogil=True)
def _pass_along(x: NDArray[np.uint16], sums: NDArray[np.uint32], out: NDArray[np.int32], lowest: np.uint32) -> None:
    """Write 308^2 times the filtered row whose codes are ``x``."""
    n = out.size
    for c in range(n + 11):
        sums[c + _PAIR] = np.uint32(sums[c + _COLUMN] + sums[c + _COLUMN + 1])
    for c in range(n + 9):
        sums[c + _FOUR] = np.uint32(sums[c + _PAIR] + sums[c + _PAIR + 2])
    for c in range(n + 2):
        eight = np.uint32(sums[c + _FOUR] + sums[c + _FOUR + 4])
        sums[c + _ALONG] = np.uint32(eight + np.uint32(sums[c + _PAIR + 8] + sums[c + _COLUMN + 10]))
    for c in range(n):
        smooth = np.uint32(sums[c + _ALONG] + sums[c + _ALONG + 2])
        smooth = np.uint32(smooth + np.uint32(sums[c + _ALONG + 1] << np.uint32(1)))
        out[c] = np.int32(np.uint32(np.uint32(np.uint32(np.uint32(x[c]) - lowest) * _WEIGHT) - smooth))


@njit(cache=True, nogil=True)
def _pass(frame: NDArray[np.uint16], begin: int, at: tuple[int, int], lowest: int, passed: tuple[_Kept, int]) -> None:
    """Bring what is kept of n columns of a frame past a row, and filter the row that lies 9 above."""
    (row, left), (kept, n) = at, passed
    wide = n + 12
    new, old = kept.sevens[row % 8], kept.sevens[(row + 1) % 8]
    _add_sevens(frame[row - begin, left : left + wide + 6], new, np.uint16(7 * lowest), wide)
    _pass_down(new, old, kept.ring[row % 11], kept.sums, wide)
    if row >= 2 * REACH:
        first = left + REACH
        _pass_along(frame[row - begin - REACH, first : first + n], kept.sums, kept.out[:n], np.uint32(lowest))


@njit(cache=True, nogil=True)
def _add_products(a: NDArray[np.int32], b: NDArray[np.int32], totals: NDArray[np.int64]) -> None:
    """Add up the products of two filtered rows, and the rows."""
    product, sum_a, sum_b = np.int64(0), np.int64(0), np.int64(0)
    for c in range(a.size):
        product += np.int64(a[c]) * np.int64(b[c])
        sum_a += np.int64(a[c])
        sum_b += np.int64(b[c])
    totals[0] += product & _WORD
    totals[1] += product >> 32
    totals[2] += sum_a
    totals[3] += sum_b


@njit(cache=True, nogil=True)
def add_filtered_products(part: Part, codes: tuple[int, int], passed: PassedRows, totals: NDArray[np.int64]) -> None:
    """Filter further rows of two frames and add them up, without memory for the filtered frames.

    Parameters
    ----------
    part
        Which rows; parts of a plane, which has at least 20 x 20 pixels, follow each other from the top.
    codes
        A code that no other of the plane is below nor by more than `WIDEST_RANGE` above, the same for all parts; and
        how far those of this part and of what is above it lie apart at most [DN].
    passed
        What is kept of the rows above, brought past these.
    totals
        Sum of the products of 308^2 times the filtered frames, as the lower 32 bits and the rest of parts of it, and of
        308^2 times the first and the second, shape (4,), added to.

    """
    lowest, apart = codes
    largest = 308 * 308 * max(1, apart)
    room = min(_COLUMNS, (2**63 - 1) // (largest * largest))
    columns = part.first.shape[1] - 2 * REACH
    for block in range(passed.sums.shape[0]):
        left = block * _COLUMNS
        n = min(_COLUMNS, columns - left)
        a = _Kept(passed.sums[block, 0], passed.sevens[block, 0], passed.ring[block, 0], passed.out[0])
        b = _Kept(passed.sums[block, 1], passed.sevens[block, 1], passed.ring[block, 1], passed.out[1])
        for row in range(part.top, part.bottom):
            _pass(part.first, part.begin, (row, left), lowest, (a, n))
            _pass(part.second, part.begin, (row, left), lowest, (b, n))
            if row >= 2 * REACH:
                for c in range(0, n, room):
                    _add_products(a.out[c : min(c + room, n)], b.out[c : min(c + room, n)], totals)
