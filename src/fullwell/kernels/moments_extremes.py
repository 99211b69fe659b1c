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

LIST_ROWS = 16
"""Rows of a phase whose extremes are followed together: the fewer, the more lists are kept and looked through."""
_LIST_FRAMES = 8
"""Frames whose extremes are followed together: where a column holds one, all its codes are looked through."""
FOUR = 4
_TOP_CODE = np.uint16(65535)
_COLUMNS = 64
"""Columns that are looked at together."""
_MANY = 8
"""Where more than one column in so many holds an extreme, all are looked through in vectors."""


class Extremes(NamedTuple):
    """Extremes of each column by phase of the row and list, which is of a few rows of a few frames.

    Shape (cell, lists, width); lists of the same rows follow each other.
    """

    lowest: NDArray[np.uint16]
    highest: NDArray[np.uint16]


@njit(cache=True, nogil=True)
def _parts(stack: Stack) -> int:
    """Return in how many parts the frames are followed."""
    return -(-stack.starts.size // _LIST_FRAMES)


@njit(cache=True, nogil=True)
def no_extremes(stack: Stack, band: Band) -> Extremes:
    """Return room for the extremes of a band."""
    rows = -(-(band.bottom - band.top) // band.cell)
    shape = (band.cell, -(-rows // LIST_ROWS) * _parts(stack), stack.width)
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
    width, cell, parts = stack.width, band.cell, _parts(stack)
    number = (first - band.top) // (cell * LIST_ROWS) * parts
    for row in range(first, last):
        at = stack.starts + row * width
        for part in range(parts):
            lowest, highest = extremes.lowest[row % cell, number + part], extremes.highest[row % cell, number + part]
            begin, end = part * _LIST_FRAMES, min((part + 1) * _LIST_FRAMES, stack.starts.size)
            fours = end - (end - begin) % FOUR
            for f in range(begin, fours, FOUR):
                _follow_four(four_rows(stack, at, f), lowest, highest)
            for f in range(fours, end):
                _follow_one(stack.codes[at[f] : at[f] + width], lowest, highest)
    return int(extremes.highest[:, number : number + parts].max())


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
def _least(x: NDArray[np.uint16]) -> tuple[np.uint16, np.uint16]:
    """Return the lowest code of the even and of the odd columns."""
    even, odd = _TOP_CODE, _TOP_CODE
    for c in range(x.size // 2):
        even, odd = min(even, x[2 * c]), min(odd, x[2 * c + 1])
    return (min(even, x[x.size - 1]), odd) if x.size % 2 else (even, odd)


@njit(cache=True, nogil=True)
def _most(x: NDArray[np.uint16]) -> tuple[np.uint16, np.uint16]:
    """Return the highest code of the even and of the odd columns."""
    even, odd = np.uint16(0), np.uint16(0)
    for c in range(x.size // 2):
        even, odd = max(even, x[2 * c]), max(odd, x[2 * c + 1])
    return (max(even, x[x.size - 1]), odd) if x.size % 2 else (even, odd)


@njit(cache=True, nogil=True)
def _write(x: NDArray[np.uint16], even: np.uint16, odd: np.uint16) -> None:
    """Write a code over the even columns and another over the odd ones."""
    for c in range(x.size // 2):
        x[2 * c] = even
        x[2 * c + 1] = odd
    if x.size % 2:
        x[x.size - 1] = even


@njit(cache=True, nogil=True)
def _replace(codes: NDArray[np.uint16], counts: NDArray[np.int64], tile: int, code: np.uint16) -> None:
    """Keep the extreme of a tile; where it is a new one, its count begins at nothing."""
    if code != codes[tile]:
        codes[tile] = code
        counts[tile] = 0


@njit(cache=True, nogil=True)
def _merge(low: NDArray[np.uint16], high: NDArray[np.uint16], band: Band, series: SeriesSums) -> None:
    """Merge the extremes of a band's columns into those of its tiles, and write these over the columns'."""
    cell, step = band.cell, band.cell * band.tile
    tile_row, width = band.top // step, low.shape[1]
    for phase in range(cell):
        one, other = phase * cell, phase * cell + cell - 1
        for tile in range(-(-width // step)):
            own_low, own_high = (
                low[phase, tile * step : (tile + 1) * step],
                high[phase, tile * step : (tile + 1) * step],
            )
            least, most = _least(own_low), _most(own_high)
            if cell == 1:
                least = (min(least[0], least[1]), min(least[0], least[1]))
                most = (max(most[0], most[1]), max(most[0], most[1]))
            low_one = min(least[0], series.lowest[one, tile_row, tile])
            low_other = min(least[1], series.lowest[other, tile_row, tile])
            high_one = max(most[0], series.highest[one, tile_row, tile])
            high_other = max(most[1], series.highest[other, tile_row, tile])
            _replace(series.lowest[one, tile_row], series.n_lowest[one, tile_row], tile, low_one)
            _replace(series.lowest[other, tile_row], series.n_lowest[other, tile_row], tile, low_other)
            _replace(series.highest[one, tile_row], series.n_highest[one, tile_row], tile, high_one)
            _replace(series.highest[other, tile_row], series.n_highest[other, tile_row], tile, high_other)
            _write(own_low, low_one, low_other)
            _write(own_high, high_one, high_other)


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
def _count_in_column(codes: NDArray[np.uint16], starts: NDArray[np.int64], column: int, code: np.uint16) -> np.uint16:
    """Count a code in one column of the rows that begin at ``starts``."""
    found = np.uint16(0)
    for start in starts:
        found = np.uint16(found + np.uint16(codes[start + column] == code))
    return found


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
                    n[c] = np.uint16(n[c] + _count_in_column(stack.codes, starts, c, code[c]))


@njit(cache=True, nogil=True)
def _rows_of_list(stack: Stack, band: Band, phase: int, number: int) -> NDArray[np.int64]:
    """Return where the rows of a list begin, frame by frame."""
    lines, part = divmod(number, _parts(stack))
    first = band.top + phase + lines * LIST_ROWS * band.cell
    last = min(first + LIST_ROWS * band.cell, band.bottom)
    rows = max(0, -(-(last - first) // band.cell))
    frames = stack.starts[part * _LIST_FRAMES : (part + 1) * _LIST_FRAMES]
    starts = np.empty(frames.size * rows, np.int64)
    for f in range(frames.size):
        for row in range(rows):
            starts[f * rows + row] = frames[f] + (first + row * band.cell) * stack.width
    return starts


@njit(cache=True, nogil=True)
def _add_counts(n: NDArray[np.uint16], tile: int, counts: NDArray[np.int64]) -> None:
    """Add what was counted in the columns of a plane to the counts of its tiles."""
    for at in range(counts.size):
        total = np.uint32(0)
        for c in range(at * tile, min((at + 1) * tile, n.size)):
            total = np.uint32(total + np.uint32(n[c]))
        counts[at] += np.int64(total)


@njit(cache=True, nogil=True)
def close_extremes(stack: Stack, band: Band, extremes: Extremes, series: SeriesSums) -> None:
    """Merge the extremes of a band into those of its tiles, and count how often these occur."""
    cell, lists, width = extremes.lowest.shape
    tile_row = band.top // (cell * band.tile)
    low, high = _of_columns(extremes)
    _merge(low, high, band, series)
    n_low, n_high = np.zeros(width, np.uint16), np.zeros(width, np.uint16)
    for phase in range(cell):
        for number in range(lists):
            starts = _rows_of_list(stack, band, phase, number)
            _count_list(stack, starts, extremes.lowest[phase, number], low[phase], n_low)
            _count_list(stack, starts, extremes.highest[phase, number], high[phase], n_high)
        for first in range(cell):
            site = phase * cell + first
            _add_counts(n_low[first::cell], band.tile, series.n_lowest[site, tile_row])
            _add_counts(n_high[first::cell], band.tile, series.n_highest[site, tile_row])
        n_low[:] = 0
        n_high[:] = 0
