"""One sweep over finished maps: what each tile of each plane sums to.

The residual of a tile about a quadratic surface needs no least squares: on a rectangular grid the products of the
discrete orthogonal polynomials of degree 0 to 2 span the six terms 1, u, v, u^2, u v, v^2 and are orthogonal, so each
takes its own share off the sum of squares.
"""

from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from functools import lru_cache
from typing import Final, NamedTuple

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
    return _empty((layout.tiles[0], layout.cell, layout.width))


def _empty(shape: tuple[int, ...]) -> ColumnSums:
    squares, low, high = np.zeros((3, *shape), np.uint64)
    quartic, centred, linear, quadratic, power = np.zeros((5, *shape), np.float64)
    return ColumnSums(squares, low, high, quartic, centred, linear, quadratic, power)


def sweep(moments: Moments, counts: SpreadCounts, *, workers: int = 1) -> tuple[TileSums, ...]:
    """Return the tile sums of each plane, and count D; on some threads, whose number changes nothing."""
    layout = moments.layout
    maps = moments.finished()
    bands = tuple(enumerate(layout.bands()))
    rows: list[tuple[_Across, ...]] = [()] * len(bands)

    def summarize(first: int) -> SpreadCounts:
        own = counts if first == 0 else counts._replace(bins=np.zeros_like(counts.bins))
        sums = _empty((layout.cell, layout.width))
        for at, band in bands[first::workers]:
            for part in sums:
                part[...] = 0
            summarize_band(maps, band, _surface(moments, band), sums, own)
            rows[at] = tuple(_across_tiles(sums, site, layout) for site in range(layout.sites))
        return own

    if workers == 1:
        summarize(0)
    else:
        with ThreadPoolExecutor(workers) as pool:
            for other in tuple(pool.map(summarize, range(workers)))[1:]:
                np.add(counts.bins, other.bins, out=counts.bins)
    return tuple(
        _tile_sums(_Across(np.stack([one.whole for one in own]), np.stack([one.real for one in own])), site, layout)
        for site, own in enumerate(zip(*rows, strict=True))
    )


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


class _Across(NamedTuple):
    """Column sums of one plane added up across each tile, of a row of tiles or of several.

    Parameters
    ----------
    whole
        Sums of Q and of the lower and the upper 32 bits of D, shape (..., tiles, 3).
    real
        Sums of D^2, of the square of S less its reference, and of this times 1, v, u, v2, u v and u2, shape
        (..., tiles, 8).

    """

    whole: NDArray[np.uint64]
    real: NDArray[np.float64]


def gathered(sums: ColumnSums, site: int, layout: Layout) -> TileSums:
    """Gather the column sums of one plane, of shape (bands, cell, width), into its tiles."""
    return _tile_sums(_across_tiles(sums, site, layout), site, layout)


def _across_tiles(sums: ColumnSums, site: int, layout: Layout) -> _Across:
    """Add the columns of one plane up, of shape (..., cell, width), across each of its tiles."""
    phase, column = divmod(site, layout.cell)
    starts, u, u2 = _axis(layout.plane(site)[1], layout.tile)
    own = np.s_[..., phase, column :: layout.cell]
    centred, linear = sums.centred[own], sums.linear[own]
    products = (centred, linear, centred * u, sums.quadratic[own], linear * u, centred * u2)
    whole = (sums.squares[own], sums.low[own], sums.high[own])
    real = (sums.quartic[own], sums.power[own], *products)
    return _Across(
        whole=np.stack([np.add.reduceat(one, starts, axis=-1) for one in whole], axis=-1),
        real=np.stack([np.add.reduceat(one, starts, axis=-1) for one in real], axis=-1),
    )


@lru_cache(maxsize=8)
def _axis(length: int, tile: int) -> tuple[NDArray[np.int64], NDArray[np.float64], NDArray[np.float64]]:
    """Return where the tiles along an axis begin, and the polynomials of degree 1 and 2 along it."""
    lengths = edges(length, tile)
    return np.cumsum(lengths) - lengths, *polynomials(lengths)


def _tile_sums(found: _Across, site: int, layout: Layout) -> TileSums:
    """Return the sums of the tiles of one plane, for every row of tiles that a plane may have."""
    heights, widths = (edges(side, layout.tile) for side in layout.plane(site))
    squares, spread, high = map(exact_integers, np.moveaxis(found.whole[: heights.size], -1, 0))
    if high.any():
        spread = spread.astype(np.object_) + high.astype(np.object_) * (1 << 32)
    quartic, power, *products = np.ascontiguousarray(np.moveaxis(found.real[: heights.size], -1, 0))

    def norms(length: int) -> tuple[NDArray[np.float64], ...]:
        starts, linear, quadratic = _axis(length, layout.tile)
        return np.add.reduceat(linear**2, starts), np.add.reduceat(quadratic**2, starts)

    down, across = ((edges(side, layout.tile), *norms(side)) for side in layout.plane(site))
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
