"""What is kept of a series once its moments are complete: numbers per CFA plane and tile, no pixels."""

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from fullwell.statistics.pairs import PairStatistics

_BODY: Final = (0.005, 0.995)
"""Quantiles of the codes between which no hot pixel lies, were there one in two hundred."""


@dataclass(frozen=True, slots=True, kw_only=True)
class MeanSquares:
    """Mean squares of the three-way layout frame t x row v x column h (METHOD 3.5), from exact marginal sums [DN^2].

    Degrees of freedom follow from the shape: ``t`` T-1, ``v`` M-1, ``h`` N-1, and their products for the interactions.
    Those with ``t`` are NaN for a single frame.
    """

    t: float
    v: float
    h: float
    tv: float
    th: float
    vh: float
    tvh: float


@dataclass(frozen=True, slots=True, kw_only=True)
class Histogram:
    """Exact counts of raw codes.

    Parameters
    ----------
    first_code
        Code of ``counts[0]`` [DN].
    counts
        Shape (codes,), from the lowest to the highest code present.
    frames
        Frames counted.

    """

    first_code: int
    counts: NDArray[np.int64]
    frames: int


@dataclass(frozen=True, slots=True, kw_only=True)
class TileStatistics:
    """Numbers per tile of one plane; every array has shape (tile rows, tile columns).

    Parameters
    ----------
    size
        Edge of a whole tile, in pixels of the plane; tiles at the right and bottom edge may be smaller.
    n
        Pixels of the plane in the tile.
    mean
        Mean over pixels and frames [DN].
    temporal_variance
        Mean over pixels of the per-pixel variance over frames, each frame's own tile mean removed first (light flicker
        drops out) [DN^2]; NaN for a single frame.
    temporal_dof
        (n - 1)(L - 1).
    spatial_variance
        Residual variance of the L-frame mean about a quadratic surface [DN^2], divisor n - 6.
    spatial_dof
        n - 6 (0 where the tile is too small).
    lowest, highest
        Extreme codes over all frames [DN].
    n_lowest, n_highest
        How often they occur, over all frames.

    """

    size: int
    n: NDArray[np.int64]
    mean: NDArray[np.float64]
    temporal_variance: NDArray[np.float64]
    temporal_dof: NDArray[np.int64]
    spatial_variance: NDArray[np.float64]
    spatial_dof: NDArray[np.int64]
    lowest: NDArray[np.int64]
    highest: NDArray[np.int64]
    n_lowest: NDArray[np.int64]
    n_highest: NDArray[np.int64]


@dataclass(frozen=True, slots=True, kw_only=True)
class LegacyBurst:
    """What the published read-noise flows need of the first five frames by name (fewer if the series has fewer).

    Parameters
    ----------
    frames
        L, at most five.
    n
        Pixels.
    pair_variance
        Mean over all L(L-1)/2 pairs of the spatial variance (divisor n - 1) of the difference of two frames [DN^2].
    residual_variance
        Mean over the L frames of the spatial variance (divisor n - 1) of frame minus burst mean [DN^2].

    """

    frames: int
    n: int
    pair_variance: float
    residual_variance: float


@dataclass(frozen=True, slots=True, kw_only=True)
class PlaneStatistics:
    """What a series says about one CFA plane.

    Parameters
    ----------
    channel
        ``R``, ``G1``, ``G2``, ``B`` or ``mono``.
    frames, rows, columns
        L, M, N of the plane.
    frame_means
        Mean of each frame, in name order, shape (L,) [DN].
    mean
        Mean of all pixel values [DN].
    mean_squares
        The three-way layout's mean squares.
    temporal_variance
        Mean over pixels of the per-pixel unbiased variance over frames, nothing removed [DN^2]; NaN for one frame.
    temporal_variance_scatter
        Variance over pixels of the per-pixel variance [DN^4].
    temporal_variance_median
        Median over pixels of the per-pixel variance [DN^2].
    spatial_variance
        Plain variance over pixels of the L-frame mean, divisor n - 1 [DN^2].
    tiles
        The same per tile.
    histogram
        All frames for dark and bias series; the first frame by name for the others.
    legacy
        First five frames; None for a single frame.
    pair
        First two frames; None where nobody asked for them.
    code_step
        Distance of its codes q [DN]: 1 where nobody looked.

    """

    channel: str
    frames: int
    rows: int
    columns: int
    frame_means: NDArray[np.float64]
    mean: float
    mean_squares: MeanSquares
    temporal_variance: float
    temporal_variance_scatter: float
    temporal_variance_median: float
    spatial_variance: float
    tiles: TileStatistics
    histogram: Histogram
    legacy: LegacyBurst | None
    pair: PairStatistics | None = None
    code_step: float = 1.0

    @property
    def n(self) -> int:
        """Return the pixels of the plane."""
        return self.rows * self.columns

    @property
    def shape(self) -> tuple[int, int, int]:
        """Return frames, rows, columns: the layout of ``mean_squares``."""
        return (self.frames, self.rows, self.columns)

    @property
    def mean_std_error(self) -> float | None:
        """Return the standard error of ``mean`` from the scatter of the frame means; None for one frame [DN]."""
        if self.frames < 2:
            return None
        return float(self.frame_means.std(ddof=1) / self.frames**0.5)

    @property
    def fixed_spread(self) -> float:
        """Return the standard deviation over pixels of their levels, temporal noise removed; at least 0 [DN]."""
        if self.frames < 2:
            return 0.0
        return max(self.spatial_variance - self.temporal_variance / self.frames, 0.0) ** 0.5

    @property
    def body_variance(self) -> float:
        """Return the variance of the codes of the middle 99 %, pixels and frames alike: without hot ones [DN^2]."""
        counts = self.histogram.counts
        low, high = np.searchsorted(np.cumsum(counts), np.array(_BODY) * counts.sum())
        codes, weights = np.arange(low, high + 1), counts[low : high + 1]
        return float(np.average((codes - np.average(codes, weights=weights)) ** 2, weights=weights))

    @property
    def body_spread(self) -> float:
        """Return `fixed_spread` of the pixels whose codes are among the middle 99 %, if less: without hot ones [DN]."""
        if self.fixed_spread == 0.0:
            return 0.0
        return min(self.fixed_spread, max(self.body_variance - self.temporal_variance, 0.0) ** 0.5)


@dataclass(frozen=True, slots=True, kw_only=True)
class SeriesStatistics:
    """Every plane of a series, and the first five frames of the whole mosaic for the published flows.

    Parameters
    ----------
    frames
        Names of the frames that were used, sorted.
    planes
        One per CFA site, row-major.
    legacy
        The whole mosaic, all planes mixed as published; None for a single frame.

    """

    frames: tuple[str, ...]
    planes: tuple[PlaneStatistics, ...]
    legacy: LegacyBurst | None
