"""A row of tiles of finished maps is summed in whole numbers of 32 bits where frames are few enough, or codes small.

Down a column of n rows the running sums ``A += S``, ``B += A``, ``C += B`` come to sums of S times 1, m and
m (m + 1) / 2, where m counts rows from below, n to 1: any quadratic polynomial of the row is made of them afterwards,
in whole numbers. Sums of Q and D have 64 bits. All is what `moments_summary.summarize_band` comes to, to the bit.

What is kept of some columns lies in one array, in parts of a constant size: so the compiler sees that they do not
overlap, and works on eight columns at once.
"""

from typing import Final

import numpy as np
from numba import njit
from numpy.typing import NDArray

from fullwell.kernels.moments_summary import ColumnSums, Maps, SpreadCounts, Words, count_spread
from fullwell.kernels.stack import Band, rows_of

_COLUMNS: Final = 512
"""Columns that are summed together: few enough that all that is kept of them stays in the nearest cache."""
_FOUR: Final = 4
_LARGEST_SUM: Final = 92681
"""No S is above it where D, which is at most a quarter of its square, has room in 31 bits."""

# Parts of what is kept in 32 bits: A, B, C, and D of four rows.
_A: Final = 0
_B: Final = _COLUMNS
_C: Final = 2 * _COLUMNS
_D: Final = 3 * _COLUMNS
_PARTS: Final = 7 * _COLUMNS

_FourRows = tuple[Words, Words, Words, Words]
Running = tuple[np.int64, np.int64, np.int64]
_Temporal = tuple[NDArray[np.uint64], NDArray[np.uint64], NDArray[np.float64]]


@njit(cache=True, nogil=True)
def suits(frames: int, highest: int, band: Band) -> bool:
    """Tell whether no sum of a row of tiles outgrows its width where no code of some frames is above ``highest``.

    The number of rows must not be a multiple of 3 either: sums in floating point, which other ways to the same numbers
    take, are exact then too.
    """
    largest = frames * highest
    for phase in range(band.cell):
        n = rows_of(band, phase)
        if largest * (n * (n + 1) * (n + 2) // 6) >= 2**32 or (n > 0 and n % 3 == 0):
            return False
    return largest <= _LARGEST_SUM


@njit(cache=True, nogil=True)
def write_spatial(running: Running, rows: int, moved: np.int64, at: tuple[int, int], out: ColumnSums) -> None:
    """Add what the running sums of a column come to, centred anew.

    Parameters
    ----------
    running
        A, B and C of as many ``rows``.
    moved
        Added to each of what was summed up.
    at
        Phase and column.
    out
        Added to.

    """
    a, b, c = running
    n = rows
    whole = a + n * moved
    once = b + moved * (n * (n + 1) // 2)
    twice = 2 * c - b + moved * (n * (n + 1) * (2 * n + 1) // 6)
    out.centred[at] += np.float64(whole)
    out.linear[at] += np.float64((n + 1) * whole - 2 * once) / 2.0
    out.quadratic[at] += np.float64(twice - (n + 1) * once + (n + 1) * (n + 2) // 6 * whole)


@njit(cache=True, nogil=True)
def _write_spreads(s: _FourRows, q: _FourRows, frames: int, work: NDArray[np.uint32]) -> None:
    """Write D of four rows."""
    count = np.uint32(frames)
    i, j, k, m = s
    q_i, q_j, q_k, q_m = q
    for c in range(i.size):
        work[c + _D] = np.uint32(np.uint32(count * q_i[c]) - np.uint32(i[c] * i[c]))
        work[c + _D + _COLUMNS] = np.uint32(np.uint32(count * q_j[c]) - np.uint32(j[c] * j[c]))
    for c in range(i.size):
        work[c + _D + 2 * _COLUMNS] = np.uint32(np.uint32(count * q_k[c]) - np.uint32(k[c] * k[c]))
        work[c + _D + 3 * _COLUMNS] = np.uint32(np.uint32(count * q_m[c]) - np.uint32(m[c] * m[c]))


@njit(cache=True, nogil=True)
def _run_on(s: _FourRows, work: NDArray[np.uint32]) -> None:
    """Bring the running sums past four rows."""
    i, j, k, m = s
    for c in range(i.size):
        a = np.uint32(work[c + _A] + i[c])
        b = np.uint32(work[c + _B] + a)
        e = np.uint32(work[c + _C] + b)
        a = np.uint32(a + j[c])
        b = np.uint32(b + a)
        e = np.uint32(e + b)
        a = np.uint32(a + k[c])
        b = np.uint32(b + a)
        e = np.uint32(e + b)
        a = np.uint32(a + m[c])
        b = np.uint32(b + a)
        e = np.uint32(e + b)
        work[c + _A] = a
        work[c + _B] = b
        work[c + _C] = e


@njit(cache=True, nogil=True)
def _add_temporal(q: _FourRows, work: NDArray[np.uint32], sums: _Temporal) -> None:
    """Add Q, D and D^2 of four rows."""
    squares, spread, quartic = sums
    i, j, k, m = q
    for c in range(i.size):
        squares[c] += (np.uint64(i[c]) + np.uint64(j[c])) + (np.uint64(k[c]) + np.uint64(m[c]))
    for c in range(i.size):
        pair = np.uint64(work[c + _D]) + np.uint64(work[c + _D + _COLUMNS])
        spread[c] += pair + (np.uint64(work[c + _D + 2 * _COLUMNS]) + np.uint64(work[c + _D + 3 * _COLUMNS]))
    for c in range(i.size):
        first, second = np.float64(np.int32(work[c + _D])), np.float64(np.int32(work[c + _D + _COLUMNS]))
        third = np.float64(np.int32(work[c + _D + 2 * _COLUMNS]))
        fourth = np.float64(np.int32(work[c + _D + 3 * _COLUMNS]))
        quartic[c] += (first * first + second * second) + (third * third + fourth * fourth)


@njit(cache=True, nogil=True)
def _add_one(s: NDArray[np.uint32], q: Words, frames: int, work: NDArray[np.uint32], sums: _Temporal) -> None:
    """Do all of that with a single row."""
    squares, spread, quartic = sums
    for c in range(s.size):
        d = np.uint32(np.uint32(np.uint32(frames) * q[c]) - np.uint32(s[c] * s[c]))
        work[c + _D] = d
        work[c + _A] = np.uint32(work[c + _A] + s[c])
        work[c + _B] = np.uint32(work[c + _B] + work[c + _A])
        work[c + _C] = np.uint32(work[c + _C] + work[c + _B])
        squares[c] += np.uint64(q[c])
        spread[c] += np.uint64(d)
        quartic[c] += np.float64(d) * np.float64(d)


@njit(cache=True, nogil=True)
def _rows_from(of: Words, row: int, step: int, columns: tuple[int, int]) -> _FourRows:
    """Return some columns of four rows."""
    first, last = columns
    return (
        of[row, first:last],
        of[row + step, first:last],
        of[row + 2 * step, first:last],
        of[row + 3 * step, first:last],
    )


@njit(cache=True, nogil=True)
def _write(
    work: NDArray[np.uint32],
    at: tuple[int, int],
    shape: tuple[int, int, int],
    reference: NDArray[np.float64],
    sums: ColumnSums,
) -> None:
    """Put what the running sums of some columns come to where it belongs.

    Parameters
    ----------
    work
        Running sums.
    at
        Phase, and first column.
    shape
        Frames, rows and columns.
    reference, sums
        As of `summarize_narrow`.

    """
    phase, left = at
    frames, rows, n = shape
    for c in range(n):
        zero, a = np.int64(reference[phase, left + c]), np.int64(work[c + _A])
        write_spatial((a, np.int64(work[c + _B]), np.int64(work[c + _C])), rows, -zero, (phase, left + c), sums)
        power = frames * np.int64(sums.squares[phase, left + c]) - np.int64(sums.low[phase, left + c])
        sums.power[phase, left + c] += np.float64(power - 2 * zero * a + rows * zero * zero)


@njit(cache=True, nogil=True)
def summarize_narrow(
    maps: Maps, band: Band, reference: NDArray[np.float64], sums: ColumnSums, counts: SpreadCounts
) -> None:
    """Sum one band of finished maps, of squares in 32 bits, down its columns, and count D; it ``suits``.

    Parameters
    ----------
    maps, band
        What to sum, and which rows.
    reference
        What S is centred on, whole numbers, shape (cell, width) [DN].
    sums
        Zero so far; written to.
    counts
        Added to.

    """
    cell, width, frames = band.cell, maps.codes.shape[1], maps.frames
    work = np.zeros(_PARTS, np.uint32)
    for left in range(0, width, _COLUMNS):
        right = min(left + _COLUMNS, width)
        for phase in range(cell):
            even, odd = counts.bins[phase * cell], counts.bins[phase * cell + cell - 1]
            own = sums.squares[phase, left:right], sums.low[phase, left:right], sums.quartic[phase, left:right]
            work[:_D] = 0
            rows = rows_of(band, phase)
            fours = rows - rows % _FOUR
            for row in range(0, fours, _FOUR):
                at = band.top + phase + row * cell
                s = _rows_from(maps.codes, at, cell, (left, right))
                q = _rows_from(maps.squares, at, cell, (left, right))
                _write_spreads(s, q, frames, work)
                _run_on(s, work)
                _add_temporal(q, work, own)
                for part in range(_D, _PARTS, _COLUMNS):
                    count_spread(work[part : part + right - left], counts.shift, even, odd)
            for row in range(fours, rows):
                at = band.top + phase + row * cell
                _add_one(maps.codes[at, left:right], maps.squares[at, left:right], frames, work, own)
                count_spread(work[_D : _D + right - left], counts.shift, even, odd)
            _write(work, (phase, left), (frames, rows, right - left), reference, sums)
