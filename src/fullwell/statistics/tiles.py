"""One sweep over finished maps: what each tile of each plane sums to.

The residual of a tile about a quadratic surface needs no least squares: on a rectangular grid the products of the
discrete orthogonal polynomials of degree 0 to 2 span the six terms 1, u, v, u^2, u v, v^2 and are orthogonal, so each
takes its own share off the sum of squares.
"""

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from fullwell.kernels.moments import Band
from fullwell.kernels.moments_summary import ColumnSums, Maps, Surface, summarize_band
from fullwell.statistics.moments import Layout, Moments

SURFACE_TERMS: Final = 6


@dataclass(frozen=True, slots=True, kw_only=True)
class TileSums:
    """Sums of one plane, each of shape (tile rows, tile columns); the first three hold exact Python integers.

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
    squares: NDArray[np.object_]
    spread: NDArray[np.object_]
    quartic: NDArray[np.float64]
    residual: NDArray[np.float64]


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


def sweep(moments: Moments, *, shift: int, histogram: NDArray[np.int64]) -> tuple[TileSums, ...]:
    """Return the tile sums of each plane; D is counted into ``histogram`` in bins of 2^shift."""
    layout = moments.layout
    maps = Maps(moments.maps.codes, moments.maps.squares, len(moments.frame_sums))
    rows: list[list[TileSums]] = [[] for _ in range(layout.sites)]
    for band in layout.bands():
        surface = _surface(moments, band)
        sums = summarize_band(maps, band, surface, shift, histogram)
        for site in range(layout.sites):
            height = surface.linear[site // layout.cell].size - _padding(band, site // layout.cell)
            if height and layout.plane(site)[1]:
                rows[site].append(_tile_row(sums, site, layout, height))
    return tuple(_stacked(parts) for parts in rows)


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


def _tile_row(sums: ColumnSums, site: int, layout: Layout, height: int) -> TileSums:
    """Gather the column sums of one plane into a row of tiles."""
    phase, column = divmod(site, layout.cell)
    widths = edges(layout.plane(site)[1], layout.tile)
    starts = np.cumsum(widths) - widths
    own = slice(column, None, layout.cell)

    def gathered(values: NDArray[np.float64]) -> NDArray[np.float64]:
        return np.add.reduceat(values, starts)

    def exact(values: NDArray[np.uint64]) -> NDArray[np.object_]:
        return np.add.reduceat(values[phase, own], starts).astype(np.object_)

    u, u2 = polynomials(widths)
    across = (widths.astype(np.float64), gathered(u**2), gathered(u2**2))
    v, v2 = polynomials(np.array([height]))
    down = (float(height), float((v**2).sum()), float((v2**2).sum()))
    centred, linear, quadratic = (part[phase, own] for part in (sums.centred, sums.linear, sums.quadratic))
    fits = (height >= 3) & (widths >= 3)
    residual = gathered(sums.power[phase, own])
    for values, i, j in (
        (centred, 0, 0),
        (linear, 1, 0),
        (centred * u, 0, 1),
        (quadratic, 2, 0),
        (linear * u, 1, 1),
        (centred * u2, 0, 2),
    ):
        residual -= gathered(values) ** 2 / np.where(fits, down[i] * across[j], 1.0)
    return TileSums(
        n=widths * height,
        squares=exact(sums.squares),
        spread=exact(sums.low) + exact(sums.high) * (1 << 32),
        quartic=gathered(sums.quartic[phase, own]),
        residual=np.where(fits, np.maximum(residual, 0.0), np.nan),
    )


def _stacked(parts: list[TileSums]) -> TileSums:
    return TileSums(
        n=np.stack([part.n for part in parts]),
        squares=np.stack([part.squares for part in parts]),
        spread=np.stack([part.spread for part in parts]),
        quartic=np.stack([part.quartic for part in parts]),
        residual=np.stack([part.residual for part in parts]),
    )
