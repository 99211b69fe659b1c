"""Frames become exact integer sums in one sweep over the pixels, a row of tiles at a time.

A mosaic's planes are the sites of its repeating cell, row-major: four for Bayer (cell 2), one for mono (cell 1). A row
of tiles of all planes together, ``tile * cell`` mosaic rows, or a strip of some of them is a *band*: the unit of work,
so that every pixel of every frame is read once and the maps are touched once for all the frames at hand. Everything is
an integer, so bands and frames may come in any order. `moments_reference` says the same in plain NumPy.
"""

import numpy as np
from numba import njit
from numpy.typing import NDArray

from fullwell.kernels.moments_extremes import FOUR, LIST_ROWS, close_extremes, follow_rows, four_rows, no_extremes
from fullwell.kernels.moments_rows import (
    LARGEST_NARROW,
    add_columns,
    add_columns_of_four,
    add_four,
    add_four_narrow,
    add_one,
    add_one_narrow,
    add_row_sum,
    add_to_maps,
    flush_columns,
    frames_in_32_bits,
    rows_in_16_bits,
    widen_row,
)
from fullwell.kernels.stack import WIDE, Band, FrameSums, SeriesSums, Stack

MOST_HELD = 0xFFFFFFFF
_Narrow = tuple[NDArray[np.uint32], NDArray[np.uint32]]


@njit(cache=True, nogil=True)
def _add_tiles(columns: NDArray[np.uint32], step: int, even: NDArray[np.uint64], odd: NDArray[np.uint64]) -> None:
    """Add column sums to those of tiles ``step`` columns wide, an even number, by phase of the column."""
    for tile in range(even.size):
        own = columns[tile * step : (tile + 1) * step]
        first, second = np.uint64(0), np.uint64(0)
        for c in range(own.size // 2):
            first += np.uint64(own[2 * c])
            second += np.uint64(own[2 * c + 1])
        even[tile] += first
        odd[tile] += second
        if own.size % 2:
            even[tile] += np.uint64(own[own.size - 1])


@njit(cache=True, nogil=True)
def _add_plain_tiles(columns: NDArray[np.uint32], step: int, tiles: NDArray[np.uint64]) -> None:
    """Add column sums to those of tiles ``step`` columns wide."""
    for tile in range(tiles.size):
        own = columns[tile * step : (tile + 1) * step]
        total = np.uint64(0)
        for c in range(own.size):
            total += np.uint64(own[c])
        tiles[tile] += total


@njit(cache=True, nogil=True)
def _widen(columns: NDArray[np.uint32], sums: NDArray[np.uint64]) -> None:
    """Add sums of 32 bits to those of 64."""
    for c in range(columns.size):
        sums[c] = sums[c] + np.uint64(columns[c])


@njit(cache=True, nogil=True)
def close_tiles(columns: NDArray[np.uint32], band: Band, sums: NDArray[np.uint64], tiles: NDArray[np.uint64]) -> None:
    """Gather a band's column sums of one frame into ``tiles``, shape (sites, tile rows, tile columns)."""
    cell, step = band.cell, band.cell * band.tile
    tile_row = band.top // step
    for phase in range(cell):
        if cell == 1:
            _add_plain_tiles(columns[phase], step, tiles[0, tile_row])
        else:
            _add_tiles(columns[phase], step, tiles[2 * phase, tile_row], tiles[2 * phase + 1, tile_row])
        _widen(columns[phase], sums[phase])


@njit(cache=True, nogil=True)
def _holds(series: SeriesSums, rows: tuple[int, int], highest: int, count: int) -> bool:
    """Make room for some frames in some rows of the maps; tell whether squares are summed in 32 bits there."""
    first, last = rows
    held = series.held[first]
    if held == WIDE:
        return False
    more = highest * highest * count
    fits = highest <= LARGEST_NARROW and held + more <= MOST_HELD
    if held == 0:
        series.codes[first:last] = 0
        if fits:
            series.squares[first:last] = 0
        else:
            series.wide[first:last] = 0
    elif not fits:
        for row in range(first, last):
            widen_row(series.squares[row], series.wide[row])
    series.held[first:last] = held + more if fits else WIDE
    return fits


@njit(cache=True, nogil=True)
def _add_narrow_row(stack: Stack, row: int, codes: NDArray[np.uint32], squares: NDArray[np.uint32]) -> None:
    """Add a row of every frame to sums of 32 bits."""
    count = stack.starts.size
    at = stack.starts + row * stack.width
    fours = count - count % FOUR
    for f in range(0, fours, FOUR):
        add_four_narrow(four_rows(stack, at, f), codes, squares)
    for f in range(fours, count):
        add_one_narrow(stack.codes[at[f] : at[f] + stack.width], codes, squares)


@njit(cache=True, nogil=True)
def _add_wide_row(stack: Stack, row: int, series: SeriesSums, narrow: _Narrow, room: int) -> None:
    """Add a row of every frame to the maps of 64 bits: by sums of 32 that hold ``room`` frames, if four."""
    count = stack.starts.size
    codes, squares = series.codes[row], series.wide[row]
    at = stack.starts + row * stack.width
    most = min(room, count) if room >= FOUR else count
    for first in range(0, count, most):
        last = min(first + most, count)
        fours = last - (last - first) % FOUR
        if room >= FOUR:
            narrow[0][:] = 0
            narrow[1][:] = 0
            for f in range(first, fours, FOUR):
                add_four_narrow(four_rows(stack, at, f), narrow[0], narrow[1])
            for f in range(fours, last):
                add_one_narrow(stack.codes[at[f] : at[f] + stack.width], narrow[0], narrow[1])
            add_to_maps(narrow, codes, squares)
        else:
            for f in range(first, fours, FOUR):
                add_four(four_rows(stack, at, f), codes, squares)
            for f in range(fours, last):
                add_one(stack.codes[at[f] : at[f] + stack.width], codes, squares)


@njit(cache=True, nogil=True)
def add_margins(
    frame: NDArray[np.uint16],
    rows: tuple[int, int, int],
    highest: int,
    columns: NDArray[np.uint32],
    sums: NDArray[np.uint64],
) -> None:
    """Add rows of one frame, of one phase, to its column sums, and their sums by phase of the column to ``sums``.

    Parameters
    ----------
    frame
        Its pixels, shape (anything,); rows follow without gaps [DN].
    rows
        The first, one past the last, and the step between them [mosaic row].
    highest
        No code of these rows is larger [DN].
    columns
        Shape (width,), added to [DN].
    sums
        By mosaic row and phase of the column, shape (height, cell), added to [DN].

    """
    first, last, step = rows
    width = columns.size
    narrow = np.zeros(width, np.uint16)
    room = rows_in_16_bits(highest, last)
    held, row = 0, first
    while row < last:
        at = row * width
        four = row + (FOUR - 1) * step < last and room >= FOUR
        taken = FOUR if four else 1
        if held + taken > room:
            flush_columns(narrow, columns)
            held = 0
        if four:
            apart = step * width
            add_columns_of_four(
                (
                    frame[at : at + width],
                    frame[at + apart : at + apart + width],
                    frame[at + 2 * apart : at + 2 * apart + width],
                    frame[at + 3 * apart : at + 3 * apart + width],
                ),
                narrow,
            )
        else:
            add_columns(frame[at : at + width], narrow)
        for k in range(taken):
            begin = at + k * step * width
            add_row_sum(frame[begin : begin + width], sums[row + k * step])
        held += taken
        row += taken * step
    flush_columns(narrow, columns)


@njit(cache=True, nogil=True)
def add_band(stack: Stack, band: Band, series: SeriesSums, frames: FrameSums) -> None:
    """Add one band of every frame of the stack to the sums of the series, and to the sums of each frame.

    A few rows at a time, so that they stay in the cache: their extremes come first, which tell how wide sums must be.

    Parameters
    ----------
    stack
        Frames.
    band
        Which rows.
    series
        Sums over frames [DN, DN^2], added to.
    frames
        Sums over pixels [DN], added to.

    """
    width, count, cell = stack.width, stack.starts.size, band.cell
    extremes = no_extremes(stack, band)
    narrow = np.empty(width, np.uint32), np.empty(width, np.uint32)
    for first in range(band.top, band.bottom, LIST_ROWS * cell):
        last = min(first + LIST_ROWS * cell, band.bottom)
        highest = follow_rows(stack, band, first, last, extremes)
        if _holds(series, (first, last), highest, count):
            for row in range(first, last):
                _add_narrow_row(stack, row, series.codes[row], series.squares[row])
        else:
            room = frames_in_32_bits(highest, count)
            for row in range(first, last):
                _add_wide_row(stack, row, series, narrow, room)
        for f in range(count):
            own = stack.codes[stack.starts[f] + first * width :]
            for phase in range(cell):
                add_margins(own, (phase, last - first, cell), highest, frames.open[f, phase], frames.rows[f, first:])
    if band.bottom % (cell * band.tile) == 0 or band.bottom == frames.rows.shape[1]:
        for f in range(count):
            close_tiles(frames.open[f], band, frames.columns[f], frames.tiles[f])
        frames.open[:] = 0
    close_extremes(stack, band, extremes, series)


@njit(cache=True, nogil=True)
def count_row(x: NDArray[np.uint16], even: NDArray[np.int64], odd: NDArray[np.int64]) -> None:
    """Count the codes of a row, by phase of the column."""
    for c in range(x.size // 2):
        even[x[2 * c]] += 1
        odd[x[2 * c + 1]] += 1
    if x.size % 2:
        even[x[x.size - 1]] += 1


@njit(cache=True, nogil=True)
def count_rows(x: NDArray[np.uint16], y: NDArray[np.uint16], of_x: NDArray[np.int64], of_y: NDArray[np.int64]) -> None:
    """Count the codes of two rows side by side: a code that comes again waits for its own count alone.

    Parameters
    ----------
    x, y
        The rows.
    of_x, of_y
        Counts of each, by phase of the column, shape (2, 65536), added to.

    """
    x_even, x_odd, y_even, y_odd = of_x[0], of_x[1], of_y[0], of_y[1]
    for c in range(x.size // 2):
        x_even[x[2 * c]] += 1
        y_even[y[2 * c]] += 1
        x_odd[x[2 * c + 1]] += 1
        y_odd[y[2 * c + 1]] += 1
    if x.size % 2:
        x_even[x[x.size - 1]] += 1
        y_even[y[x.size - 1]] += 1


@njit(cache=True, nogil=True)
def count_codes(stack: Stack, band: Band, histogram: NDArray[np.int64]) -> None:
    """Count the codes of one band of every frame of the stack.

    Parameters
    ----------
    stack, band
        Frames and rows.
    histogram
        By phase of the row and of the column in a cell of two, whatever the mosaic's, shape (2, 2, 65536); added to.

    """
    width = stack.width
    for start in stack.starts:
        for row in range(band.top, band.bottom - 1, 2):
            x, y = start + row * width, start + (row + 1) * width
            one, other = histogram[row % 2], histogram[1 - row % 2]
            count_rows(stack.codes[x : x + width], stack.codes[y : y + width], one, other)
        if (band.bottom - band.top) % 2:
            row = band.bottom - 1
            counts = histogram[row % 2]
            count_row(stack.codes[start + row * width : start + (row + 1) * width], counts[0], counts[1])
