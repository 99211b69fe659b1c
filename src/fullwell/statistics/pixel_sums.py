"""Sums over the frames of a series pixel by pixel: squares in 32 bits, row by row in 64 where one may outgrow them."""

import numpy as np

from fullwell.kernels.moments import MOST_HELD
from fullwell.kernels.moments_summary import Maps
from fullwell.kernels.stack import WIDE, SeriesSums


def empty_maps(shape: tuple[int, int], grid: tuple[int, int, int]) -> SeriesSums:
    """Return room for the sums of a mosaic, of which memory is taken as it is written to.

    Parameters
    ----------
    shape
        Rows and columns of the mosaic.
    grid
        Sites, and rows and columns of tiles.

    """
    return SeriesSums(
        codes=np.empty(shape, np.uint32),
        squares=np.empty(shape, np.uint32),
        wide=np.empty(shape, np.uint64),
        held=np.zeros(shape[0], np.int64),
        lowest=np.empty(grid, np.uint16),
        highest=np.empty(grid, np.uint16),
        n_lowest=np.empty(grid, np.int64),
        n_highest=np.empty(grid, np.int64),
    )


def finished_maps(sums: SeriesSums, frames: int) -> Maps:
    """Return the sums over ``frames`` frames, all squares of one width."""
    if not _is_wide(sums):
        return Maps(sums.codes, sums.squares, frames)
    _widen(sums)
    return Maps(sums.codes, sums.wide, frames)


def merge_maps(mine: SeriesSums, its: SeriesSums, *, fresh: bool) -> None:
    """Add sums to others, which hold nothing where they are ``fresh``."""
    if fresh:
        mine.codes[...] = 0
        mine.squares[...] = 0
    _merge_extremes(mine, its)
    np.add(mine.codes, its.codes, out=mine.codes)
    if not _is_wide(mine) and not _is_wide(its) and (mine.held + its.held).max() <= MOST_HELD:
        np.add(mine.squares, its.squares, out=mine.squares)
        np.add(mine.held, its.held, out=mine.held)
        return
    _widen(mine)
    wide = its.held == WIDE
    mine.wide[wide] += its.wide[wide]
    mine.wide[~wide] += its.squares[~wide]


def packed_maps(sums: SeriesSums) -> SeriesSums:
    """Return the same without memory that nothing was written to."""
    return sums if _is_wide(sums) else sums._replace(wide=np.empty((0, 0), np.uint64))


def unpacked_maps(sums: SeriesSums) -> SeriesSums:
    """Undo `packed_maps`."""
    return sums if sums.wide.size else sums._replace(wide=np.empty(sums.codes.shape, np.uint64))


def _is_wide(sums: SeriesSums) -> bool:
    """Tell whether the squares of some rows are summed in 64 bits."""
    return bool((sums.held == WIDE).any())


def _widen(sums: SeriesSums) -> None:
    """Sum the squares of every row in 64 bits from now on."""
    narrow = sums.held != WIDE
    sums.wide[narrow] = sums.squares[narrow]
    sums.held[...] = WIDE


def _merge_extremes(mine: SeriesSums, its: SeriesSums) -> None:
    for code, count, other, other_count, lower in (
        (mine.lowest, mine.n_lowest, its.lowest, its.n_lowest, True),
        (mine.highest, mine.n_highest, its.highest, its.n_highest, False),
    ):
        beyond = other < code if lower else other > code
        count[...] = np.where(beyond, other_count, np.where(other == code, count + other_count, count))
        code[...] = np.where(beyond, other, code)
