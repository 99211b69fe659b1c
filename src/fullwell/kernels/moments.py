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


class _Extremes(NamedTuple):
    """Lowest and highest code of each column of a band and how often they occur, shape (cell, width)."""

    lowest: NDArray[np.uint16]
    highest: NDArray[np.uint16]
    n_lowest: NDArray[np.uint16]
    n_highest: NDArray[np.uint16]


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
def _count_one(x: NDArray[np.uint16], phase: int, extremes: _Extremes) -> None:
    """Follow the extreme codes of each column through a row of one frame."""
    low, n_low = extremes.lowest[phase], extremes.n_lowest[phase]
    for c in range(x.size):
        lowest = min(x[c], low[c])
        kept = n_low[c] if lowest == low[c] else np.uint16(0)
        n_low[c] = np.uint16(kept + np.uint16(x[c] == lowest))
        low[c] = lowest
    high, n_high = extremes.highest[phase], extremes.n_highest[phase]
    for c in range(x.size):
        highest = max(x[c], high[c])
        kept = n_high[c] if highest == high[c] else np.uint16(0)
        n_high[c] = np.uint16(kept + np.uint16(x[c] == highest))
        high[c] = highest


@njit(cache=True, nogil=True)
def _count_four(x: tuple[NDArray[np.uint16], ...], phase: int, extremes: _Extremes) -> None:
    """Follow the extreme codes of each column through the same row of four frames."""
    first, second, third, fourth = x
    low, n_low = extremes.lowest[phase], extremes.n_lowest[phase]
    for c in range(first.size):
        i, j, k, m = first[c], second[c], third[c], fourth[c]
        lowest = min(min(min(i, j), min(k, m)), low[c])  # noqa: PLW3301 - pairs compile to vector minima
        kept = n_low[c] if lowest == low[c] else np.uint16(0)
        equal = np.uint16(i == lowest) + np.uint16(j == lowest) + np.uint16(k == lowest) + np.uint16(m == lowest)
        n_low[c] = np.uint16(kept + equal)
        low[c] = lowest
    high, n_high = extremes.highest[phase], extremes.n_highest[phase]
    for c in range(first.size):
        i, j, k, m = first[c], second[c], third[c], fourth[c]
        highest = max(max(max(i, j), max(k, m)), high[c])  # noqa: PLW3301 - pairs compile to vector maxima
        kept = n_high[c] if highest == high[c] else np.uint16(0)
        equal = np.uint16(i == highest) + np.uint16(j == highest) + np.uint16(k == highest) + np.uint16(m == highest)
        n_high[c] = np.uint16(kept + equal)
        high[c] = highest


@njit(cache=True, nogil=True)
def _add_margins(x: NDArray[np.uint16], columns: NDArray[np.uint32], row: NDArray[np.uint64]) -> None:
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
def _close_tiles(columns: NDArray[np.uint32], band: Band, sums: NDArray[np.uint64], tiles: NDArray[np.uint64]) -> None:
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
def _close_extremes(extremes: _Extremes, band: Band, series: SeriesSums) -> None:
    """Merge the extremes of a band's columns into those of its tiles."""
    cell, step = band.cell, band.cell * band.tile
    tile_row = band.top // step
    for phase in range(cell):
        for c in range(extremes.lowest.shape[1]):
            site, tile = phase * cell + c % cell, c // step
            low, high = extremes.lowest[phase, c], extremes.highest[phase, c]
            if low < series.lowest[site, tile_row, tile]:
                series.lowest[site, tile_row, tile] = low
                series.n_lowest[site, tile_row, tile] = 0
            if low == series.lowest[site, tile_row, tile]:
                series.n_lowest[site, tile_row, tile] += np.int64(extremes.n_lowest[phase, c])
            if high > series.highest[site, tile_row, tile]:
                series.highest[site, tile_row, tile] = high
                series.n_highest[site, tile_row, tile] = 0
            if high == series.highest[site, tile_row, tile]:
                series.n_highest[site, tile_row, tile] += np.int64(extremes.n_highest[phase, c])


@njit(cache=True, nogil=True)
def add_band(stack: Stack, band: Band, series: SeriesSums, frames: FrameSums, fresh: bool) -> None:  # noqa: FBT001 - compiled functions take their arguments by position
    """Add one band of every frame of the stack to the sums of the series, and to the sums of each frame.

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
    columns = np.zeros((count, cell, width), np.uint32)
    extremes = _Extremes(
        np.full((cell, width), _TOP_CODE, np.uint16),
        np.zeros((cell, width), np.uint16),
        np.zeros((cell, width), np.uint16),
        np.zeros((cell, width), np.uint16),
    )
    fours = count - count % 4
    for row in range(band.top, band.bottom):
        phase = row % cell
        codes, squares = series.codes[row], series.squares[row]
        at = stack.starts + row * width
        if fresh:
            codes[:] = 0
            squares[:] = 0
        for f in range(0, fours, 4):
            x = (
                stack.codes[at[f] : at[f] + width],
                stack.codes[at[f + 1] : at[f + 1] + width],
                stack.codes[at[f + 2] : at[f + 2] + width],
                stack.codes[at[f + 3] : at[f + 3] + width],
            )
            add_four(x, codes, squares)
            _count_four(x, phase, extremes)
        for f in range(count):
            x_f = stack.codes[at[f] : at[f] + width]
            if f >= fours:
                add_one(x_f, codes, squares)
                _count_one(x_f, phase, extremes)
            _add_margins(x_f, columns[f, phase], frames.rows[f, row])
    for f in range(count):
        _close_tiles(columns[f], band, frames.columns[f], frames.tiles[f])
    _close_extremes(extremes, band, series)


@njit(cache=True, nogil=True)
def count_codes(stack: Stack, band: Band, histogram: NDArray[np.int64]) -> None:
    """Count the codes of one band of every frame of the stack.

    Parameters
    ----------
    stack, band
        Frames and rows.
    histogram
        Shape (sites, 65536), added to.

    """
    width, cell = stack.width, band.cell
    for row in range(band.top, band.bottom):
        even = histogram[row % cell * cell]
        odd = histogram[row % cell * cell + cell - 1]
        for start in stack.starts:
            x = stack.codes[start + row * width : start + (row + 1) * width]
            for c in range(width // 2):
                even[x[2 * c]] += 1
                odd[x[2 * c + 1]] += 1
            if width % 2:
                even[x[width - 1]] += 1
