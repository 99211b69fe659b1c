"""Two frames that are all of a series become its sums in one sweep, without maps of single pixels.

Of two frames x and y, the sum over frames is S = x + y, the sum of squares Q = x^2 + y^2, and
D = 2 Q - S^2 = (x - y)^2: nothing needs to be kept of a pixel once its row is passed. Sums are those of `moments` and
`moments_summary`, added up in the same order, so that the bits are the same.
"""

from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from fullwell.kernels.moments import add_margins, close_tiles, count_row, count_rows
from fullwell.kernels.moments_extremes import LIST_ROWS, close_extremes, follow_rows, no_extremes
from fullwell.kernels.moments_summary import (
    ColumnSums,
    Surface,
    add_four_spatial,
    add_four_temporal,
    add_spatial,
    add_temporal,
)
from fullwell.kernels.stack import Band, FrameSums, SeriesSums, Stack

_NARROW = 16383
"""Four sums of squares of two codes up to here fit in 32 bits."""


class SumsOfTwo(NamedTuple):
    """What two frames are summed up to.

    Parameters
    ----------
    series
        Extremes of tiles and how often they occur; its maps are left alone.
    frames
        Sums over pixels [DN].
    columns
        Sums down the columns of each band, shape (bands, cell, width).
    differences
        Counts of the absolute difference of the frames, by phase of the row and of the column in a cell of two, shape
        (2, 2, 65536).

    """

    series: SeriesSums
    frames: FrameSums
    columns: ColumnSums
    differences: NDArray[np.int64]


class _Wide(NamedTuple):
    """S, Q and D of four rows, shape (4, width)."""

    sums: NDArray[np.uint32]
    squares: NDArray[np.uint64]
    spreads: NDArray[np.uint64]


class _Narrow(NamedTuple):
    """The same of codes up to ``_NARROW``."""

    sums: NDArray[np.int32]
    squares: NDArray[np.int32]
    spreads: NDArray[np.int32]


@njit(cache=True, nogil=True)
def _write_differences(x: NDArray[np.uint16], y: NDArray[np.uint16], out: NDArray[np.uint16]) -> None:
    """Write the absolute difference of the frames in a row."""
    for c in range(x.size):
        out[c] = np.uint16(max(x[c], y[c]) - min(x[c], y[c]))


@njit(cache=True, nogil=True)
def _count_differences(stack: Stack, band: Band, counts: NDArray[np.int64]) -> None:
    """Count the absolute differences of the frames in a band, by phase in a cell of two."""
    width = stack.width
    buffer = np.empty((2, width), np.uint16)
    for row in range(band.top, band.bottom):
        at = stack.starts + row * width
        x, y = stack.codes[at[0] : at[0] + width], stack.codes[at[1] : at[1] + width]
        _write_differences(x, y, buffer[(row - band.top) % 2])
        if (row - band.top) % 2:
            count_rows(buffer[0], buffer[1], counts[1 - row % 2], counts[row % 2])
    if (band.bottom - band.top) % 2:
        last = counts[(band.bottom - 1) % 2]
        count_row(buffer[0], last[0], last[1])


@njit(cache=True, nogil=True)
def _combine_wide(x: NDArray[np.uint16], y: NDArray[np.uint16], at: int, rows: _Wide) -> None:
    sums, squares, spreads = rows.sums[at], rows.squares[at], rows.spreads[at]
    for c in range(x.size):
        i, j = np.int64(x[c]), np.int64(y[c])
        sums[c] = np.uint32(i + j)
        squares[c] = np.uint64(i * i + j * j)
        spreads[c] = np.uint64((i - j) * (i - j))


@njit(cache=True, nogil=True)
def _combine_narrow(x: NDArray[np.uint16], y: NDArray[np.uint16], at: int, rows: _Narrow) -> None:
    sums, squares, spreads = rows.sums[at], rows.squares[at], rows.spreads[at]
    for c in range(x.size):
        i, j = np.int32(x[c]), np.int32(y[c])
        sums[c] = np.int32(i + j)
        difference = np.int32(i - j)
        spreads[c] = np.int32(difference * difference)
    for c in range(x.size):
        i, j = np.int32(x[c]), np.int32(y[c])
        squares[c] = np.int32(np.int32(i * i) + np.int32(j * j))


@njit(cache=True, nogil=True)
def _add_four_wide(rows: _Wide, at: tuple[int, int], surface: Surface, sums: ColumnSums) -> None:
    s, q, d = rows.sums, rows.squares, rows.spreads
    add_four_temporal((d[0], d[1], d[2], d[3]), (q[0], q[1], q[2], q[3]), at[0], sums)
    add_four_spatial((s[0], s[1], s[2], s[3]), at, surface, sums)


@njit(cache=True, nogil=True)
def _add_four_narrow(rows: _Narrow, at: tuple[int, int], surface: Surface, sums: ColumnSums) -> None:
    phase, s = at[0], rows.sums
    totals, low, quartic = sums.squares[phase], sums.low[phase], sums.quartic[phase]
    q_i, q_j, q_k, q_m = rows.squares[0], rows.squares[1], rows.squares[2], rows.squares[3]
    i, j, k, m = rows.spreads[0], rows.spreads[1], rows.spreads[2], rows.spreads[3]
    for c in range(totals.size):
        pairs = np.uint32(np.uint32(q_i[c]) + np.uint32(q_j[c])), np.uint32(np.uint32(q_k[c]) + np.uint32(q_m[c]))
        totals[c] += np.uint64(np.uint32(pairs[0] + pairs[1]))
    for c in range(totals.size):
        pairs = np.uint32(np.uint32(i[c]) + np.uint32(j[c])), np.uint32(np.uint32(k[c]) + np.uint32(m[c]))
        low[c] += np.uint64(np.uint32(pairs[0] + pairs[1]))
    for c in range(totals.size):
        first, second, third, fourth = np.float64(i[c]), np.float64(j[c]), np.float64(k[c]), np.float64(m[c])
        quartic[c] += (first * first + second * second) + (third * third + fourth * fourth)
    add_four_spatial((s[0], s[1], s[2], s[3]), at, surface, sums)


@njit(cache=True, nogil=True)
def _begin_band(stack: Stack, band: Band, series: SeriesSums, frames: FrameSums) -> bool:
    """Add a band to all that needs no more than its codes; return whether these are at most ``_NARROW``."""
    width, cell = stack.width, band.cell
    extremes, highest = no_extremes(stack, band), 0
    columns = np.zeros((2, cell, width), np.uint32)
    for first in range(band.top, band.bottom, LIST_ROWS * cell):
        last = min(first + LIST_ROWS * cell, band.bottom)
        here = follow_rows(stack, band, first, last, extremes)
        highest = max(highest, here)
        for f in range(2):
            own = stack.codes[stack.starts[f] :]
            for phase in range(cell):
                add_margins(own, (first + phase, last, cell), here, columns[f, phase], frames.rows[f])
    for f in range(2):
        close_tiles(columns[f], band, frames.columns[f], frames.tiles[f])
    close_extremes(stack, band, extremes, series)
    return highest <= _NARROW


@njit(cache=True, nogil=True)
def _centre(tiles: NDArray[np.uint64], band: Band, reference: NDArray[np.float64]) -> None:
    """Write the rounded mean of each tile of a band, summed over frames, to its columns.

    Parameters
    ----------
    tiles
        Sums of each frame, shape (frames, sites, tile rows, tile columns).
    band
        Which tiles.
    reference
        Shape (cell, width), written to.

    """
    cell, step, width = band.cell, band.cell * band.tile, reference.shape[1]
    for phase in range(cell):
        rows = max(0, (band.bottom - band.top - phase + cell - 1) // cell)
        for first in range(cell):
            sums = tiles[:, phase * cell + first, band.top // step]
            for tile in range(-(-width // step)):
                last = min((tile + 1) * step, width)
                n = rows * max(0, (last - tile * step - first + cell - 1) // cell)
                mean = np.rint(np.float64(sums[0, tile] + sums[1, tile]) / np.float64(n)) if n > 0 else 0.0
                reference[phase, tile * step + first : last : cell] = mean


@njit(cache=True, nogil=True)
def _finish_band(stack: Stack, band: Band, surface: Surface, sums: ColumnSums, narrow: bool) -> None:  # noqa: FBT001 - compiled functions take their arguments by position
    """Add a band to the sums down its columns."""
    width, cell = stack.width, band.cell
    wide_rows = _Wide(np.empty((4, width), np.uint32), np.empty((4, width), np.uint64), np.empty((4, width), np.uint64))
    narrow_rows = _Narrow(
        np.empty((4, width), np.int32), np.empty((4, width), np.int32), np.empty((4, width), np.int32)
    )
    for phase in range(cell):
        rows = max(0, (band.bottom - band.top - phase + cell - 1) // cell)
        fours = rows - rows % 4
        for row in range(rows):
            at = stack.starts + (band.top + phase + row * cell) * width
            x, y = stack.codes[at[0] : at[0] + width], stack.codes[at[1] : at[1] + width]
            if narrow and row < fours:
                _combine_narrow(x, y, row % 4, narrow_rows)
            else:
                _combine_wide(x, y, row % 4, wide_rows)
            if row >= fours:
                add_temporal(wide_rows.spreads[row % 4], wide_rows.squares[row % 4], phase, sums)
                add_spatial(wide_rows.sums[row % 4], (phase, row), surface, sums)
            elif row % 4 == 3 and narrow:
                _add_four_narrow(narrow_rows, (phase, row - 3), surface, sums)
            elif row % 4 == 3:
                _add_four_wide(wide_rows, (phase, row - 3), surface, sums)


@njit(cache=True, nogil=True)
def sum_two(stack: Stack, whole: Band, polynomials: NDArray[np.float64], found: SumsOfTwo) -> None:
    """Sum two frames.

    Parameters
    ----------
    stack
        The two frames.
    whole
        All rows, and the size of cells and tiles.
    polynomials
        Linear and quadratic polynomial of the row within its tile, by band and phase, shape (2, bands, cell, rows).
    found
        Added to.

    """
    width, cell, step, sums = stack.width, whole.cell, whole.cell * whole.tile, found.columns
    reference = np.zeros((cell, width))
    for index in range(sums.squares.shape[0]):
        band = Band(index * step, min((index + 1) * step, whole.bottom), cell, whole.tile)
        narrow = _begin_band(stack, band, found.series, found.frames)
        _centre(found.frames.tiles, band, reference)
        own = ColumnSums(
            sums.squares[index],
            sums.low[index],
            sums.high[index],
            sums.quartic[index],
            sums.centred[index],
            sums.linear[index],
            sums.quadratic[index],
            sums.power[index],
        )
        _finish_band(stack, band, Surface(reference, polynomials[0, index], polynomials[1, index]), own, narrow)
        _count_differences(stack, band, found.differences)
