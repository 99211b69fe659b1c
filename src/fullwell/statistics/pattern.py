"""Fixed pattern of a map: what is left of each tile when its quadratic surface is taken away (METHOD 5.1, 5.5).

A map is the mean of a burst less that of the dark one, or a slope or an intercept per pixel. Lens shading is gone with
the surface; what is left is laid out in rows and columns, so that row, column and pixel pattern can be told apart.
"""

from dataclasses import dataclass
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

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


def pattern(
    plane: NDArray[np.float32 | np.float64], *, tile: int, relative: bool, use: NDArray[np.bool_] | None = None
) -> Pattern:
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
    chosen = np.ones((down.lengths.size, across.lengths.size), np.bool_) if use is None else use
    bands = [
        _band(plane[top : top + height], across, chosen[at], relative=relative)
        for at, (top, height) in enumerate(zip(down.starts, down.lengths, strict=True))
    ]
    dof = np.stack([band.dof for band in bands])
    rows, pixels, columns = _rows(bands), _pixels(bands, across), _columns(bands, across)
    counts = dof > 0
    return Pattern(
        size=tile,
        n=down.lengths[:, np.newaxis] * across.lengths,
        dof=dof,
        mean=np.stack([band.mean for band in bands]),
        variance=np.divide(np.stack([band.power for band in bands]), dof, out=np.full(dof.shape, np.nan), where=counts),
        inverse_square=np.where(counts, np.stack([band.inverse_square for band in bands]), np.nan),
        row_mean_square=rows.mean_square,
        column_mean_square=columns.mean_square,
        pixel_mean_square=pixels.mean_square,
        row_dof=rows.dof,
        column_dof=columns.dof,
        pixel_dof=pixels.dof,
        rows=columns.length,
        columns=rows.length,
    )


class _Axis(NamedTuple):
    """An axis cut in tiles: lengths and starts, polynomials of degree 0 to 2 (3, length), their squares by tile."""

    lengths: NDArray[np.int64]
    starts: NDArray[np.int64]
    basis: NDArray[np.float64]
    squares: NDArray[np.float64]


class _Band(NamedTuple):
    """A row of tiles: sums of squares of the residuals, by tile but for ``columns``, the sums over its height."""

    height: int
    dof: NDArray[np.int64]
    mean: NDArray[np.float64]
    power: NDArray[np.float64]
    inverse_square: NDArray[np.float64]
    rows: NDArray[np.float64]
    columns: NDArray[np.float64]
    widths: NDArray[np.int64]


class _MeanSquare(NamedTuple):
    """A mean square, its degrees of freedom, and the pixels that each sum runs over."""

    mean_square: float
    dof: int
    length: float


def _axis(length: int, tile: int) -> _Axis:
    lengths = edges(length, tile)
    starts = np.cumsum(lengths) - lengths
    basis = np.stack((np.ones(length), *polynomials(lengths)))
    return _Axis(lengths, starts, basis, np.add.reduceat(basis**2, starts, axis=1))


def _band(
    plane: NDArray[np.float32 | np.float64], across: _Axis, chosen: NDArray[np.bool_], *, relative: bool
) -> _Band:
    """Take its surface off each tile of a row of tiles."""
    values = plane.astype(np.float64)
    height = values.shape[0]
    sound = np.logical_and.reduceat(np.isfinite(values).all(axis=0), across.starts)
    values[:, ~np.repeat(sound, across.lengths)] = 1.0
    surface = _surface(values, across)
    counts = chosen & sound & (height >= SMALLEST_SIDE) & (across.lengths >= SMALLEST_SIDE)
    if relative:
        counts &= np.minimum.reduceat(surface.min(axis=0), across.starts) > 0.0
    left_out = ~np.repeat(counts, across.lengths)
    surface[:, left_out] = 1.0
    scale = 1.0 / surface if relative else np.ones_like(surface[:1])
    residuals = (values - surface) * scale
    residuals[:, left_out] = 0.0
    n = height * across.lengths

    def gathered(by_column: NDArray[np.float64]) -> NDArray[np.float64]:
        return np.add.reduceat(by_column, across.starts)

    return _Band(
        height=height,
        dof=np.where(counts, n - SURFACE_TERMS, 0),
        mean=np.where(sound, gathered(values.sum(axis=0)) / n, np.nan),
        power=gathered(np.einsum("vh,vh->h", residuals, residuals)),
        inverse_square=gathered(np.einsum("vh,vh->h", scale, scale)) / (scale.shape[0] * across.lengths),
        rows=np.add.reduceat(residuals, across.starts, axis=1),
        columns=residuals.sum(axis=0),
        widths=np.where(counts, across.lengths, 0),
    )


def _surface(values: NDArray[np.float64], across: _Axis) -> NDArray[np.float64]:
    """Return the quadratic surface of each tile of a row of tiles, of the same shape."""
    down = _axis(values.shape[0], values.shape[0])
    moments = down.basis @ values
    profiles = np.zeros_like(moments)
    for i, j in ((0, 0), (0, 1), (0, 2), (1, 0), (1, 1), (2, 0)):
        squares = down.squares[i, 0] * across.squares[j]
        sums = np.add.reduceat(moments[i] * across.basis[j], across.starts)
        share = np.divide(sums, squares, out=np.zeros_like(sums), where=squares > 0.0)
        profiles[i] += np.repeat(share, across.lengths) * across.basis[j]
    return down.basis.T @ profiles


def _rows(bands: list[_Band]) -> _MeanSquare:
    """Return the mean square of whole rows; a surface takes three degrees of freedom off those of its tiles."""
    widths = np.array([band.widths.sum() for band in bands])
    dof = np.array([band.height - 3 for band in bands]) * (widths > 0)
    power = np.array([np.sum(band.rows.sum(axis=1) ** 2) for band in bands])
    return _pooled(power, widths, dof)


def _columns(bands: list[_Band], across: _Axis) -> _MeanSquare:
    """Return the mean square of whole columns."""
    heights = np.sum([band.height * (band.widths > 0) for band in bands], axis=0)
    dof = (across.lengths - 3) * (heights > 0)
    power = np.add.reduceat(np.sum([band.columns for band in bands], axis=0) ** 2, across.starts)
    return _pooled(power, heights, dof)


def _pixels(bands: list[_Band], across: _Axis) -> _MeanSquare:
    """Return the mean square of what the rows and columns of each tile do not hold."""
    power, dof = 0.0, 0
    for band in bands:
        inside = band.power - np.sum(band.rows**2, axis=0) / across.lengths
        inside -= np.add.reduceat(band.columns**2, across.starts) / band.height
        power += float(inside.sum())
        dof += int(np.sum((band.dof > 0) * (band.height * across.lengths - band.height - across.lengths)))
    return _MeanSquare(max(power, 0.0) / dof if dof else np.nan, dof, 1.0)


def _pooled(power: NDArray[np.float64], lengths: NDArray[np.int64], dof: NDArray[np.int64]) -> _MeanSquare:
    """Pool squares of sums over ``lengths`` pixels each."""
    total = int(dof.sum())
    if not total:
        return _MeanSquare(np.nan, 0, np.nan)
    mean_square = float(np.sum(power / np.maximum(lengths, 1))) / total
    return _MeanSquare(mean_square, total, float(np.sum(dof * lengths)) / total)
