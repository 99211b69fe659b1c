"""Pixels that stand alone far above or below their neighbours of the same colour: hot, dead, stuck.

A pixel counts where it lies beyond all eight neighbours by more than three times what they span among themselves, and
three times what neighbours at that level span as a rule. Light comes in spots: where a pixel of another colour beside
it stands out as well, it is no defect. Of pixels with nothing but normal noise fewer than 1e-6 count, of photon noise
at a mean of three electrons 2e-5.
"""

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

BEYOND: Final = 3
"""Spans by which a pixel must lie beyond its neighbours."""
SHARED: Final = 0.2
"""Of its excess, in that of a pixel beside it, from where on it is light."""
LEVELS: Final = 128
SAMPLE: Final = 1 << 17
"""Pixels that tell what neighbours at a level span."""


@dataclass(frozen=True, slots=True, kw_only=True)
class IsolatedPixels:
    """Where pixels stand alone.

    Parameters
    ----------
    above, below
        Row and column of each, shape (found, 2), by row.

    """

    above: NDArray[np.int64]
    below: NDArray[np.int64]


def isolated_pixels(mosaic: NDArray[np.uint16], *, cell: int) -> IsolatedPixels:
    """Return the pixels of a mosaic that stand alone.

    Parameters
    ----------
    mosaic
        Shape (height, width) [DN].
    cell
        Period of the mosaic [pixel].

    Examples
    --------
    >>> mosaic = np.random.default_rng(1).normal(500, 3, (64, 64)).astype(np.uint16)
    >>> mosaic[20, 31], mosaic[40, 12] = 900, 0
    >>> found = isolated_pixels(mosaic, cell=2)
    >>> found.above.tolist(), found.below.tolist()
    ([[20, 31]], [[40, 12]])

    """
    excess = np.zeros(mosaic.shape, np.int32)
    beyond = np.zeros(mosaic.shape, np.bool_)
    top = int(mosaic.max())
    for site in range(cell * cell):
        part = (slice(site // cell, None, cell), slice(site % cell, None, cell))
        plane = mosaic[part]
        if min(plane.shape) < 3:
            continue
        inside = excess[part][1:-1, 1:-1], beyond[part][1:-1, 1:-1]
        inside[0][...], inside[1][...] = _excess(np.ascontiguousarray(plane), top)
    found = np.argwhere(beyond)
    if cell > 1 and found.size:
        found = found[~_lit_beside(mosaic, found, excess[found[:, 0], found[:, 1]])]
    height = excess[found[:, 0], found[:, 1]]
    return IsolatedPixels(above=found[height > 0], below=found[height < 0])


def _excess(plane: NDArray[np.uint16], top: int) -> tuple[NDArray[np.int32], NDArray[np.bool_]]:
    """Return how far each inner pixel lies beyond all its neighbours [DN], and whether that is far."""
    rows, columns = plane.shape
    centre = plane[1:-1, 1:-1]
    around = [
        plane[1 + down : rows - 1 + down, 1 + right : columns - 1 + right]
        for down in (-1, 0, 1)
        for right in (-1, 0, 1)
        if (down, right) != (0, 0)
    ]
    high, low = around[0].copy(), around[0].copy()
    for one in around[1:]:
        np.maximum(high, one, out=high)
        np.minimum(low, one, out=low)
    excess = np.maximum(centre, high).astype(np.int32) - high
    excess += np.minimum(centre, low)
    excess -= low
    span = high - low
    far = np.abs(excess) > BEYOND * np.maximum(span, _usual_span(high, span)).astype(np.int32)
    # Where all neighbours clip, nothing is known of what is usual there.
    far &= high < top
    return excess, far


def _usual_span(high: NDArray[np.uint16], span: NDArray[np.uint16]) -> NDArray[np.uint16]:
    """Return what neighbours at the level of each pixel span as a rule, at least one code [DN]."""
    stride = max(1, span.size // SAMPLE)
    levels, spans = high.ravel()[::stride], span.ravel()[::stride]
    edges = np.unique(np.quantile(levels, np.linspace(0.0, 1.0, LEVELS + 1))).astype(np.float64)
    bins = np.clip(np.searchsorted(edges, levels, side="right") - 1, 0, edges.size - 1)
    order = np.lexsort((spans, bins))
    starts = np.searchsorted(bins[order], np.arange(edges.size + 1))
    counts = np.diff(starts)
    middle = np.minimum(starts[:-1] + counts // 2, levels.size - 1)
    usual = np.where(counts > 0, np.maximum(spans[order][middle], 1), 1).astype(np.uint16)
    table = usual[np.clip(np.searchsorted(edges, np.arange(int(high.max()) + 1), side="right") - 1, 0, edges.size - 1)]
    return table[high]


def _lit_beside(mosaic: NDArray[np.uint16], found: NDArray[np.int64], excess: NDArray[np.int32]) -> NDArray[np.bool_]:
    """Tell the found pixels beside which one of another colour stands out of its own to the same side."""
    lit = np.zeros(len(found), np.bool_)
    own = excess.astype(np.float64)
    last_row, last_column = (side - 1 for side in mosaic.shape)
    for down, right in ((-1, 0), (1, 0), (0, -1), (0, 1)):
        rows, columns = found[:, 0] + down, found[:, 1] + right
        around = [
            mosaic[np.clip(rows + 2 * i, 0, last_row), np.clip(columns + 2 * j, 0, last_column)].astype(np.int32)
            for i in (-1, 0, 1)
            for j in (-1, 0, 1)
        ]
        beside = around[4] - np.median(around, axis=0)
        lit |= beside * np.sign(own) > SHARED * np.abs(own)
    return lit
