"""Temporal noise that a map keeps: what its spatial variance must lose to become fixed pattern (METHOD 5.1, 5.2)."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

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
    row_error, column_error
        Their standard errors.

    """

    variance: NDArray[np.float64]
    dof: NDArray[np.float64] | float
    row: float = 0.0
    column: float = 0.0
    row_error: float = 0.0
    column_error: float = 0.0


def noise_floor(
    coefficients: ArrayLike,
    temporal_variances: ArrayLike,
    temporal_dof: ArrayLike,
    *,
    frames: ArrayLike,
    row_variances: Sequence[Measured] = (),
    column_variances: Sequence[Measured] = (),
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
        Temporal row and column variance of one frame of each burst, K of them; none: 0 [DN^2].

    Returns
    -------
    NoiseFloor
        Degrees of freedom by Welch and Satterthwaite.

    """
    squared = np.asarray(coefficients, np.float64) ** 2 / np.asarray(frames, np.float64)
    parts = squared[:, np.newaxis, np.newaxis] * np.asarray(temporal_variances, np.float64)
    variance = parts.sum(axis=0)
    doubt = np.sum(parts**2 / np.maximum(np.asarray(temporal_dof, np.float64), 1e-300), axis=0)
    row, row_error = _combined(squared, row_variances)
    column, column_error = _combined(squared, column_variances)
    return NoiseFloor(
        variance=variance,
        dof=np.divide(variance**2, doubt, out=np.full(variance.shape, np.inf), where=doubt > 0.0),
        row=row,
        column=column,
        row_error=row_error,
        column_error=column_error,
    )


def _combined(squared: NDArray[np.float64], variances: Sequence[Measured]) -> tuple[float, float]:
    """Return the value and the standard error of a sum."""
    if not variances:
        return 0.0, 0.0
    errors = np.array([one.std_error or 0.0 for one in variances])
    return float(squared @ np.array([one.value for one in variances])), float(np.linalg.norm(squared * errors))
