"""Loops over a row of pixels, or a few rows, that the compiler turns into vector instructions.

Each holds no more than two sums of one width: with more, or with wider ones beside narrow ones, the compiler takes
fewer pixels at a time. Sums are kept as narrow as the largest code allows (`frames_in_32_bits`, `rows_in_16_bits`).
"""

from collections.abc import Callable
from typing import Any, cast

import numpy as np
from numba import njit, types
from numba.extending import intrinsic
from numpy.typing import NDArray

LARGEST_NARROW = 32767
_NARROW = np.uint16(LARGEST_NARROW)
"""No code is larger where four squares fit in 32 bits; telling the compiler lets it multiply in 16."""

Rows = tuple[NDArray[np.uint16], NDArray[np.uint16], NDArray[np.uint16], NDArray[np.uint16]]


def _generate_square(_typing: Any, _code: Any) -> Any:  # noqa: ANN401 - the compiler's own types
    """Return the square of a code up to ``_NARROW`` in 32 bits; written with ``*`` it would be computed in 64."""

    def generate(_context: Any, builder: Any, _signature: Any, arguments: Any) -> Any:  # noqa: ANN401 - as above
        return builder.mul(arguments[0], arguments[0])

    return types.uint32(types.uint32), generate


_square = cast("Callable[[np.uint32], np.uint32]", intrinsic(_generate_square))


@njit(cache=True, nogil=True)
def frames_in_32_bits(highest: int, frames: int) -> int:
    """Return how many squares of codes up to ``highest`` a sum of 32 bits holds, at most ``frames``; at least one."""
    square = highest * highest
    return frames if square * frames <= 0xFFFFFFFF else 0xFFFFFFFF // square


@njit(cache=True, nogil=True)
def rows_in_16_bits(highest: int, rows: int) -> int:
    """Return how many codes up to ``highest`` a sum of 16 bits holds, at most ``rows``; at least one."""
    return rows if highest * rows <= 0xFFFF else 0xFFFF // highest


@njit(cache=True, nogil=True)
def add_one(x: NDArray[np.uint16], codes: NDArray[np.uint32], squares: NDArray[np.uint64]) -> None:
    """Add a row of one frame to the maps."""
    for c in range(x.size):
        value = np.uint32(x[c])
        codes[c] = codes[c] + value
        squares[c] = squares[c] + np.uint64(value) * value


@njit(cache=True, nogil=True)
def add_four(x: Rows, codes: NDArray[np.uint32], squares: NDArray[np.uint64]) -> None:
    """Add the same row of four frames to the maps, which are read and written once."""
    first, second, third, fourth = x
    for c in range(first.size):
        i, j, k, m = np.uint32(first[c]), np.uint32(second[c]), np.uint32(third[c]), np.uint32(fourth[c])
        codes[c] = codes[c] + (i + j + k + m)
        squares[c] = squares[c] + (np.uint64(i) * i + np.uint64(j) * j + np.uint64(k) * k + np.uint64(m) * m)


@njit(cache=True, nogil=True)
def add_one_narrow(x: NDArray[np.uint16], codes: NDArray[np.uint32], squares: NDArray[np.uint32]) -> None:
    """Add a row of one frame to sums of 32 bits; no code is above ``_NARROW``."""
    for c in range(x.size):
        value = np.uint32(x[c] & _NARROW)
        codes[c] = codes[c] + value
        squares[c] = squares[c] + np.uint32(value * value)


@njit(cache=True, nogil=True)
def add_four_narrow(x: Rows, codes: NDArray[np.uint32], squares: NDArray[np.uint32]) -> None:
    """Add the same row of four frames to sums of 32 bits; no code is above ``_NARROW``."""
    first, second, third, fourth = x
    for c in range(first.size):
        i, j = np.uint32(first[c] & _NARROW), np.uint32(second[c] & _NARROW)
        k, m = np.uint32(third[c] & _NARROW), np.uint32(fourth[c] & _NARROW)
        codes[c] = np.uint32(codes[c] + np.uint32(np.uint32(i + j) + np.uint32(k + m)))
        pair, other = np.uint32(_square(i) + _square(j)), np.uint32(_square(k) + _square(m))
        squares[c] = np.uint32(squares[c] + np.uint32(pair + other))


@njit(cache=True, nogil=True)
def add_to_maps(
    narrow: tuple[NDArray[np.uint32], NDArray[np.uint32]], codes: NDArray[np.uint32], squares: NDArray[np.uint64]
) -> None:
    """Add sums of codes and squares in 32 bits to the maps."""
    sums, square_sums = narrow
    for c in range(sums.size):
        codes[c] = codes[c] + sums[c]
    for c in range(sums.size):
        squares[c] = squares[c] + np.uint64(square_sums[c])


@njit(cache=True, nogil=True)
def widen_row(squares: NDArray[np.uint32], wide: NDArray[np.uint64]) -> None:
    """Write sums of 32 bits in 64."""
    for c in range(squares.size):
        wide[c] = np.uint64(squares[c])


@njit(cache=True, nogil=True)
def add_columns(x: NDArray[np.uint16], columns: NDArray[np.uint16]) -> None:
    """Add a row to column sums of 16 bits."""
    for c in range(x.size):
        columns[c] = np.uint16(columns[c] + x[c])


@njit(cache=True, nogil=True)
def add_columns_of_four(x: Rows, columns: NDArray[np.uint16]) -> None:
    """Add four rows to column sums of 16 bits."""
    i, j, k, m = x
    for c in range(i.size):
        columns[c] = np.uint16(columns[c] + np.uint16(np.uint16(i[c] + j[c]) + np.uint16(k[c] + m[c])))


@njit(cache=True, nogil=True)
def flush_columns(narrow: NDArray[np.uint16], columns: NDArray[np.uint32]) -> None:
    """Add column sums of 16 bits to those of 32, and begin anew."""
    for c in range(narrow.size):
        columns[c] = columns[c] + np.uint32(narrow[c])
    narrow[:] = 0


@njit(cache=True, nogil=True)
def add_row_sum(x: NDArray[np.uint16], row: NDArray[np.uint64]) -> None:
    """Add the sums of a row by phase of the column to ``row``, shape (cell,).

    A sum of 32 bits holds the at most 32768 codes of a phase.
    """
    even, odd = np.uint32(0), np.uint32(0)
    for c in range(x.size // 2):
        even = np.uint32(even + np.uint32(x[2 * c]))
        odd = np.uint32(odd + np.uint32(x[2 * c + 1]))
    row[0] += np.uint64(even)
    row[row.size - 1] += np.uint64(odd)
    if x.size % 2:
        row[0] += np.uint64(x[x.size - 1])
