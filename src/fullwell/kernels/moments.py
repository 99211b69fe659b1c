"""Frames become exact integer sums in one sweep over the pixels, a row of tiles at a time.

A mosaic's planes are the sites of its repeating cell, row-major: four for Bayer (cell 2), one for mono (cell 1). A row
of tiles of all planes together is a *band* of ``tile * cell`` mosaic rows: the unit of work, so that every pixel of
every frame is read once and the maps are touched once for all the frames at hand. Everything is an integer, so bands
and frames may come in any order. `moments_reference` says the same in plain NumPy.
"""

from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

_TOP_CODE = np.uint16(65535)
_NARROW = np.uint16(32767)
"""Four squares of codes up to here fit in 32 bits."""


class Stack(NamedTuple):
    """Frames in one block of memory.

    Parameters
    ----------
    codes
        The block, shape (anything,) [DN].
    starts
        Where in the block each frame's first pixel lies, shape (frames,); rows follow without gaps.
    width
        Columns of a frame.

    """

    codes: NDArray[np.uint16]
    starts: NDArray[np.int64]
    width: int


class Band(NamedTuple):
    """A row of tiles: mosaic rows ``top`` (a multiple of ``cell * tile``) to ``bottom`` (one past the last)."""

    top: int
    bottom: int
    cell: int
    tile: int


class SeriesSums(NamedTuple):
    """Sums over the frames of a series: maps of shape (height, width), the rest (sites, tile rows, tile columns)."""

    codes: NDArray[np.uint32]
    squares: NDArray[np.uint64]
    lowest: NDArray[np.uint16]
    highest: NDArray[np.uint16]
    n_lowest: NDArray[np.int64]
    n_highest: NDArray[np.int64]


class FrameSums(NamedTuple):
    """Sums over the pixels of each frame.

    Parameters
    ----------
    rows
        By mosaic row and phase of the column, shape (frames, height, cell).
    columns
        By phase of the row and mosaic column, shape (frames, cell, width).
    tiles
        Shape (frames, sites, tile rows, tile columns).

    """

    rows: NDArray[np.uint64]
    columns: NDArray[np.uint64]
    tiles: NDArray[np.uint64]


class Extremes(NamedTuple):
    """Lowest and highest code of each column of a band, by phase of the row, shape (cell, width)."""

    lowest: NDArray[np.uint16]
    highest: NDArray[np.uint16]


@njit(cache=True, nogil=True)
def add_one(x: NDArray[np.uint16], codes: NDArray[np.uint32], squares: NDArray[np.uint64]) -> None:
    """Add a row of one frame to the maps."""
    for c in range(x.size):
        value = np.uint32(x[c])
        codes[c] = codes[c] + value
        squares[c] = squares[c] + np.uint64(value) * value


@njit(cache=True, nogil=True)
def add_four(x: tuple[NDArray[np.uint16], ...], codes: NDArray[np.uint32], squares: NDArray[np.uint64]) -> None:
    """Add the same row of four frames to the maps, which are read and written once."""
    first, second, third, fourth = x
    for c in range(first.size):
        i, j, k, m = np.uint32(first[c]), np.uint32(second[c]), np.uint32(third[c]), np.uint32(fourth[c])
        codes[c] = codes[c] + (i + j + k + m)
        squares[c] = squares[c] + (np.uint64(i) * i + np.uint64(j) * j + np.uint64(k) * k + np.uint64(m) * m)


@njit(cache=True, nogil=True)
def _add_four_narrow(x: tuple[NDArray[np.uint16], ...], codes: NDArray[np.uint32], squares: NDArray[np.uint64]) -> None:
    """Add the same row of four frames to the maps, all codes being at most ``_NARROW``."""
    first, second, third, fourth = x
    for c in range(first.size):
        i, j, k, m = np.uint32(first[c]), np.uint32(second[c]), np.uint32(third[c]), np.uint32(fourth[c])
        codes[c] = codes[c] + (i + j + k + m)
        squares[c] = squares[c] + np.uint64(np.uint32(np.uint32(i * i + j * j) + np.uint32(k * k + m * m)))


@njit(cache=True, nogil=True)
def _follow_one(x: NDArray[np.uint16], lowest: NDArray[np.uint16], highest: NDArray[np.uint16]) -> None:
    """Follow the extreme codes of each column through a row of one frame."""
    for c in range(x.size):
        lowest[c] = min(x[c], lowest[c])
        highest[c] = max(x[c], highest[c])


@njit(cache=True, nogil=True)
def _follow_four(x: tuple[NDArray[np.uint16], ...], lowest: NDArray[np.uint16], highest: NDArray[np.uint16]) -> None:
    """Follow the extreme codes of each column through the same row of four frames."""
    first, second, third, fourth = x
    for c in range(first.size):
        i, j, k, m = first[c], second[c], third[c], fourth[c]
        lowest[c] = min(min(min(i, j), min(k, m)), lowest[c])  # noqa: PLW3301 - pairs compile to vector minima
        highest[c] = max(max(max(i, j), max(k, m)), highest[c])  # noqa: PLW3301 - pairs compile to vector maxima


@njit(cache=True, nogil=True)
def _count_one(x: NDArray[np.uint16], code: NDArray[np.uint16], n: NDArray[np.uint16]) -> None:
    """Count in each column of a row of one frame the code that is asked for there."""
    for c in range(x.size):
        n[c] = np.uint16(n[c] + np.uint16(x[c] == code[c]))


@njit(cache=True, nogil=True)
def _count_four(x: tuple[NDArray[np.uint16], ...], code: NDArray[np.uint16], n: NDArray[np.uint16]) -> None:
    """Count in each column of the same row of four frames the code that is asked for there."""
    first, second, third, fourth = x
    for c in range(first.size):
        i, j = np.uint16(first[c] == code[c]), np.uint16(second[c] == code[c])
        k, m = np.uint16(third[c] == code[c]), np.uint16(fourth[c] == code[c])
        n[c] = np.uint16(n[c] + i + j + k + m)


@njit(cache=True, nogil=True)
def add_margins(x: NDArray[np.uint16], columns: NDArray[np.uint32], row: NDArray[np.uint64]) -> None:
    """Add a row of one frame to its column sums, and its sum by phase of the column to ``row``."""
    for c in range(x.size):
        columns[c] = columns[c] + np.uint32(x[c])
    # At most 32768 codes each, so that 32 bits hold them.
    even, odd = np.uint32(0), np.uint32(0)
    for c in range(x.size // 2):
        even = np.uint32(even + np.uint32(x[2 * c]))
        odd = np.uint32(odd + np.uint32(x[2 * c + 1]))
    row[0] += np.uint64(even)
    row[row.size - 1] += np.uint64(odd)
    if x.size % 2:
        row[0] += np.uint64(x[x.size - 1])


@njit(cache=True, nogil=True)
def close_tiles(columns: NDArray[np.uint32], band: Band, sums: NDArray[np.uint64], tiles: NDArray[np.uint64]) -> None:
    """Gather a band's column sums of one frame into ``tiles``, shape (sites, tile rows, tile columns)."""
    cell, step = band.cell, band.cell * band.tile
    tile_row = band.top // step
    for phase in range(cell):
        for tile in range(tiles.shape[2]):
            for first in range(cell):
                total = np.uint64(0)
                for c in range(tile * step + first, min((tile + 1) * step, columns.shape[1]), cell):
                    total += np.uint64(columns[phase, c])
                tiles[phase * cell + first, tile_row, tile] += total
        for c in range(columns.shape[1]):
            sums[phase, c] += np.uint64(columns[phase, c])


@njit(cache=True, nogil=True)
def close_extremes(extremes: Extremes, band: Band, series: SeriesSums) -> None:
    """Merge the extremes of a band's columns into those of its tiles, and write these over the columns'.

    Where a tile has a new extreme, its count begins at nothing.
    """
    cell, step = band.cell, band.cell * band.tile
    tile_row = band.top // step
    for phase in range(cell):
        low, high = extremes.lowest[phase], extremes.highest[phase]
        for first in range(cell):
            site = phase * cell + first
            for tile in range(-(-low.size // step)):
                lowest, highest = series.lowest[site, tile_row, tile], series.highest[site, tile_row, tile]
                last = min((tile + 1) * step, low.size)
                for c in range(tile * step + first, last, cell):
                    lowest, highest = min(lowest, low[c]), max(highest, high[c])
                if lowest < series.lowest[site, tile_row, tile]:
                    series.lowest[site, tile_row, tile] = lowest
                    series.n_lowest[site, tile_row, tile] = 0
                if highest > series.highest[site, tile_row, tile]:
                    series.highest[site, tile_row, tile] = highest
                    series.n_highest[site, tile_row, tile] = 0
                for c in range(tile * step + first, last, cell):
                    low[c], high[c] = lowest, highest


@njit(cache=True, nogil=True)
def extremes_of(stack: Stack, band: Band) -> Extremes:
    """Return the extreme codes of each column of a band."""
    width, count, cell = stack.width, stack.starts.size, band.cell
    found = Extremes(np.full((cell, width), _TOP_CODE, np.uint16), np.zeros((cell, width), np.uint16))
    for row in range(band.top, band.bottom):
        lowest, highest = found.lowest[row % cell], found.highest[row % cell]
        at = stack.starts + row * width
        for f in range(0, count - count % 4, 4):
            _follow_four(_four_rows(stack, at, f), lowest, highest)
        for f in range(count - count % 4, count):
            _follow_one(stack.codes[at[f] : at[f] + width], lowest, highest)
    return found


@njit(cache=True, nogil=True)
def _four_rows(stack: Stack, at: NDArray[np.int64], f: int) -> tuple[NDArray[np.uint16], ...]:
    """Return the row that begins at ``at`` in four frames from the f-th on."""
    width = stack.width
    return (
        stack.codes[at[f] : at[f] + width],
        stack.codes[at[f + 1] : at[f + 1] + width],
        stack.codes[at[f + 2] : at[f + 2] + width],
        stack.codes[at[f + 3] : at[f + 3] + width],
    )


@njit(cache=True, nogil=True)
def close_counts(n_low: NDArray[np.uint16], n_high: NDArray[np.uint16], band: Band, series: SeriesSums) -> None:
    """Gather how often the extremes of each tile occur in the columns of a band."""
    cell, step = band.cell, band.cell * band.tile
    for phase in range(cell):
        for c in range(n_low.shape[1]):
            site, tile = phase * cell + c % cell, c // step
            series.n_lowest[site, band.top // step, tile] += np.int64(n_low[phase, c])
            series.n_highest[site, band.top // step, tile] += np.int64(n_high[phase, c])


@njit(cache=True, nogil=True)
def add_band(stack: Stack, band: Band, series: SeriesSums, frames: FrameSums, fresh: bool) -> None:  # noqa: FBT001 - compiled functions take their arguments by position
    """Add one band of every frame of the stack to the sums of the series, and to the sums of each frame.

    The extremes of the band's tiles come first: they tell how wide squares are, and which codes are to be counted.

    Parameters
    ----------
    stack
        Frames; at most 65535 // tile of them.
    band
        Which rows.
    series
        Sums over frames [DN, DN^2], added to.
    frames
        Sums over pixels [DN], added to.
    fresh
        Whether the band's rows of the maps hold nothing yet: what lies there is forgotten.

    """
    width, count, cell = stack.width, stack.starts.size, band.cell
    extremes = extremes_of(stack, band)
    close_extremes(extremes, band, series)
    narrow = extremes.highest.max() <= _NARROW
    columns = np.zeros((count, cell, width), np.uint32)
    n_low, n_high = np.zeros((cell, width), np.uint16), np.zeros((cell, width), np.uint16)
    fours = count - count % 4
    for row in range(band.top, band.bottom):
        phase = row % cell
        codes, squares = series.codes[row], series.squares[row]
        low, high = extremes.lowest[phase], extremes.highest[phase]
        at = stack.starts + row * width
        if fresh:
            codes[:] = 0
            squares[:] = 0
        for f in range(0, fours, 4):
            x = _four_rows(stack, at, f)
            if narrow:
                _add_four_narrow(x, codes, squares)
            else:
                add_four(x, codes, squares)
            _count_four(x, low, n_low[phase])
            _count_four(x, high, n_high[phase])
        for f in range(count):
            x_f = stack.codes[at[f] : at[f] + width]
            if f >= fours:
                add_one(x_f, codes, squares)
                _count_one(x_f, low, n_low[phase])
                _count_one(x_f, high, n_high[phase])
            add_margins(x_f, columns[f, phase], frames.rows[f, row])
    for f in range(count):
        close_tiles(columns[f], band, frames.columns[f], frames.tiles[f])
    close_counts(n_low, n_high, band, series)


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
