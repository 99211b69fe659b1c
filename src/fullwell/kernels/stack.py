"""Frames in memory, and the sums that kernels add them to."""

from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray


class Stack(NamedTuple):
    """Frames in one block of memory.

    Parameters
    ----------
    codes
        The block, shape (anything,) [DN].
    starts
        Where in the block each frame's first pixel lies, shape (frames,); rows follow without gaps. Where only
        some rows are in memory, the first pixel of all would lie there, which may be outside the block.
    width
        Columns of a frame.

    """

    codes: NDArray[np.uint16]
    starts: NDArray[np.int64]
    width: int


class Band(NamedTuple):
    """A row of tiles or some of its rows: from ``top``, a multiple of ``cell``, to ``bottom``, one past the last."""

    top: int
    bottom: int
    cell: int
    tile: int


@njit(cache=True, nogil=True)
def rows_of(band: Band, phase: int) -> int:
    """Return how many rows of a phase a band has."""
    return len(range(band.top + phase, band.bottom, band.cell))


WIDE = 1 << 62
"""What is held of a row whose squares are summed in 64 bits."""


class SeriesSums(NamedTuple):
    """Sums over the frames of a series.

    Parameters
    ----------
    codes
        Of each pixel, shape (height, width).
    squares
        The same of squares, as long as 32 bits hold them.
    wide
        The same in 64 bits: of rows that are ``WIDE``, nothing else is looked at.
    held
        What no sum of squares in a row is above, shape (height,); where it is 0 the maps hold nothing yet.
    lowest, highest, n_lowest, n_highest
        Extremes of each tile and how often they occur, shape (sites, tile rows, tile columns).

    """

    codes: NDArray[np.uint32]
    squares: NDArray[np.uint32]
    wide: NDArray[np.uint64]
    held: NDArray[np.int64]
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
    open
        Columns of the row of tiles that is under way, in neither of these yet; shape as ``columns``.

    """

    rows: NDArray[np.uint64]
    columns: NDArray[np.uint64]
    tiles: NDArray[np.uint64]
    open: NDArray[np.uint32]
