"""Fixed pattern as variances with errors: PRNU of a map relative to its surface, DSNU of a dark one (METHOD 5.1, 5.2).

Which function: `nonuniformity` for a map cut in tiles (`fullwell.statistics.pattern`), `dark_nonuniformity` for a dark
burst whose mean squares are known already. `noise_floor` gives the temporal noise that a combination of burst means
keeps.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fullwell.statistics.pattern import Pattern
from fullwell.statistics.series import MeanSquares, TileStatistics
from fullwell.units import Measured


@dataclass(frozen=True, slots=True, kw_only=True)
class NoiseFloor:
    """Temporal noise that a map keeps, in the unit of the map squared (absolute even where the pattern is relative).

    Parameters
    ----------
    variance
        Temporal variance of the map's pixels by tile, row and column noise included, shape (tile rows, tile columns).
    dof
        Degrees of freedom of ``variance``, of the same shape or one for all; infinity where it is known.
    row, column
        Temporal row and column variance that stays in the map; both are part of ``variance``.

    """

    variance: NDArray[np.float64]
    dof: NDArray[np.float64]
    row: float = 0.0
    column: float = 0.0


@dataclass(frozen=True, slots=True, kw_only=True)
class Nonuniformity:
    """Fixed-pattern variances, signed, temporal noise removed; ``row`` + ``column`` + ``pixel`` = ``total``.

    Parameters
    ----------
    total
        Variance of a pixel.
    row, column, pixel
        Of whole rows, of whole columns, of pixels on their own.
    repeat_error
        Standard error of ``total`` given this sensor's pattern: what a repeat on the same pixels scatters by. It is the
        error to compare ISOs or exposures of one sensor with.
    between_tiles_p
        Chance of tiles that differ more than they do if all have the same pattern; 1 for a single tile.
    misfit
        Whether that chance is below 1 %; the errors then come from the scatter between tiles.

    """

    total: Measured
    row: Measured
    column: Measured
    pixel: Measured
    repeat_error: float
    between_tiles_p: float
    misfit: bool


def noise_floor(
    coefficients: ArrayLike,
    temporal_variances: ArrayLike,
    temporal_dof: ArrayLike,
    *,
    frames: ArrayLike,
    row_variances: ArrayLike | None = None,
    column_variances: ArrayLike | None = None,
) -> NoiseFloor:
    """Return the noise of the map sum_k c_k mean_k of K burst means: sum_k c_k^2 s_k^2 / L_k.

    Parameters
    ----------
    coefficients
        c_k, shape (K,): 1 and -1 for a flat less a dark, `line_coefficients` for a slope [map unit / DN].
    temporal_variances, temporal_dof
        s_k^2 of a pixel in one frame, by tile, and its degrees of freedom, shape (K, tile rows, tile columns) [DN^2].
    frames
        L_k, shape (K,).
    row_variances, column_variances
        Temporal row and column variance of one frame of each burst, shape (K,); None: 0 [DN^2].

    Returns
    -------
    NoiseFloor
        Degrees of freedom by Welch and Satterthwaite.

    """
    raise NotImplementedError


def nonuniformity(pattern: Pattern, floor: NoiseFloor, *, unit: str) -> Nonuniformity:
    """Return the fixed-pattern variances of a map (METHOD 5.1, 5.2, 5.5).

    Parameters
    ----------
    pattern
        Of the map.
    floor
        Temporal noise of the map's pixels.
    unit
        Of the variances: 1 where the pattern is relative, else the unit of the map squared.

    Returns
    -------
    Nonuniformity
        Intervals of the modified large-sample method.

    Raises
    ------
    ValueError
        Where no tile counts.

    """
    raise NotImplementedError


def dark_nonuniformity(
    mean_squares: MeanSquares, shape: tuple[int, int, int], *, tiles: TileStatistics | None = None
) -> Nonuniformity:
    """Return the fixed-pattern variances of a dark burst from its three-way layout (METHOD 3.5, 5.1) [DN^2].

    Parameters
    ----------
    mean_squares
        The seven mean squares [DN^2].
    shape
        T frames (at least two), M rows, N columns.
    tiles
        The same burst by tile: their scatter shows heavy-tailed pattern (hot pixels) and widens the errors; None leaves
        errors that hold for a normal pattern only.

    """
    raise NotImplementedError
