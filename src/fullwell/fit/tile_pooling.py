"""Pool the fixed-pattern variances of tiles, and see whether tiles differ more than they should (METHOD 5.1, 5.5).

The law of one tile: s^2 has nu degrees of freedom about E = pixel pattern + noise floor, so it scatters by 2 E^2 / nu,
and the floor that is taken off by its own error. Row pattern adds a part that all tiles of a row of tiles have in
common, column pattern alike: tiles agree in that part, and their scatter says nothing about its error.
"""

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray
from scipy.special import chdtrc

from fullwell.fit.goodness import MISFIT_SIZE
from fullwell.fit.noise_floor import NoiseFloor
from fullwell.statistics.pattern import SMALLEST_SIDE, Pattern
from fullwell.statistics.series import MeanSquares, TileStatistics
from fullwell.statistics.tiles import edges

_LEAST_FLOOR: Final = 0.1
"""The floor that sets a weight is never taken smaller than this share of its mean."""
_ITERATIONS: Final = 8
_LEAST: Final = float(np.finfo(np.float64).tiny ** 0.25)
"""Least variance that a tile is weighted by, so that a perfectly even map has weights too."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Tiles:
    """The tiles that count; every array has shape (tiles,), every variance the unit of the pattern squared.

    Parameters
    ----------
    band, stripe
        Row and column of tiles that a tile lies in.
    height, width
        Of the tile [pixel].
    dof, variance
        Degrees of freedom and variance about the tile's surface, pattern and noise together.
    floor
        Temporal variance of pixels on their own in it.
    smooth_floor
        The same without its own scatter: weights made of it do not favour tiles whose floor came out low.
    floor_error
        Standard error of ``floor``, independent between tiles.
    row, column
        Row and column variance of the whole plane, that of noise included.

    """

    band: NDArray[np.int64]
    stripe: NDArray[np.int64]
    height: NDArray[np.float64]
    width: NDArray[np.float64]
    dof: NDArray[np.float64]
    variance: NDArray[np.float64]
    floor: NDArray[np.float64]
    smooth_floor: NDArray[np.float64]
    floor_error: NDArray[np.float64]
    row: float
    column: float

    @property
    def row_share(self) -> NDArray[np.float64]:
        """Return by what a row variance of 1 raises the variance of a tile: its surface takes three rows' worth."""
        return self.width * (self.height - 3.0) / self.dof

    @property
    def column_share(self) -> NDArray[np.float64]:
        """Return by what a column variance of 1 raises the variance of a tile."""
        return self.height * (self.width - 3.0) / self.dof


@dataclass(frozen=True, slots=True, kw_only=True)
class PooledTiles:
    """Variance of pixels on their own, pooled over tiles.

    Parameters
    ----------
    pattern
        Fixed pattern, signed: ``floor`` is taken off.
    floor
        Temporal noise.
    weights
        Of the tiles, of sum 1.
    error
        Standard error of ``pattern`` + ``floor`` if the pattern is normal and the same everywhere.
    floor_error
        Standard error of ``floor``.
    scatter
        By what tiles scatter more than that, as a ratio of variances; 1 for a single tile.
    p_value
        Chance of a larger ``scatter``.
    misfit
        Whether that chance is below 1 %.

    """

    pattern: float
    floor: float
    weights: NDArray[np.float64]
    error: float
    floor_error: float
    scatter: float
    p_value: float
    misfit: bool

    @property
    def scatter_dof(self) -> int:
        """Return the degrees of freedom of ``scatter``."""
        return self.weights.size - 1


def pool_tiles(tiles: Tiles) -> PooledTiles:
    """Return the mean of the tiles' pixel variances, weighted by the law of a tile at the common pattern.

    The weights come from the pooled variance, never from that of the tile itself, which would pull the mean down.
    """
    alone = tiles.variance - tiles.row_share * tiles.row - tiles.column_share * tiles.column - tiles.floor
    weights = tiles.dof / tiles.dof.sum()
    for _ in range(_ITERATIONS):
        expected = np.maximum(max(float(weights @ alone), 0.0) + tiles.smooth_floor, _LEAST)
        weights = 1.0 / (2.0 * expected**2 / tiles.dof + tiles.floor_error**2)
        weights /= weights.sum()
    pattern = float(weights @ alone)
    expected = np.maximum(max(pattern, 0.0) + tiles.smooth_floor, _LEAST)
    chi_square = _disagreement(tiles, alone, expected)
    count = weights.size
    p_value = float(chdtrc(count - 1, chi_square)) if count > 1 else 1.0
    return PooledTiles(
        pattern=pattern,
        floor=float(weights @ tiles.floor),
        weights=weights,
        error=float(np.sqrt(np.sum(weights**2 * 2.0 * expected**2 / tiles.dof))),
        floor_error=float(np.sqrt(np.sum((weights * tiles.floor_error) ** 2))),
        scatter=chi_square / (count - 1) if count > 1 else 1.0,
        p_value=p_value,
        misfit=p_value < MISFIT_SIZE,
    )


def _disagreement(tiles: Tiles, alone: NDArray[np.float64], expected: NDArray[np.float64]) -> float:
    """Return chi-square of the tiles about their mean by generalized least squares.

    Their covariance is D + U U': D of each tile alone, U what the tiles of a band and of a stripe have in common.
    Woodbury's identity inverts it by a system as large as bands and stripes together.
    """
    row, column = max(tiles.row, 0.0), max(tiles.column, 0.0)
    crossed = tiles.row_share * row + tiles.column_share * column
    diagonal = (2.0 * expected**2 + 4.0 * crossed * expected) / tiles.dof + tiles.floor_error**2
    bands = _common(tiles.band, tiles.row_share * row, tiles.height - 3.0)
    stripes = _common(tiles.stripe, tiles.column_share * column, tiles.width - 3.0)
    shared = np.concatenate((bands, stripes), axis=1) / np.sqrt(diagonal)[:, np.newaxis]
    inner = np.eye(shared.shape[1]) + shared.T @ shared

    def whitened(vector: NDArray[np.float64]) -> NDArray[np.float64]:
        scaled = vector / np.sqrt(diagonal)
        return (scaled - shared @ np.linalg.solve(inner, shared.T @ scaled)) / np.sqrt(diagonal)

    ones = np.ones(alone.size)
    inverse_ones = whitened(ones)
    residuals = alone - float(inverse_ones @ alone) / float(inverse_ones @ ones)
    return float(residuals @ whitened(residuals))


def _common(group: NDArray[np.int64], part: NDArray[np.float64], dof: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return one column per group: the standard deviation of what its tiles have in common."""
    members = group[:, np.newaxis] == np.unique(group)
    return members * (part * np.sqrt(2.0 / dof))[:, np.newaxis]


def pattern_tiles(pattern: Pattern, floor: NoiseFloor) -> Tiles:
    """Return the tiles of a map that count, the floor brought to the unit of the pattern.

    Raises
    ------
    ValueError
        Where no tile has both a pattern and a floor.

    """
    variance, dof = np.broadcast_arrays(floor.variance, np.asarray(floor.dof, np.float64))
    counts = (pattern.dof > 0) & np.isfinite(variance) & (dof > 0.0)
    if not counts.any():
        raise ValueError("no tile of the map has a pattern and a noise floor: take smaller tiles or more frames")
    band, stripe = np.nonzero(counts)
    variance, dof = variance[counts], dof[counts]
    line_noise = floor.row + floor.column
    smooth, shot = _smooth(variance - line_noise, dof, pattern.mean[counts])
    scale = _relative_scale(pattern.inverse_square[counts], pattern.mean[counts], shot)
    several_bands, several_stripes = (count > 1 for count in pattern.n.shape)
    height = pattern.n[:, 0] / (pattern.size if several_stripes else pattern.columns)
    width = pattern.n[0] / (pattern.size if several_bands else pattern.rows)
    return Tiles(
        band=band,
        stripe=stripe,
        height=height[band],
        width=width[stripe],
        dof=pattern.dof[counts].astype(np.float64),
        variance=pattern.variance[counts],
        floor=(variance - line_noise) * scale,
        smooth_floor=smooth * scale,
        floor_error=(smooth + line_noise) * np.sqrt(2.0 / dof) * scale,
        row=(pattern.row_mean_square - pattern.pixel_mean_square) / pattern.columns,
        column=(pattern.column_mean_square - pattern.pixel_mean_square) / pattern.rows,
    )


def dark_tiles(tiles: TileStatistics, mean_squares: MeanSquares, shape: tuple[int, int, int]) -> Tiles | None:
    """Return the tiles of a dark burst of T frames, M rows, N columns; None where none is large enough [DN^2]."""
    frames, rows, columns = shape
    heights, widths = edges(rows, tiles.size), edges(columns, tiles.size)
    large = (heights[:, np.newaxis] >= SMALLEST_SIDE) & (widths >= SMALLEST_SIDE)
    counts = large & (tiles.spatial_dof > 0) & (tiles.temporal_dof > 0)
    if not counts.any():
        return None
    band, stripe = np.nonzero(counts)
    noise = tiles.temporal_variance[counts] / frames
    dof = tiles.temporal_dof[counts].astype(np.float64)
    line_noise = ((mean_squares.tv - mean_squares.tvh) / columns + (mean_squares.th - mean_squares.tvh) / rows) / frames
    smooth, _ = _smooth(noise - line_noise, dof, tiles.mean[counts])
    return Tiles(
        band=band,
        stripe=stripe,
        height=heights[band].astype(np.float64),
        width=widths[stripe].astype(np.float64),
        dof=tiles.spatial_dof[counts].astype(np.float64),
        variance=tiles.spatial_variance[counts],
        floor=noise - line_noise,
        smooth_floor=smooth,
        floor_error=(smooth + line_noise) * np.sqrt(2.0 / dof),
        row=(mean_squares.v - mean_squares.vh) / (frames * columns),
        column=(mean_squares.h - mean_squares.vh) / (frames * rows),
    )


def _smooth(
    variance: NDArray[np.float64], dof: NDArray[np.float64], level: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return noise as a line along the level, as in photon transfer, and the share of it that grows with the level.

    Where all tiles have one level, all of the noise is taken to grow with it: that of a lit map is shot noise mostly.
    """
    weights = np.minimum(dof, 1e12)
    weights = weights / weights.sum()
    mean, middle = float(weights @ variance), float(weights @ level)
    spread = float(weights @ (level - middle) ** 2)
    if spread <= 1e-12 * middle**2:
        return np.full(level.shape, max(mean, 0.0)), np.ones(level.shape)
    slope = float(weights @ ((level - middle) * (variance - mean))) / spread
    smooth = np.maximum(mean + slope * (level - middle), _LEAST_FLOOR * max(mean, 0.0))
    share = np.divide(slope * level, smooth, out=np.zeros_like(smooth), where=smooth > 0.0)
    return smooth, np.clip(share, 0.0, 1.0)


def _relative_scale(
    inverse_square: NDArray[np.float64], level: NDArray[np.float64], shot: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Return what turns the mean noise of a tile into that of map / surface - 1.

    Constant noise goes by the mean of surface^-2. Shot noise is less where the surface is low: it goes by the mean of
    surface^-1 over the mean level, which for a surface of small spread is surface^-2 times (level^2 surface^-2)^(-2/3).
    """
    if np.all(inverse_square == 1.0):
        return inverse_square
    unevenness = np.maximum(level**2 * inverse_square, 1.0)
    return inverse_square * (1.0 - shot + shot * unevenness ** (-2.0 / 3.0))
