"""A row of tiles of two frames, summed in whole numbers of 16 and 32 bits where the codes are small enough.

Of each pixel, t = x + y - r is taken, with r near the mean of its tile, and d = |x - y|. Down a column of n rows the
running sums ``A += t``, ``B += A``, ``C += B`` come to sums of t times 1, m and m (m + 1) / 2, where m counts rows from
below, n to 1: any quadratic polynomial of the row is made of them afterwards, in whole numbers (`write_column_sums`).
`fits` tells from the extremes of the tiles whether a sum may have left its width.

What is kept of some columns lies in one array, in parts of a constant size: so the compiler sees that they do not
overlap, and works on 8 or 16 columns at once.
"""

from typing import Final, NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from fullwell.kernels.moments_extremes import FOUR, LIST_ROWS, Extremes
from fullwell.kernels.moments_rows import Rows, add_row_sum
from fullwell.kernels.moments_summary import ColumnSums
from fullwell.kernels.narrow_summary import write_spatial
from fullwell.kernels.stack import Band, SeriesSums, Stack, rows_of

_COLUMNS: Final = 512
"""Columns that are summed together: few enough that all that is kept of them stays in the nearest cache."""
_HIGHEST: Final = 16383
"""Largest code whose t has room in 16 bits, and the sum of four of which has."""

# Parts of what is kept in 16 bits: r, extremes, the sum of four rows of x, and t and d of four rows.
_R: Final = 0
_LOW: Final = _COLUMNS
_HIGH: Final = 2 * _COLUMNS
_X: Final = 3 * _COLUMNS
_T: Final = 4 * _COLUMNS
_D: Final = 8 * _COLUMNS
_CODES: Final = 12 * _COLUMNS
# Parts of what is kept in 32 bits: A, B, C, and the sums of x, t^2 and d^2.
_A: Final = 0
_B: Final = _COLUMNS
_C: Final = 2 * _COLUMNS
_FIRST: Final = 3 * _COLUMNS
_POWER: Final = 4 * _COLUMNS
_SPREAD: Final = 5 * _COLUMNS
_SUMS: Final = 6 * _COLUMNS

_Work = tuple[NDArray[np.uint16], NDArray[np.uint32], NDArray[np.uint64]]


class NarrowSums(NamedTuple):
    """Sums down the columns of a row of tiles, by phase of the row, shape (cell, width).

    Parameters
    ----------
    reference
        r [DN].
    first
        Sum of x.
    running
        A, B and C, shape (3, cell, width).
    power, spread, quartic
        Sums of t^2, d^2 and d^4.

    """

    reference: NDArray[np.uint16]
    first: NDArray[np.uint32]
    running: NDArray[np.int32]
    power: NDArray[np.uint32]
    spread: NDArray[np.uint32]
    quartic: NDArray[np.uint64]


@njit(cache=True, nogil=True)
def narrow_sums(cell: int, width: int) -> NarrowSums:
    """Return room for the sums of a row of tiles."""
    return NarrowSums(
        np.zeros((cell, width), np.uint16),
        np.zeros((cell, width), np.uint32),
        np.zeros((3, cell, width), np.int32),
        np.zeros((cell, width), np.uint32),
        np.zeros((cell, width), np.uint32),
        np.zeros((cell, width), np.uint64),
    )


@njit(cache=True, nogil=True)
def _take_four(x: Rows, y: Rows, codes: NDArray[np.uint16]) -> None:
    """Write t and d of four rows and the sum of x, and follow the extremes."""
    i, j, k, m = x
    p, q, s, u = y
    for c in range(i.size):
        r = codes[c + _R]
        codes[c + _T] = np.uint16(np.uint16(i[c] + p[c]) - r)
        codes[c + _T + _COLUMNS] = np.uint16(np.uint16(j[c] + q[c]) - r)
        codes[c + _T + 2 * _COLUMNS] = np.uint16(np.uint16(k[c] + s[c]) - r)
        codes[c + _T + 3 * _COLUMNS] = np.uint16(np.uint16(m[c] + u[c]) - r)
        low_i, low_j, low_k, low_m = min(i[c], p[c]), min(j[c], q[c]), min(k[c], s[c]), min(m[c], u[c])
        top_i, top_j, top_k, top_m = max(i[c], p[c]), max(j[c], q[c]), max(k[c], s[c]), max(m[c], u[c])
        codes[c + _D] = np.uint16(top_i - low_i)
        codes[c + _D + _COLUMNS] = np.uint16(top_j - low_j)
        codes[c + _D + 2 * _COLUMNS] = np.uint16(top_k - low_k)
        codes[c + _D + 3 * _COLUMNS] = np.uint16(top_m - low_m)
        codes[c + _LOW] = min(codes[c + _LOW], min(min(low_i, low_j), min(low_k, low_m)))  # noqa: PLW3301 - pairs compile to vector minima
        codes[c + _HIGH] = max(codes[c + _HIGH], max(max(top_i, top_j), max(top_k, top_m)))  # noqa: PLW3301 - pairs compile to vector maxima
        codes[c + _X] = np.uint16(np.uint16(i[c] + j[c]) + np.uint16(k[c] + m[c]))


@njit(cache=True, nogil=True)
def _take_one(x: NDArray[np.uint16], y: NDArray[np.uint16], codes: NDArray[np.uint16]) -> None:
    """Do so with a single row."""
    for c in range(x.size):
        low, top = min(x[c], y[c]), max(x[c], y[c])
        codes[c + _T] = np.uint16(np.uint16(x[c] + y[c]) - codes[c + _R])
        codes[c + _D] = np.uint16(top - low)
        codes[c + _LOW] = min(codes[c + _LOW], low)
        codes[c + _HIGH] = max(codes[c + _HIGH], top)
        codes[c + _X] = x[c]


@njit(cache=True, nogil=True)
def _run_on(codes: NDArray[np.uint16], sums: NDArray[np.uint32], n: int, rows: int) -> None:
    """Bring the running sums of n columns, and the sum of x, past one row or four."""
    for c in range(n):
        a = np.uint32(sums[c + _A] + np.uint32(np.int16(codes[c + _T])))
        b = np.uint32(sums[c + _B] + a)
        e = np.uint32(sums[c + _C] + b)
        if rows == FOUR:
            a = np.uint32(a + np.uint32(np.int16(codes[c + _T + _COLUMNS])))
            b = np.uint32(b + a)
            e = np.uint32(e + b)
            a = np.uint32(a + np.uint32(np.int16(codes[c + _T + 2 * _COLUMNS])))
            b = np.uint32(b + a)
            e = np.uint32(e + b)
            a = np.uint32(a + np.uint32(np.int16(codes[c + _T + 3 * _COLUMNS])))
            b = np.uint32(b + a)
            e = np.uint32(e + b)
        sums[c + _A] = a
        sums[c + _B] = b
        sums[c + _C] = e
        sums[c + _FIRST] = np.uint32(sums[c + _FIRST] + np.uint32(codes[c + _X]))


@njit(cache=True, nogil=True)
def _square_four(codes: NDArray[np.uint16], sums: NDArray[np.uint32], quartic: NDArray[np.uint64], n: int) -> None:
    """Add the squares of t and d of four rows of n columns, and the fourth power of d."""
    for c in range(n):
        i, j = np.int32(np.int16(codes[c + _T])), np.int32(np.int16(codes[c + _T + _COLUMNS]))
        k, m = np.int32(np.int16(codes[c + _T + 2 * _COLUMNS])), np.int32(np.int16(codes[c + _T + 3 * _COLUMNS]))
        pair, other = np.int32(np.int32(i * i) + np.int32(j * j)), np.int32(np.int32(k * k) + np.int32(m * m))
        sums[c + _POWER] = np.uint32(sums[c + _POWER] + np.uint32(np.int32(pair + other)))
    for c in range(n):
        i, j = np.int32(np.int16(codes[c + _D])), np.int32(np.int16(codes[c + _D + _COLUMNS]))
        k, m = np.int32(np.int16(codes[c + _D + 2 * _COLUMNS])), np.int32(np.int16(codes[c + _D + 3 * _COLUMNS]))
        pair, other = np.int32(np.int32(i * i) + np.int32(j * j)), np.int32(np.int32(k * k) + np.int32(m * m))
        sums[c + _SPREAD] = np.uint32(sums[c + _SPREAD] + np.uint32(np.int32(pair + other)))
    for c in range(n):
        i, j = np.uint64(codes[c + _D]), np.uint64(codes[c + _D + _COLUMNS])
        k, m = np.uint64(codes[c + _D + 2 * _COLUMNS]), np.uint64(codes[c + _D + 3 * _COLUMNS])
        i, j, k, m = i * i, j * j, k * k, m * m
        quartic[c] += (i * i + j * j) + (k * k + m * m)


@njit(cache=True, nogil=True)
def _square_one(codes: NDArray[np.uint16], sums: NDArray[np.uint32], quartic: NDArray[np.uint64], n: int) -> None:
    """Do so with a single row."""
    for c in range(n):
        t, d = np.int64(np.int16(codes[c + _T])), np.uint64(codes[c + _D])
        sums[c + _POWER] = np.uint32(sums[c + _POWER] + np.uint32(t * t))
        sums[c + _SPREAD] = np.uint32(sums[c + _SPREAD] + np.uint32(d * d))
        quartic[c] += (d * d) * (d * d)


@njit(cache=True, nogil=True)
def _rows_from(stack: Stack, at: int, apart: int, n: int) -> Rows:
    """Return n columns of four rows that are ``apart``, from a place in the block on."""
    i, j, k, m = at, at + apart, at + 2 * apart, at + 3 * apart
    return stack.codes[i : i + n], stack.codes[j : j + n], stack.codes[k : k + n], stack.codes[m : m + n]


@njit(cache=True, nogil=True)
def _keep(work: _Work, at: tuple[int, int], n: int, sums: NarrowSums) -> None:
    """Put what n columns of a phase came to where it belongs."""
    phase, left = at
    _, wide, quartic = work
    for part, start in ((0, _A), (1, _B), (2, _C)):
        for c in range(n):
            sums.running[part, phase, left + c] = np.int32(wide[start + c])
    sums.first[phase, left : left + n] = wide[_FIRST : _FIRST + n]
    sums.power[phase, left : left + n] = wide[_POWER : _POWER + n]
    sums.spread[phase, left : left + n] = wide[_SPREAD : _SPREAD + n]
    sums.quartic[phase, left : left + n] = quartic[:n]


@njit(cache=True, nogil=True)
def _sum_columns(stack: Stack, band: Band, at: tuple[int, int], work: _Work, found: tuple[Extremes, NarrowSums]) -> int:
    """Sum some columns of a row of tiles of one phase; return the highest code there."""
    (phase, left), (extremes, sums) = at, found
    codes, wide, quartic = work
    n = min(_COLUMNS, stack.width - left)
    apart = band.cell * stack.width
    wide[:] = 0
    quartic[:] = 0
    codes[_R : _R + n] = sums.reference[phase, left : left + n]
    rows = rows_of(band, phase)
    begin = (band.top + phase) * stack.width + left
    for first in range(0, rows, LIST_ROWS):
        codes[_LOW : _LOW + n] = np.uint16(65535)
        codes[_HIGH : _HIGH + n] = np.uint16(0)
        row, last = first, min(first + LIST_ROWS, rows)
        while row < last:
            x, y = stack.starts[0] + begin + row * apart, stack.starts[1] + begin + row * apart
            if row + FOUR <= last:
                _take_four(_rows_from(stack, x, apart, n), _rows_from(stack, y, apart, n), codes)
                _run_on(codes, wide, n, FOUR)
                _square_four(codes, wide, quartic, n)
                row += FOUR
            else:
                _take_one(stack.codes[x : x + n], stack.codes[y : y + n], codes)
                _run_on(codes, wide, n, 1)
                _square_one(codes, wide, quartic, n)
                row += 1
        extremes.lowest[phase, first // LIST_ROWS, left : left + n] = codes[_LOW : _LOW + n]
        extremes.highest[phase, first // LIST_ROWS, left : left + n] = codes[_HIGH : _HIGH + n]
    _keep(work, at, n, sums)
    return int(extremes.highest[phase, :, left : left + n].max())


@njit(cache=True, nogil=True)
def _write_references(stack: Stack, band: Band, reference: NDArray[np.uint16]) -> None:
    """Write, for each tile and site, the mean of x + y in its first row."""
    width, step = stack.width, band.cell * band.tile
    for phase in range(min(band.cell, band.bottom - band.top)):
        at = stack.starts + (band.top + phase) * width
        for left in range(0, width, step):
            for first in range(left, min(left + band.cell, width)):
                total, n = 0, 0
                for c in range(first, min(left + step, width), band.cell):
                    total += int(stack.codes[at[0] + c]) + int(stack.codes[at[1] + c])
                    n += 1
                reference[phase, first : min(left + step, width) : band.cell] = np.uint16(total // n)


@njit(cache=True, nogil=True)
def sum_narrow(stack: Stack, band: Band, extremes: Extremes, sums: NarrowSums, rows: NDArray[np.uint64]) -> bool:
    """Sum a row of tiles of two frames.

    Parameters
    ----------
    stack
        The frames.
    band
        Which rows.
    extremes, sums
        Written to.
    rows
        Sums of rows by frame, mosaic row and phase of the column, shape (2, height, cell); those of the band are
        written.

    Returns
    -------
    bool
        False where a code is too large; what was written says nothing then.

    """
    work = np.zeros(_CODES, np.uint16), np.zeros(_SUMS, np.uint32), np.zeros(_COLUMNS, np.uint64)
    _write_references(stack, band, sums.reference)
    for left in range(0, stack.width, _COLUMNS):
        for phase in range(band.cell):
            if _sum_columns(stack, band, (phase, left), work, (extremes, sums)) > _HIGHEST:
                return False
    for f in range(2):
        for row in range(band.top, band.bottom):
            at = stack.starts[f] + row * stack.width
            rows[f, row] = 0
            add_row_sum(stack.codes[at : at + stack.width], rows[f, row])
    return True


@njit(cache=True, nogil=True)
def write_columns(sums: NarrowSums, band: Band, columns: NDArray[np.uint32]) -> None:
    """Write the sum of each column of x and of y, shape (2, cell, width)."""
    for phase in range(band.cell):
        rows = rows_of(band, phase)
        for c in range(columns.shape[2]):
            both = np.int64(sums.running[0, phase, c]) + rows * np.int64(sums.reference[phase, c])
            columns[0, phase, c] = sums.first[phase, c]
            columns[1, phase, c] = np.uint32(both - np.int64(sums.first[phase, c]))


@njit(cache=True, nogil=True)
def fits(sums: NarrowSums, band: Band, series: SeriesSums) -> bool:
    """Return whether every sum of a row of tiles has kept its width, from the extremes of its tiles.

    Fourth powers of d must also add up to less than 2^53, and the number of rows not be a multiple of 3: sums in
    floating point, which other ways to the same numbers take, are exact then too.
    """
    step = band.cell * band.tile
    at, width = band.top // step, sums.first.shape[1]
    for phase in range(band.cell):
        rows = rows_of(band, phase)
        if rows > 0 and rows % 3 == 0:
            return False
        for left in range(0, width, step):
            for first in range(left, min(left + band.cell, width)):
                site = phase * band.cell + first - left
                low, high = int(series.lowest[site, at, left // step]), int(series.highest[site, at, left // step])
                r, d = int(sums.reference[phase, first]), high - low
                t = max(2 * high - r, r - 2 * low)
                cubic = rows * (rows + 1) * (rows + 2) // 6
                if t * cubic >= 2**31 or rows * t * t >= 2**32 or rows * d * d >= 2**32 or rows * d**4 >= 2**53:
                    return False
    return True


@njit(cache=True, nogil=True)
def write_column_sums(sums: NarrowSums, band: Band, centre: NDArray[np.float64], out: ColumnSums) -> None:
    """Write what a row of tiles comes to, centred anew.

    Parameters
    ----------
    sums, band
        What was summed up.
    centre
        What x + y is centred on, whole numbers, shape (cell, width) [DN].
    out
        Added to.

    """
    for phase in range(band.cell):
        n = rows_of(band, phase)
        for c in range(centre.shape[1]):
            r, spread = np.int64(sums.reference[phase, c]), np.int64(sums.spread[phase, c])
            a, b = np.int64(sums.running[0, phase, c]), np.int64(sums.running[1, phase, c])
            e, power = np.int64(sums.running[2, phase, c]), np.int64(sums.power[phase, c])
            squares = (power + 2 * r * a + n * r * r + spread) // 2
            out.squares[phase, c] += np.uint64(squares)
            out.low[phase, c] += np.uint64(spread)
            out.quartic[phase, c] += np.float64(sums.quartic[phase, c])
            moved = r - np.int64(centre[phase, c])
            write_spatial((a, b, e), n, moved, (phase, c), out)
            out.power[phase, c] += np.float64(power + 2 * moved * a + n * moved * moved)
