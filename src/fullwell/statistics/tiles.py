"""One sweep over finished maps: what each tile of each plane sums to.

The residual of a tile about a quadratic surface needs no least squares: on a rectangular grid the products of the
discrete orthogonal polynomials of degree 0 to 2 span the six terms 1, u, v, u^2, u v, v^2 and are orthogonal, so each
takes its own share off the sum of squares.
"""

from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from functools import lru_cache
from typing import Final

import numpy as np
from numpy.typing import NDArray

from fullwell.kernels.moments_summary import SpreadCounts
from fullwell.kernels.tile_sums import TilePolynomials, Tiles, TileTotals, sum_tiles
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


def empty_totals(layout: Layout) -> TileTotals:
    """Return room for the sums of every tile."""
    rows, columns = layout.tiles
    shape = (rows, layout.sites, columns)
    return TileTotals(np.zeros((*shape, 3), np.uint64), np.zeros((*shape, 8)))


@lru_cache(maxsize=8)
def tile_polynomials(layout: Layout) -> TilePolynomials:
    """Return the polynomials along both axes of every tile."""
    down = np.zeros((2, layout.tiles[0], layout.cell, layout.tile))
    across = np.zeros((2, layout.width))
    for phase in range(layout.cell):
        rows, columns = layout.plane(phase * layout.cell)[0], layout.plane(phase)[1]
        for band, height in enumerate(edges(rows, layout.tile)):
            down[:, band, phase, :height] = polynomials(np.array([height]))
        across[:, phase :: layout.cell] = polynomials(edges(columns, layout.tile))
    return TilePolynomials(down, across)


def sweep(moments: Moments, counts: SpreadCounts, *, workers: int = 1) -> tuple[TileSums, ...]:
    """Return the tile sums of each plane, and count D; on some threads, whose number changes nothing."""
    layout, maps, totals = moments.layout, moments.finished(), empty_totals(moments.layout)
    tiles = Tiles(moments.tile_sums[np.newaxis], int(moments.maps.highest.max()), tile_polynomials(layout))

    def summarize(first: int) -> SpreadCounts:
        own = counts if first == 0 else counts._replace(bins=np.zeros_like(counts.bins))
        for band in layout.bands()[first::workers]:
            sum_tiles(maps, band, tiles, own, totals)
        return own

    if workers == 1:
        summarize(0)
    else:
        with ThreadPoolExecutor(workers) as pool:
            for other in tuple(pool.map(summarize, range(workers)))[1:]:
                np.add(counts.bins, other.bins, out=counts.bins)
    return gathered(totals, layout)


def gathered(totals: TileTotals, layout: Layout) -> tuple[TileSums, ...]:
    """Return the tile sums of each plane."""
    return tuple(_tile_sums(totals, site, layout) for site in range(layout.sites))


@lru_cache(maxsize=8)
def _norms(length: int, tile: int) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the sums of squares of the polynomials of degree 1 and 2 along an axis, by tile."""
    lengths = edges(length, tile)
    starts = np.cumsum(lengths) - lengths
    linear, quadratic = polynomials(lengths)
    return np.add.reduceat(linear**2, starts), np.add.reduceat(quadratic**2, starts)


def _tile_sums(totals: TileTotals, site: int, layout: Layout) -> TileSums:
    """Return the sums of the tiles of one plane, for every row and column of tiles that a plane may have."""
    heights, widths = (edges(side, layout.tile) for side in layout.plane(site))
    whole, real = (part[: heights.size, site, : widths.size] for part in totals)
    squares, spread, high = map(exact_integers, np.moveaxis(whole, -1, 0))
    if high.any():
        spread = spread.astype(np.object_) + high.astype(np.object_) * (1 << 32)
    quartic, power, *products = np.ascontiguousarray(np.moveaxis(real, -1, 0))
    down, across = ((edges(side, layout.tile), *_norms(side, layout.tile)) for side in layout.plane(site))
    fits = (heights[:, np.newaxis] >= 3) & (widths >= 3)
    for product, (i, j) in zip(products, ((0, 0), (1, 0), (0, 1), (2, 0), (1, 1), (0, 2)), strict=True):
        power = power - product**2 / np.where(fits, down[i][:, np.newaxis] * across[j], 1.0)
    return TileSums(
        n=heights[:, np.newaxis] * widths,
        squares=squares,
        spread=spread,
        quartic=quartic,
        residual=np.where(fits, np.maximum(power, 0.0), np.nan),
    )
