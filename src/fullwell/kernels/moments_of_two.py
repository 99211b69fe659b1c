"""Two frames that are all of a series become its sums in one sweep, without maps of single pixels.

Of two frames x and y, the sum over frames is S = x + y, the sum of squares Q = x^2 + y^2, and
D = 2 Q - S^2 = (x - y)^2: nothing needs to be kept of a pixel once its row is passed. Sums are those of `moments` and
`moments_summary`, added up in the same order, so that the bits are the same.
"""

from typing import Final, NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from fullwell.kernels.moments import add_margins, close_tiles, count_codes, count_row, count_rows
from fullwell.kernels.moments_extremes import LIST_ROWS, close_extremes, follow_rows, no_extremes
from fullwell.kernels.moments_summary import (
    ColumnSums,
    Surface,
    add_four_spatial,
    add_four_temporal,
    add_spatial,
    add_temporal,
)
from fullwell.kernels.narrow_of_two import NarrowSums, fits, narrow_sums, sum_narrow, write_column_sums, write_columns
from fullwell.kernels.stack import Band, FrameSums, SeriesSums, Stack, rows_of
from fullwell.kernels.tile_sums import TilePolynomials, TileTotals, centre, column_room, gather

_FEW: Final = 64
"""Codes in a row of tiles up to which those of both frames are counted together."""


class SumsOfTwo(NamedTuple):
    """What two frames are summed up to.

    Parameters
    ----------
    series
        Extremes of tiles and how often they occur; its maps are left alone.
    frames
        Sums over pixels [DN].
    totals
        Sums of tiles.
    differences
        Counts of the absolute difference of the frames, by phase of the row and of the column in a cell of two, shape
        (2, 2, 65536).
    codes
        Counts of the codes of some of the frames, likewise.
    counted
        Places of these frames.

    """

    series: SeriesSums
    frames: FrameSums
    totals: TileTotals
    differences: NDArray[np.int64]
    codes: NDArray[np.int64]
    counted: NDArray[np.int64]


class _FourRows(NamedTuple):
    """S, Q and D of four rows, shape (4, width)."""

    sums: NDArray[np.uint32]
    squares: NDArray[np.uint64]
    spreads: NDArray[np.uint64]


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
def _write_places(x: NDArray[np.uint16], y: NDArray[np.uint16], low: np.uint16, places: NDArray[np.uint16]) -> None:
    """Write the place of each two codes in a table of both."""
    for c in range(x.size):
        places[c] = np.uint16(np.uint16(np.uint16(x[c] - low) * np.uint16(_FEW)) + np.uint16(y[c] - low))


@njit(cache=True, nogil=True)
def _count_together(stack: Stack, band: Band, extremes: tuple[int, int], found: SumsOfTwo) -> None:
    """Count codes and differences of a band of few codes by one table of how often each two codes meet."""
    width, (low, high) = stack.width, extremes
    tables = np.zeros((2, 2, _FEW * _FEW), np.uint32)
    places = np.empty(width, np.uint16)
    for row in range(band.top, band.bottom):
        at = stack.starts + row * width
        x, y = stack.codes[at[0] : at[0] + width], stack.codes[at[1] : at[1] + width]
        _write_places(x, y, np.uint16(low), places)
        count_row(places, tables[row % 2, 0], tables[row % 2, 1])
    for phase in range(2):
        for first in range(2):
            codes, differences = found.codes[phase, first], found.differences[phase, first]
            for i in range(high - low + 1):
                for j in range(high - low + 1):
                    n = np.int64(tables[phase, first, i * _FEW + j])
                    codes[low + i] += n
                    codes[low + j] += n
                    differences[abs(i - j)] += n


@njit(cache=True, nogil=True)
def _count(stack: Stack, band: Band, found: SumsOfTwo) -> None:
    """Count the differences of the frames in a band, and the codes of those whose codes are counted."""
    tile_row = band.top // (band.cell * band.tile)
    low, high = int(found.series.lowest[:, tile_row].min()), int(found.series.highest[:, tile_row].max())
    if found.counted.size == 2 and high - low < _FEW:
        _count_together(stack, band, (low, high), found)
    else:
        _count_differences(stack, band, found.differences)
        count_codes(Stack(stack.codes, stack.starts[found.counted], stack.width), band, found.codes)


@njit(cache=True, nogil=True)
def _combine(x: NDArray[np.uint16], y: NDArray[np.uint16], at: int, rows: _FourRows) -> None:
    sums, squares, spreads = rows.sums[at], rows.squares[at], rows.spreads[at]
    for c in range(x.size):
        i, j = np.int64(x[c]), np.int64(y[c])
        sums[c] = np.uint32(i + j)
        squares[c] = np.uint64(i * i + j * j)
        spreads[c] = np.uint64((i - j) * (i - j))


@njit(cache=True, nogil=True)
def _begin_band(stack: Stack, band: Band, narrow: NarrowSums, series: SeriesSums, frames: FrameSums) -> bool:
    """Add a band to all that needs no more than its codes; return whether ``narrow`` holds all other sums."""
    width, cell = stack.width, band.cell
    columns = np.zeros((2, cell, width), np.uint32)
    extremes = no_extremes(stack, band)
    small = sum_narrow(stack, band, extremes, narrow, frames.rows)
    if small:
        write_columns(narrow, band, columns)
    else:
        extremes = no_extremes(stack, band)
        frames.rows[:, band.top : band.bottom] = 0
        for first in range(band.top, band.bottom, LIST_ROWS * cell):
            last = min(first + LIST_ROWS * cell, band.bottom)
            here = follow_rows(stack, band, first, last, extremes)
            for f in range(2):
                own = stack.codes[stack.starts[f] :]
                for phase in range(cell):
                    add_margins(own, (first + phase, last, cell), here, columns[f, phase], frames.rows[f])
    for f in range(2):
        close_tiles(columns[f], band, frames.columns[f], frames.tiles[f])
    close_extremes(stack, band, extremes, series)
    return small and fits(narrow, band, series)


@njit(cache=True, nogil=True)
def _finish_band(stack: Stack, band: Band, surface: Surface, sums: ColumnSums) -> None:
    """Add a band of any codes to the sums down its columns."""
    width, cell = stack.width, band.cell
    four = _FourRows(np.empty((4, width), np.uint32), np.empty((4, width), np.uint64), np.empty((4, width), np.uint64))
    for phase in range(cell):
        rows = rows_of(band, phase)
        for row in range(rows):
            at = stack.starts + (band.top + phase + row * cell) * width
            x, y = stack.codes[at[0] : at[0] + width], stack.codes[at[1] : at[1] + width]
            _combine(x, y, row % 4, four)
            if row >= rows - rows % 4:
                add_temporal(four.spreads[row % 4], four.squares[row % 4], phase, sums)
                add_spatial(four.sums[row % 4], (phase, row), surface, sums)
            elif row % 4 == 3:
                s, q, d = four.sums, four.squares, four.spreads
                add_four_temporal((d[0], d[1], d[2], d[3]), (q[0], q[1], q[2], q[3]), phase, sums)
                add_four_spatial((s[0], s[1], s[2], s[3]), (phase, row - 3), surface, sums)


@njit(cache=True, nogil=True)
def sum_two(stack: Stack, rows: Band, polynomials: TilePolynomials, found: SumsOfTwo) -> None:
    """Sum some rows of tiles of two frames.

    Parameters
    ----------
    stack
        The two frames.
    rows
        Which rows, and the size of cells and tiles.
    polynomials
        Along the axes of tiles.
    found
        Added to; sums of tiles are written.

    """
    width, cell, step = stack.width, rows.cell, rows.cell * rows.tile
    reference, narrow = np.zeros((cell, width)), narrow_sums(cell, width)
    for top in range(rows.top, rows.bottom, step):
        band = Band(top, min(top + step, rows.bottom), cell, rows.tile)
        small = _begin_band(stack, band, narrow, found.series, found.frames)
        centre(found.frames.tiles, band, reference)
        sums = column_room(cell, width)
        if small:
            write_column_sums(narrow, band, reference, sums)
        else:
            down = polynomials.down[:, top // step]
            _finish_band(stack, band, Surface(reference, down[0], down[1]), sums)
        gather(sums, band, polynomials.across, found.totals)
        _count(stack, band, found)
