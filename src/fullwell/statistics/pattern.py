"""Fixed pattern of a map: what is left of each tile when its quadratic surface is taken away (METHOD 5.1, 5.5).

A map is the mean of a burst less that of the dark one, or a slope or an intercept per pixel. Lens shading is gone with
the surface; what is left is laid out in rows and columns, so that row, column and pixel pattern can be told apart.
"""

from dataclasses import dataclass
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from fullwell.kernels.pattern_tiles import Axis, MapPlane, PatternSums, add_patterns
from fullwell.statistics.tiles import SURFACE_TERMS, edges, polynomials

SMALLEST_SIDE: Final = 8
"""Of a tile that a surface of six terms is taken from [pixel]."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Pattern:
    """Variance of one plane of a map about the quadratic surfaces of its tiles, and where it lies.

    With ``relative`` maps every residual is divided by its surface: map / surface - 1.

    Parameters
    ----------
    size
        Edge of a tile [pixel of the plane]; the last row and column of tiles may be smaller.
    n
        Pixels of each tile, shape (tile rows, tile columns).
    dof
        n - 6, of the same shape; 0 where a tile does not count: smaller than 8 pixels on a side, not chosen, holding a
        value that is not finite, or, where relative, with a surface that is not positive everywhere.
    mean
        Mean of the map over each tile [unit of the map].
    variance
        Sum of squared residuals over ``dof`` [unit of the map squared; 1 if relative]; NaN where the tile does not
        count.
    inverse_square
        Mean over the tile of surface^-2, which turns the variance of noise of the map into that of the residuals
        [unit of the map^-2]; 1 if not relative; NaN where the tile does not count.
    row_mean_square, column_mean_square, pixel_mean_square
        Mean squares of the two-way layout of the residuals [as ``variance`` ]. A row is summed over all tiles that
        count in a row of tiles, a column alike; pixels are what is left inside tiles. Their expectations are
        ``columns`` s_row^2 + s_pixel^2, ``rows`` s_column^2 + s_pixel^2, s_pixel^2. NaN without degrees of freedom.
    row_dof, column_dof, pixel_dof
        Their degrees of freedom: sum over rows of tiles of (height - 3), over columns of tiles of (width - 3), and
        over tiles of (n - height - width).
    rows, columns
        Pixels that a column and a row are summed over, on average by degrees of freedom.

    """

    size: int
    n: NDArray[np.int64]
    dof: NDArray[np.int64]
    mean: NDArray[np.float64]
    variance: NDArray[np.float64]
    inverse_square: NDArray[np.float64]
    row_mean_square: float
    column_mean_square: float
    pixel_mean_square: float
    row_dof: int
    column_dof: int
    pixel_dof: int
    rows: float
    columns: float


def pattern(plane: MapPlane, *, tile: int, relative: bool, use: NDArray[np.bool_] | None = None) -> Pattern:
    """Return the fixed pattern of one plane of a map.

    Parameters
    ----------
    plane
        Shape (rows, columns), of any strides [any unit].
    tile
        Edge of a tile, at least 8 [pixel].
    relative
        Whether residuals are divided by their surface.
    use
        Which tiles count, shape (tile rows, tile columns); None: all.

    Examples
    --------
    >>> noise = np.random.default_rng(1).normal(500.0, 2.0, (64, 64))
    >>> found = pattern(noise, tile=32, relative=False)
    >>> found.dof.tolist(), round(float(found.variance.mean()), 1)
    ([[1018, 1018], [1018, 1018]], 4.0)

    """
    if tile < SMALLEST_SIDE:
        raise ValueError(f"a tile has an edge of at least {SMALLEST_SIDE} pixels, not {tile}")
    down, across = (_axis(length, tile) for length in plane.shape)
    sums = _sums(plane, down, across, use, relative=relative)
    n = down.lengths[:, np.newaxis] * across.lengths
    dof = np.where(sums.counts, n - SURFACE_TERMS, 0)
    rows, columns, pixels = _rows(sums, down, across), _columns(sums, down, across), _pixels(sums, down, across)
    inverse_square = sums.inverse / n if relative else np.ones(n.shape)
    return Pattern(
        size=tile,
        n=n,
        dof=dof,
        mean=sums.mean,
        variance=np.divide(sums.power, dof, out=np.full(dof.shape, np.nan), where=sums.counts),
        inverse_square=np.where(sums.counts, inverse_square, np.nan),
        row_mean_square=rows.mean_square,
        column_mean_square=columns.mean_square,
        pixel_mean_square=pixels.mean_square,
        row_dof=rows.dof,
        column_dof=columns.dof,
        pixel_dof=pixels.dof,
        rows=columns.length,
        columns=rows.length,
    )


class _MeanSquare(NamedTuple):
    """A mean square, its degrees of freedom, and the pixels that each sum runs over."""

    mean_square: float
    dof: int
    length: float


def _axis(length: int, tile: int) -> Axis:
    lengths = edges(length, tile)
    return Axis(np.cumsum(lengths) - lengths, lengths, *polynomials(lengths))


def _sums(plane: MapPlane, down: Axis, across: Axis, use: NDArray[np.bool_] | None, *, relative: bool) -> PatternSums:
    large = np.logical_and.outer(down.lengths >= SMALLEST_SIDE, across.lengths >= SMALLEST_SIDE)
    mean, power, inverse, rows, columns = (np.zeros(large.shape) for _ in range(5))
    by_row, by_column = np.zeros(plane.shape[0]), np.zeros(plane.shape[1])
    sums = PatternSums(large if use is None else large & use, mean, power, inverse, rows, columns, by_row, by_column)
    add_patterns(plane, down, across, sums, relative)
    return sums


def _rows(sums: PatternSums, down: Axis, across: Axis) -> _MeanSquare:
    """Return the mean square of whole rows; a surface takes three degrees of freedom off those of its tiles."""
    widths = sums.counts @ across.lengths
    power = np.add.reduceat(sums.by_row**2, down.starts)
    return _pooled(power, widths, (down.lengths - 3) * (widths > 0))


def _columns(sums: PatternSums, down: Axis, across: Axis) -> _MeanSquare:
    """Return the mean square of whole columns."""
    heights = down.lengths @ sums.counts
    power = np.add.reduceat(sums.by_column**2, across.starts)
    return _pooled(power, heights, (across.lengths - 3) * (heights > 0))


def _pixels(sums: PatternSums, down: Axis, across: Axis) -> _MeanSquare:
    """Return the mean square of what the rows and columns of each tile do not hold."""
    heights, widths = down.lengths[:, np.newaxis], across.lengths
    power = float(np.sum(sums.power - sums.rows / widths - sums.columns / heights))
    dof = int(np.sum(sums.counts * (heights * widths - heights - widths)))
    return _MeanSquare(max(power, 0.0) / dof if dof else np.nan, dof, 1.0)


def _pooled(power: NDArray[np.float64], lengths: NDArray[np.int64], dof: NDArray[np.int64]) -> _MeanSquare:
    """Pool squares of sums over ``lengths`` pixels each."""
    total = int(dof.sum())
    if not total:
        return _MeanSquare(np.nan, 0, np.nan)
    mean_square = float(np.sum(power / np.maximum(lengths, 1))) / total
    return _MeanSquare(mean_square, total, float(np.sum(dof * lengths)) / total)
