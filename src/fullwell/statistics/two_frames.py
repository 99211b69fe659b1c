"""A series that is two frames becomes numbers without sums of single pixels (`kernels.moments_of_two`)."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from fullwell.kernels.filtered_products import Part
from fullwell.kernels.high_pass import REACH
from fullwell.kernels.moments_of_two import SumsOfTwo, sum_two
from fullwell.kernels.stack import Band, Stack
from fullwell.statistics.batch import Batch
from fullwell.statistics.high_pass import PassingPair
from fullwell.statistics.moments import CODES, Moments, by_site
from fullwell.statistics.tiles import Swept, empty_totals, gathered, tile_polynomials


def add_two(moments: Moments, batch: Batch, passing: Sequence[PassingPair | None] = ()) -> Swept:
    """Add two frames to moments that are empty, but for their maps, and return what a sweep over these would find.

    Parameters
    ----------
    moments
        Added to; their maps are left alone, so that no other frame may follow.
    batch
        The two frames; some rows of tiles at a time are asked for, and those above that the filter reaches.
    passing
        Planes that are filtered on the way, one for each, None for one that is not.

    """
    layout, maps = moments.layout, moments.maps
    addition = moments.begin(batch)
    found = SumsOfTwo(
        maps,
        addition.frames,
        empty_totals(layout),
        differences=np.zeros((2, 2, CODES), np.int64),
        codes=addition.histogram,
        counted=addition.places,
    )
    for rows in layout.parts():
        stack = batch.rows(rows)
        sum_two(stack, rows, tile_polynomials(layout), found)
        tiles = slice(rows.top // (rows.cell * rows.tile), -(-rows.bottom // (rows.cell * rows.tile)))
        for site, plane in enumerate(passing):
            if plane is not None:
                extremes = int(maps.lowest[site, tiles].min()), int(maps.highest[site, tiles].max())
                plane.add(_part(stack, rows, site), extremes)
    addition.commit()
    differences = found.differences[..., : int(maps.highest.max()) + 1]
    return Swept(
        tiles=gathered(found.totals, layout),
        medians=tuple(_median_square(counts) for counts in by_site(differences, cell=layout.cell)),
    )


def _part(stack: Stack, rows: Band, site: int) -> Part:
    """Return some rows of a plane, with those above that the filter reaches."""
    cell, width = rows.cell, stack.width
    phase, column = divmod(site, cell)
    begin = max(0, rows.top - REACH * cell)
    first, second = (
        stack.codes[start + begin * width : start + rows.bottom * width].reshape(-1, width)[phase::cell, column::cell]
        for start in stack.starts.tolist()
    )
    return Part(
        np.ascontiguousarray(first),
        np.ascontiguousarray(second),
        begin // cell,
        rows.top // cell,
        -((phase - rows.bottom) // cell),
    )


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
