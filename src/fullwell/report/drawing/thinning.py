"""Lines with more points than can be seen: of each narrow column only the first, lowest, highest and last are drawn."""

from typing import Final

import numpy as np

from fullwell.report.drawing.geometry import Array

_COLUMN: Final = 0.24
"""Width of a column [point]: a third of a pixel of a common screen."""


def thinned(x: Array, y: Array) -> tuple[Array, Array]:
    """Return a line that looks the same, of fewer points where it has many of them side by side.

    Parameters
    ----------
    x, y
        Places; only a line that goes from left to right or down, and on and on, is thinned [point].

    """
    if x.size < 400:
        return x, y
    for along, upon in ((x, y), (y, x)):
        known = along[np.isfinite(along)]
        if np.all(np.diff(known) >= 0.0) or np.all(np.diff(known) <= 0.0):
            kept = _kept(along, upon)
            return x[kept], y[kept]
    return x, y


def _kept(along: Array, upon: Array) -> np.ndarray:
    """Return the indices of what is drawn: of a column first, last and both extremes, and every gap."""
    known = np.isfinite(along) & np.isfinite(upon)
    column = np.floor(np.where(known, along, 0.0) / _COLUMN)
    fresh = np.ones(along.size, bool)
    fresh[1:] = (column[1:] != column[:-1]) | (known[1:] != known[:-1])
    starts = np.flatnonzero(fresh)
    group = np.cumsum(fresh) - 1
    order = np.lexsort((np.where(known, upon, 0.0), group))
    ends = np.append(starts[1:], along.size) - 1
    return np.unique(np.concatenate([starts, ends, order[starts], order[ends]]))
