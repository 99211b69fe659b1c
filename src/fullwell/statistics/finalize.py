"""Moments become the numbers of a series; see `statistics.series` for what each of them means."""

from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from itertools import chain, repeat

import numpy as np
from numpy.typing import NDArray

from fullwell.kernels.moments_summary import SpreadCounts
from fullwell.raw.cfa import channels
from fullwell.statistics.anova import MarginalSquares
from fullwell.statistics.burst import LEGACY_FRAMES, BurstSums
from fullwell.statistics.exact import Whole, sum_of_squares
from fullwell.statistics.median import BINS, SpreadHistogram, medians, shift_for
from fullwell.statistics.moments import Moments
from fullwell.statistics.pairs import PairStatistics
from fullwell.statistics.series import Histogram, PlaneStatistics, SeriesStatistics, TileStatistics
from fullwell.statistics.tiles import SURFACE_TERMS, Swept, TileSums, sweep

_NAN = float("nan")
_EXACT = 1 << 53
"""Whole numbers below it are exact in double precision."""


def finalize(
    moments: Moments,
    *,
    bursts: Sequence[BurstSums] | None = None,
    pairs: Sequence[PairStatistics] | None = None,
    swept: Swept | None = None,
    workers: int = 1,
) -> SeriesStatistics:
    """Return the statistics of a series.

    Parameters
    ----------
    moments
        All frames of the series, at least one.
    bursts
        Sums of the first five frames by name, one per plane (`burst.burst_sums`); needed only where the series has
        more frames than that, and the legacy statistics are None where they are missing then.
    pairs
        The first two frames of each plane, where somebody wants to know of them.
    swept
        What a sweep over the maps finds, where it is known already; the maps are not looked at then.
    workers
        Threads that look at the maps; their number changes nothing.

    """
    names = moments.names
    if not names:
        raise ValueError("a series without frames has no statistics")
    swept = swept or _swept(moments, workers=workers)
    if len(names) <= LEGACY_FRAMES:
        bursts = [_burst(moments, site, sums) for site, sums in enumerate(swept.tiles)]
    planes: list[PlaneStatistics] = []
    for site, sums in enumerate(swept.tiles):
        plane = _plane(moments, site, sums, median=swept.medians[site], burst=bursts[site] if bursts else None)
        planes.append(replace(plane, pair=pairs[site]) if pairs else plane)
    whole = sum(bursts[1:], start=bursts[0]) if bursts else None
    return SeriesStatistics(frames=names, planes=tuple(planes), legacy=whole.legacy() if whole else None)


def _swept(moments: Moments, *, workers: int) -> Swept:
    """Return the tile sums and the exact median of D of each plane, from the maps."""
    layout, frames = moments.layout, len(moments.names)
    maps = moments.finished()
    shift = shift_for(maps)
    counts = np.zeros((layout.sites, BINS), np.int64)
    tiles = sweep(moments, SpreadCounts(counts, shift), workers=workers)
    if frames == 1:
        return Swept(tiles=tiles, medians=(_NAN,) * layout.sites)
    histograms = [SpreadHistogram(counts=own, shift=shift) for own in counts]
    by_phase = [histograms[first : first + layout.cell] for first in range(0, layout.sites, layout.cell)]
    with ThreadPoolExecutor(workers) as pool:
        found = pool.map(medians, by_phase, repeat(maps), range(layout.cell))
        return Swept(tiles=tiles, medians=tuple(chain.from_iterable(found)))


def _burst(moments: Moments, site: int, sums: TileSums) -> BurstSums:
    """Return the sums of a short series, which is its own first burst."""
    rows, columns = moments.layout.plane(site)
    squares = int(sums.squares.sum())
    return BurstSums(
        frame_sums=tuple(moments.frame_sums[name][site] for name in moments.names),
        pixels=rows * columns,
        squares=squares,
        squared_sums=len(moments.names) * squares - int(sums.spread.sum()),
    )


def _plane(moments: Moments, site: int, sums: TileSums, *, median: float, burst: BurstSums | None) -> PlaneStatistics:
    layout, names = moments.layout, moments.names
    rows, columns = layout.plane(site)
    n, frames = rows * columns, len(names)
    totals = [moments.frame_sums[name][site] for name in names]
    layout_squares = _marginal_squares(moments, site, sums)
    spread, pairs = int(sums.spread.sum()), frames * (frames - 1)
    between_pixels = layout_squares.vh * n - layout_squares.total**2
    return PlaneStatistics(
        channel=channels(layout.cfa)[site],
        frames=frames,
        rows=rows,
        columns=columns,
        frame_means=np.array([total / n for total in totals]),
        mean=layout_squares.total / (n * frames),
        mean_squares=layout_squares.mean_squares(),
        temporal_variance=spread / (n * pairs) if pairs else _NAN,
        temporal_variance_scatter=_scatter(float(sums.quartic.sum()), spread, n, pairs),
        temporal_variance_median=median / pairs if pairs else _NAN,
        spatial_variance=between_pixels / (n * (n - 1) * frames**2) if n > 1 else _NAN,
        tiles=_tiles(moments, site, sums),
        histogram=_histogram(moments, site),
        legacy=burst.legacy() if burst else None,
    )


def _scatter(quartic: float, spread: int, n: int, pairs: int) -> float:
    """Return the variance over pixels of D / pairs, from the sums of D^2 and D."""
    if not pairs or n < 2:
        return _NAN
    return max(0.0, quartic - spread * spread / n) / (n - 1) / pairs**2


def _marginal_squares(moments: Moments, site: int, sums: TileSums) -> MarginalSquares:
    layout = moments.layout
    row, column = divmod(site, layout.cell)
    rows, columns = layout.plane(site)
    totals = [moments.frame_sums[name][site] for name in moments.names]
    squares = int(sums.squares.sum())
    return MarginalSquares(
        frames=len(totals),
        rows=rows,
        columns=columns,
        total=sum(totals),
        tvh=squares,
        t=sum(total * total for total in totals),
        v=sum_of_squares(moments.row_sums[row :: layout.cell, column]),
        h=sum_of_squares(moments.column_sums[row, column :: layout.cell]),
        tv=moments.row_squares[site],
        th=moments.column_squares[site],
        vh=len(totals) * squares - int(sums.spread.sum()),
    )


def _tiles(moments: Moments, site: int, sums: TileSums) -> TileStatistics:
    frames, n = len(moments.names), sums.n
    grid = (slice(n.shape[0]), slice(n.shape[1]))
    sum_of_all = moments.tile_sums[site][grid]
    most = frames * int(sum_of_all.max()) ** 2 + int(n.max()) * int(sums.spread.max()) + int(n.max()) ** 2 * frames**2
    kind: type = np.int64 if most < _EXACT else np.object_
    total, spread, exact_n = sum_of_all.astype(kind), sums.spread.astype(kind), n.astype(kind)
    low, high = (half[site][grid].astype(kind) for half in moments.tile_squares)
    between_frames = frames * (low + high * (1 << 32)) - total * total
    temporal_dof = (n - 1) * (frames - 1)
    temporal = _ratios(exact_n * spread - between_frames, exact_n * frames * temporal_dof.astype(kind))
    spatial_dof = np.where(np.isnan(sums.residual), 0, np.maximum(n - SURFACE_TERMS, 0))
    spatial = np.divide(sums.residual / frames**2, spatial_dof, out=np.full(n.shape, np.nan), where=spatial_dof > 0)
    return TileStatistics(
        size=moments.layout.tile,
        n=n,
        mean=_ratios(total, exact_n * frames),
        temporal_variance=temporal,
        temporal_dof=temporal_dof,
        spatial_variance=spatial,
        spatial_dof=spatial_dof,
        lowest=moments.maps.lowest[site][grid].astype(np.int64),
        highest=moments.maps.highest[site][grid].astype(np.int64),
        n_lowest=moments.maps.n_lowest[site][grid].copy(),
        n_highest=moments.maps.n_highest[site][grid].copy(),
    )


def _ratios(numerator: Whole, denominator: Whole) -> NDArray[np.float64]:
    """Return quotients of whole numbers, Python's own or below 2^53, each rounded once; NaN where the divisor is 0."""
    nothing = denominator == 0
    quotient = numerator / np.where(nothing, 1, denominator)
    return np.where(nothing, np.nan, quotient.astype(np.float64))


def _histogram(moments: Moments, site: int) -> Histogram:
    counts = moments.histogram[site]
    present = np.flatnonzero(counts)
    first, last = int(present[0]), int(present[-1])
    return Histogram(first_code=first, counts=counts[first : last + 1].copy(), frames=len(moments.histogram_frames))
