"""What the first frames of a series tell one by one, looked at while they pass by: so that none is read again.

The products of the first five unlit frames are what the published read noise of each is made of; the middle of the
first two frames is where the noise of neighbours is looked for, and what pictures show.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from operator import add
from typing import Final

import numpy as np
from numpy.typing import NDArray

from fullwell.kernels.frame_products import add_frame_products
from fullwell.kernels.stack import Band, Stack
from fullwell.statistics.batch import Batch

LARGEST_SIDE: Final = 1024
"""Of the middle of a frame [pixel]."""


@dataclass(frozen=True, slots=True, kw_only=True)
class FirstFrames:
    """The first frames of a series by name.

    Parameters
    ----------
    frames
        Their names.
    products
        Sum over the pixels of the product of each two, L x L; empty for lit frames [DN^2].
    middles
        Middle of the first two, shape (2, at most 1024, at most 1024) [DN]; None once it is let go.

    """

    frames: tuple[str, ...]
    products: tuple[tuple[int, ...], ...]
    middles: NDArray[np.uint16] | None


def middle(shape: tuple[int, ...], cell: int) -> tuple[slice, slice]:
    """Return rows and columns of the middle of a mosaic, which begins on a whole cell.

    Examples
    --------
    >>> middle((3024, 4032), 2)
    (slice(1000, 2024, None), slice(1504, 2528, None))

    """
    starts = (max(0, (side - LARGEST_SIDE) // 2) // cell * cell for side in shape)
    rows, columns = (slice(at, min(at + LARGEST_SIDE, side)) for at, side in zip(starts, shape, strict=True))
    return rows, columns


class FirstLook:
    """An accumulator that waits for a batch with all the frames it was told of; without one it finds nothing.

    Parameters
    ----------
    height, width, cell
        Of the mosaic [pixel].

    """

    def __init__(self, *, height: int, width: int, cell: int) -> None:
        self._middle = middle((height, width), cell)
        self.expect((), products=False)

    def expect(self, names: Sequence[str], *, products: bool) -> None:
        """Wait for frames of these names: for the products of all, or for the middles of the first two alone."""
        self._names = tuple(names) if products else tuple(names[:2])
        self._products = products
        self.found: FirstFrames | None = None

    def begin(self, batch: Batch) -> "_Addition | None":
        """Return what takes the rows of a batch, None where it is not the one."""
        if len(self._names) < 2 or not set(self._names) <= set(batch.names):
            return None
        places = [batch.names.index(name) for name in self._names]
        return _Addition(self, places, middle=self._middle, products=self._products)

    def end(self, products: tuple[tuple[int, ...], ...], middles: NDArray[np.uint16]) -> None:
        """Keep what was found."""
        self.found = FirstFrames(frames=self._names, products=products, middles=middles)


class _Addition:
    """The frames at some places of a batch on their way past."""

    def __init__(self, look: FirstLook, places: Sequence[int], *, middle: tuple[slice, slice], products: bool) -> None:
        self._look = look
        self._places = list(places)
        self._rows, self._columns = middle
        self._middles = np.empty(
            (2, self._rows.stop - self._rows.start, self._columns.stop - self._columns.start), np.uint16
        )
        count = len(places) if products else 0
        self._products = [[0] * count for _ in range(count)]

    def add(self, stack: Stack, band: Band) -> None:
        """Look at some rows."""
        if self._products:
            totals = np.zeros((len(self._places),) * 2, np.uint64)
            add_frame_products(Stack(stack.codes, stack.starts[self._places], stack.width), band, totals)
            for row, more in zip(self._products, totals.tolist(), strict=True):
                row[:] = map(add, row, more)
        top, bottom = max(band.top, self._rows.start), min(band.bottom, self._rows.stop)
        if top < bottom:
            for place, target in zip(self._places, self._middles, strict=False):
                first = int(stack.starts[place]) + top * stack.width
                rows = stack.codes[first : first + (bottom - top) * stack.width].reshape(bottom - top, stack.width)
                target[top - self._rows.start : bottom - self._rows.start] = rows[:, self._columns]

    def commit(self) -> None:
        """Hear that all rows have been looked at."""
        every = range(len(self._products))
        products = tuple(tuple(self._products[min(i, j)][max(i, j)] for j in every) for i in every)
        self._middles.flags.writeable = False
        self._look.end(products, self._middles)
