"""The lowest and highest code of each tile, and how often they occur.

The extremes of each column of a few rows of all frames are followed first. Once those of the tile are known, only the
few columns that hold one of them are looked through again.
"""

from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from fullwell.kernels.moments_rows import Rows
from fullwell.kernels.stack import Band, SeriesSums, Stack

LIST_ROWS = 8
"""Rows of a phase whose extremes are followed together: few enough that eight frames of them stay in the cache."""
FOUR = 4
_TOP_CODE = np.uint16(65535)
_COLUMNS = 128
"""Columns that are looked at together."""
_MANY = 8
"""Where more than one column in so many holds an extreme, all are looked through in vectors."""


class Extremes(NamedTuple):
    """Extremes of each column by phase of the row and list, which is of a few rows; shape (cell, lists, width)."""

    lowest: NDArray[np.uint16]
    highest: NDArray[np.uint16]


@njit(cache=True, nogil=True)
def no_extremes(stack: Stack, band: Band) -> Extremes:
    """Return room for the extremes of a band."""
    rows = -(-(band.bottom - band.top) // band.cell)
    shape = (band.cell, -(-rows // LIST_ROWS), stack.width)
    return Extremes(np.full(shape, _TOP_CODE, np.uint16), np.zeros(shape, np.uint16))


@njit(cache=True, nogil=True)
def four_rows(stack: Stack, at: NDArray[np.int64], f: int) -> Rows:
    """Return the row that begins at ``at`` in four frames from the f-th on."""
    width = stack.width
    return (
        stack.codes[at[f] : at[f] + width],
        stack.codes[at[f + 1] : at[f + 1] + width],
        stack.codes[at[f + 2] : at[f + 2] + width],
        stack.codes[at[f + 3] : at[f + 3] + width],
    )


@njit(cache=True, nogil=True)
def _follow_one(x: NDArray[np.uint16], lowest: NDArray[np.uint16], highest: NDArray[np.uint16]) -> None:
    """Follow the extreme codes of each column through a row of one frame."""
    for c in range(x.size):
        lowest[c] = min(x[c], lowest[c])
        highest[c] = max(x[c], highest[c])


@njit(cache=True, nogil=True)
def _follow_four(x: Rows, lowest: NDArray[np.uint16], highest: NDArray[np.uint16]) -> None:
    """Follow the extreme codes of each column through the same row of four frames."""
    first, second, third, fourth = x
    for c in range(first.size):
        i, j, k, m = first[c], second[c], third[c], fourth[c]
        lowest[c] = min(min(min(i, j), min(k, m)), lowest[c])  # noqa: PLW3301 - pairs compile to vector minima
        highest[c] = max(max(max(i, j), max(k, m)), highest[c])  # noqa: PLW3301 - pairs compile to vector maxima


@njit(cache=True, nogil=True)
def follow_rows(stack: Stack, band: Band, first: int, last: int, extremes: Extremes) -> int:
    """Follow the extremes through the rows of one list of each phase; return the highest code there."""
    width, count, cell = stack.width, stack.starts.size, band.cell
    number = (first - band.top) // (cell * LIST_ROWS)
    for row in range(first, last):
        at = stack.starts + row * width
        lowest, highest = extremes.lowest[row % cell, number], extremes.highest[row % cell, number]
        for f in range(0, count - count % FOUR, FOUR):
            _follow_four(four_rows(stack, at, f), lowest, highest)
        for f in range(count - count % FOUR, count):
            _follow_one(stack.codes[at[f] : at[f] + width], lowest, highest)
    return int(extremes.highest[:, number].max())


@njit(cache=True, nogil=True)
def _of_columns(extremes: Extremes) -> tuple[NDArray[np.uint16], NDArray[np.uint16]]:
    """Return the extremes of each column of the whole band, by phase, shape (cell, width)."""
    cell, lists, width = extremes.lowest.shape
    low, high = extremes.lowest[:, 0].copy(), extremes.highest[:, 0].copy()
    for phase in range(cell):
        for number in range(1, lists):
            own_low, own_high = extremes.lowest[phase, number], extremes.highest[phase, number]
            for c in range(width):
                low[phase, c] = min(low[phase, c], own_low[c])
                high[phase, c] = max(high[phase, c], own_high[c])
    return low, high


@njit(cache=True, nogil=True)
def _merge(low: NDArray[np.uint16], high: NDArray[np.uint16], band: Band, series: SeriesSums) -> None:
    """Merge the extremes of a band's columns into those of its tiles, and write these over the columns'.

    Where a tile has a new extreme, its count begins at nothing.
    """
    cell, step = band.cell, band.cell * band.tile
    tile_row, width = band.top // step, low.shape[1]
    for site in range(cell * cell):
        phase, first = site // cell, site % cell
        for tile in range(-(-width // step)):
            lowest, highest = series.lowest[site, tile_row, tile], series.highest[site, tile_row, tile]
            last = min((tile + 1) * step, width)
            for c in range(tile * step + first, last, cell):
                lowest, highest = min(lowest, low[phase, c]), max(highest, high[phase, c])
            if lowest < series.lowest[site, tile_row, tile]:
                series.lowest[site, tile_row, tile] = lowest
                series.n_lowest[site, tile_row, tile] = 0
            if highest > series.highest[site, tile_row, tile]:
                series.highest[site, tile_row, tile] = highest
                series.n_highest[site, tile_row, tile] = 0
            for c in range(tile * step + first, last, cell):
                low[phase, c], high[phase, c] = lowest, highest


@njit(cache=True, nogil=True)
def _alike(own: NDArray[np.uint16], code: NDArray[np.uint16]) -> int:
    """Return in how many columns two rows of codes agree."""
    found = np.uint16(0)
    for c in range(own.size):
        found = np.uint16(found + np.uint16(own[c] == code[c]))
    return int(found)


@njit(cache=True, nogil=True)
def _count_one(x: NDArray[np.uint16], code: NDArray[np.uint16], n: NDArray[np.uint16]) -> None:
    """Count in each column of a row of one frame the code that is asked for there."""
    for c in range(x.size):
        n[c] = np.uint16(n[c] + np.uint16(x[c] == code[c]))


@njit(cache=True, nogil=True)
def _count_in_columns(
    stack: Stack, starts: NDArray[np.int64], columns: tuple[int, int], code: NDArray[np.uint16], n: NDArray[np.uint16]
) -> None:
    """Count the codes that are asked for in some columns of the rows that begin at ``starts``."""
    first, last = columns
    for start in starts:
        _count_one(stack.codes[start + first : start + last], code[first:last], n[first:last])


@njit(cache=True, nogil=True)
def _count_list(
    stack: Stack,
    starts: NDArray[np.int64],
    own: NDArray[np.uint16],
    code: NDArray[np.uint16],
    n: NDArray[np.uint16],
) -> None:
    """Count the codes that are asked for in the rows of a list, whose own extremes tell where to look."""
    for left in range(0, own.size, _COLUMNS):
        right = min(left + _COLUMNS, own.size)
        alike = _alike(own[left:right], code[left:right])
        if alike * _MANY > right - left:
            _count_in_columns(stack, starts, (left, right), code, n)
        elif alike:
            for c in range(left, right):
                if own[c] == code[c]:
                    for start in starts:
                        n[c] += np.uint16(stack.codes[start + c] == code[c])


@njit(cache=True, nogil=True)
def _rows_of_list(stack: Stack, band: Band, phase: int, number: int) -> NDArray[np.int64]:
    """Return where the rows of a list begin, frame by frame."""
    first = band.top + phase + number * LIST_ROWS * band.cell
    last = min(first + LIST_ROWS * band.cell, band.bottom)
    rows, frames = max(0, -(-(last - first) // band.cell)), stack.starts.size
    starts = np.empty(frames * rows, np.int64)
    for f in range(frames):
        for row in range(rows):
            starts[f * rows + row] = stack.starts[f] + (first + row * band.cell) * stack.width
    return starts


@njit(cache=True, nogil=True)
def close_extremes(stack: Stack, band: Band, extremes: Extremes, series: SeriesSums) -> None:
    """Merge the extremes of a band into those of its tiles, and count how often these occur."""
    cell, lists, width = extremes.lowest.shape
    low, high = _of_columns(extremes)
    _merge(low, high, band, series)
    step = cell * band.tile
    n_low, n_high = np.zeros(width, np.uint16), np.zeros(width, np.uint16)
    for phase in range(cell):
        for number in range(lists):
            starts = _rows_of_list(stack, band, phase, number)
            _count_list(stack, starts, extremes.lowest[phase, number], low[phase], n_low)
            _count_list(stack, starts, extremes.highest[phase, number], high[phase], n_high)
        for tile in range(-(-width // step)):
            for first in range(cell):
                site, columns = phase * cell + first, slice(tile * step + first, min((tile + 1) * step, width), cell)
                series.n_lowest[site, band.top // step, tile] += n_low[columns].sum()
                series.n_highest[site, band.top // step, tile] += n_high[columns].sum()
        n_low[:] = 0
        n_high[:] = 0
