"""Frames in memory, and the sums that kernels add them to."""

from typing import NamedTuple

import numpy as np
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
