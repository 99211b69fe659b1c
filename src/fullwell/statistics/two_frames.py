"""A series that is two frames becomes numbers without sums of single pixels (`kernels.moments_of_two`)."""

from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from fullwell.kernels.moments_of_two import SumsOfTwo, sum_two
from fullwell.kernels.stack import Band, FrameSums
from fullwell.statistics.batch import Batch
from fullwell.statistics.moments import CODES, Layout, Moments, by_site
from fullwell.statistics.tiles import Swept, column_sums, edges, gathered, polynomials


def add_two(moments: Moments, batch: Batch) -> Swept:
    """Add two frames to moments that are empty, but for their maps, and return what a sweep over these would find.

    Parameters
    ----------
    moments
        Added to; their maps are left alone, so that no other frame may follow.
    batch
        The two frames.

    """
    layout = moments.layout
    frames = FrameSums(
        rows=np.zeros((2, layout.height, layout.cell), np.uint64),
        columns=np.zeros((2, layout.cell, layout.width), np.uint64),
        tiles=np.zeros((2, layout.sites, *layout.tiles), np.uint64),
        open=np.zeros((2, layout.cell, layout.width), np.uint32),
    )
    found = SumsOfTwo(moments.maps, frames, column_sums(layout), np.zeros((2, 2, CODES), np.int64))
    whole = Band(0, layout.height, layout.cell, layout.tile)
    sum_two(batch.stack, whole, _polynomials_down(layout), found)
    moments.add_margins(batch, frames)
    differences = found.differences[..., : int(moments.maps.highest.max()) + 1]
    return Swept(
        tiles=tuple(gathered(found.columns, site, layout) for site in range(layout.sites)),
        medians=tuple(_median_square(counts) for counts in by_site(differences, cell=layout.cell)),
    )


@lru_cache(maxsize=8)
def _polynomials_down(layout: Layout) -> NDArray[np.float64]:
    """Return both polynomials of the row within its tile, shape (2, bands, cell, tile)."""
    found = np.zeros((2, layout.tiles[0], layout.cell, layout.tile))
    for phase in range(layout.cell):
        for band, height in enumerate(edges(layout.plane(phase * layout.cell)[0], layout.tile)):
            found[:, band, phase, :height] = polynomials(np.array([height]))
    found.flags.writeable = False
    return found


def _median_square(counts: NDArray[np.int64]) -> float:
    """Return the exact median of the squares of what was counted.

    Examples
    --------
    >>> _median_square(np.array([1, 1, 0, 2]))
    5.0

    """
    below = np.cumsum(counts)
    n = int(below[-1])
    low, high = np.searchsorted(below, ((n - 1) // 2, n // 2), side="right").tolist()
    return (low * low + high * high) / 2
