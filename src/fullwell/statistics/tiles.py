"""One sweep over finished maps: what each tile of each plane sums to.

The residual of a tile about a quadratic surface needs no least squares: on a rectangular grid the products of the
discrete orthogonal polynomials of degree 0 to 2 span the six terms 1, u, v, u^2, u v, v^2 and are orthogonal, so each
takes its own share off the sum of squares.
"""

from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from fullwell.kernels.moments_summary import ColumnSums, SpreadCounts, Surface, summarize_band
from fullwell.kernels.stack import Band
from fullwell.statistics.exact import Whole, exact_integers
from fullwell.statistics.moments import Layout, Moments

SURFACE_TERMS: Final = 6


@dataclass(frozen=True, slots=True, kw_only=True)
class TileSums:
    """Sums of one plane, each of shape (tile rows, tile columns); the first three are exact, and so are their sums.

    Parameters
    ----------
    n
        Pixels.
    squares
        Sum of x^2 over pixels and frames.
    spread
        Sum over pixels of D = L Q - S^2.
    quartic
        Sum over pixels of D^2.
    residual
        Sum of squares of S about its quadratic surface; NaN where the tile is too small for one.

    """

    n: NDArray[np.int64]
    squares: Whole
    spread: Whole
    quartic: NDArray[np.float64]
    residual: NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True)
class Swept:
    """What a sweep over the pixels of a series finds; one entry per plane.

    Parameters
    ----------
    tiles
        Sums of each tile.
    medians
        Median of D; NaN for a single frame.

    """

    tiles: tuple[TileSums, ...]
    medians: tuple[float, ...]


def edges(length: int, tile: int) -> NDArray[np.int64]:
    """Return the lengths of the tiles along an axis.

    Examples
    --------
    >>> edges(150, 64)
    array([64, 64, 22])

    """
    starts = np.arange(0, length, tile, dtype=np.int64)
    return np.minimum(tile, length - starts)


def polynomials(lengths: NDArray[np.int64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the orthogonal polynomials of degree 1 and 2 along an axis of tiles, one tile after the other."""
    n = np.repeat(lengths, lengths)
    starts = np.repeat(np.cumsum(lengths) - lengths, lengths)
    linear = np.arange(n.size) - starts - (n - 1) / 2
    return linear, linear**2 - (n * n - 1) / 12


def column_sums(layout: Layout) -> ColumnSums:
    """Return empty sums down the columns of each band, shape (bands, cell, width)."""
    shape = (layout.tiles[0], layout.cell, layout.width)
    squares, low, high = np.zeros((3, *shape), np.uint64)
    quartic, centred, linear, quadratic, power = np.zeros((5, *shape), np.float64)
    return ColumnSums(squares, low, high, quartic, centred, linear, quadratic, power)


def sweep(moments: Moments, counts: SpreadCounts, *, workers: int = 1) -> tuple[TileSums, ...]:
    """Return the tile sums of each plane, and count D; on some threads, whose number changes nothing."""
    layout = moments.layout
    maps = moments.finished()
    bands = tuple(enumerate(layout.bands()))
    sums = column_sums(layout)

    def summarize(first: int) -> SpreadCounts:
        own = counts if first == 0 else counts._replace(bins=np.zeros_like(counts.bins))
        for at, band in bands[first::workers]:
            summarize_band(maps, band, _surface(moments, band), ColumnSums(*(part[at] for part in sums)), own)
        return own

    if workers == 1:
        summarize(0)
    else:
        with ThreadPoolExecutor(workers) as pool:
            for other in tuple(pool.map(summarize, range(workers)))[1:]:
                np.add(counts.bins, other.bins, out=counts.bins)
    return tuple(gathered(sums, site, layout) for site in range(layout.sites))


def _padding(band: Band, phase: int) -> int:
    """Return by how many rows a phase of the band falls short of the longest."""
    height = band.bottom - band.top
    return -(-height // band.cell) - -((phase - height) // band.cell)


def _surface(moments: Moments, band: Band) -> Surface:
    """Centre a band on the rounded mean of each tile."""
    layout, tile_row = moments.layout, band.top // (band.cell * band.tile)
    reference = np.zeros((layout.cell, layout.width))
    longest = -(-(band.bottom - band.top) // band.cell)
    linear, quadratic = np.zeros((layout.cell, longest)), np.zeros((layout.cell, longest))
    for phase in range(layout.cell):
        height = longest - _padding(band, phase)
        if not height:
            continue
        linear[phase, :height], quadratic[phase, :height] = polynomials(np.array([height]))
        for column in range(layout.cell):
            site = phase * layout.cell + column
            widths = edges(layout.plane(site)[1], layout.tile)
            means = np.rint(moments.tile_sums[site, tile_row, : widths.size] / (widths * height))
            reference[phase, column :: layout.cell] = np.repeat(means, widths)
    return Surface(reference, linear, quadratic)


def gathered(sums: ColumnSums, site: int, layout: Layout) -> TileSums:
    """Gather the column sums of one plane, of shape (bands, cell, width), into its tiles."""
    phase, column = divmod(site, layout.cell)
    heights, widths = (edges(side, layout.tile) for side in layout.plane(site))
    starts = np.cumsum(widths) - widths
    own = (slice(heights.size), phase, slice(column, None, layout.cell))

    def across_tiles(values: NDArray[np.float64]) -> NDArray[np.float64]:
        return np.add.reduceat(values, starts, axis=-1)

    def exact(values: NDArray[np.uint64]) -> Whole:
        return exact_integers(np.add.reduceat(values[own], starts, axis=-1))

    spread, high = exact(sums.low), exact(sums.high)
    if high.any():
        spread = spread.astype(np.object_) + high.astype(np.object_) * (1 << 32)
    u, u2 = polynomials(widths)
    across = (widths.astype(np.float64), across_tiles(u**2), across_tiles(u2**2))
    tops = np.cumsum(heights) - heights
    v, v2 = polynomials(heights)
    down = (heights.astype(np.float64), np.add.reduceat(v**2, tops), np.add.reduceat(v2**2, tops))
    centred, linear, quadratic = (part[own] for part in (sums.centred, sums.linear, sums.quadratic))
    fits = (heights[:, np.newaxis] >= 3) & (widths >= 3)
    residual = across_tiles(sums.power[own])
    for values, i, j in (
        (centred, 0, 0),
        (linear, 1, 0),
        (centred * u, 0, 1),
        (quadratic, 2, 0),
        (linear * u, 1, 1),
        (centred * u2, 0, 2),
    ):
        residual -= across_tiles(values) ** 2 / np.where(fits, down[i][:, np.newaxis] * across[j], 1.0)
    return TileSums(
        n=heights[:, np.newaxis] * widths,
        squares=exact(sums.squares),
        spread=spread,
        quartic=across_tiles(sums.quartic[own]),
        residual=np.where(fits, np.maximum(residual, 0.0), np.nan),
    )
