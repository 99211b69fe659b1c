"""Do two bursts show the same shading? A difference over its standard error, not by eye (METHOD 6.5)."""

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray
from scipy.special import chdtrc

from fullwell.fit.goodness import MISFIT_SIZE
from fullwell.fit.shading.data import ShadingData
from fullwell.fit.shading.weighting import FloatArray, TensorGrid, symmetric_inverse
from fullwell.model.shading import Plane, spline_surface

TERMS: Final = (7, 8)
"""Splines along rows and columns: enough for what shading does, few enough for a test with power."""
_CUTOFF: Final = 1e-8
"""Below this share of the largest, a direction is one that no bin of both bursts sees."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ShadingDifference:
    """The smooth part of b/a - 1 after a common scale is removed.

    Parameters
    ----------
    rows, columns
        Where the maps are evaluated, shapes (V,) and (H,) [pixel of the plane].
    difference
        Relative difference of shape, shape (V, H), its weighted mean 0 [1]; NaN where either burst has no bin.
    std_error
        Of ``difference``, of the same shape [1].
    chi_square, dof, p_value
        Test of no difference: of all spline coefficients but the scale, with their covariance.
    largest
        Largest absolute difference over its standard error [1].
    rms
        Root mean square of ``difference`` [1].
    scale
        b over a, all bins together [1].
    misfit
        Whether bins scatter about the smooth difference by more than temporal noise (beyond 99 %); errors are then
        scaled by that scatter.

    """

    rows: NDArray[np.float64]
    columns: NDArray[np.float64]
    difference: NDArray[np.float64]
    std_error: NDArray[np.float64]
    chi_square: float
    dof: int
    p_value: float
    largest: float
    rms: float
    scale: float
    misfit: bool


def compare_shading(
    a: ShadingData, b: ShadingData, *, same_sensor: bool = True, shape: tuple[int, int] = (48, 64)
) -> ShadingDifference:
    """Return how the shading of b differs from that of a (METHOD 6.5).

    Parameters
    ----------
    a, b
        The same bins of two bursts, black subtracted; bins that either leaves out are left out.
    same_sensor
        PRNU is then common to both and drops out, errors are temporal; else it counts in both.
    shape
        Rows and columns of the maps; fewer where the plane has fewer bins.

    Raises
    ------
    ValueError
        Where the bins are not the same, or too few are left.

    """
    used = _common(a, b)
    plane = Plane(rows=a.plane_shape[0], columns=a.plane_shape[1])
    grid = TensorGrid.of(spline_surface(plane, _terms(used)), a.rows, a.columns)
    scale, ratio, weight = _ratio(a, b, used, grid, same_sensor=same_sensor)
    information = grid.gram(weight)
    inverse = symmetric_inverse(information, cutoff=_CUTOFF, whole=False)
    found = inverse @ grid.moments(weight * ratio)
    residual = float(np.sum(weight * (ratio - grid.surface(found)) ** 2))
    terms = round(float(np.sum(inverse * information)))
    spare = int(used.sum()) - terms
    misfit = bool(chdtrc(spare, residual) < MISFIT_SIZE)
    noise = max(residual / spare, 1.0) if misfit else 1.0

    together = information.sum(axis=0)
    level = float(together @ found / together.sum())
    shape_only = found - level
    chi_square = float(shape_only @ information @ shape_only) / noise
    rows, columns, seen = _view(a, used, shape)
    view = TensorGrid.of(spline_surface(plane, _terms(used)), rows, columns)
    difference = np.where(seen, view.surface(shape_only) / (1.0 + level), np.nan)
    spread = noise * (inverse - 1.0 / together.sum())
    std_error = np.where(seen, _errors(view, spread) / (1.0 + level), np.nan)
    return ShadingDifference(
        rows=rows,
        columns=columns,
        difference=difference,
        std_error=std_error,
        chi_square=chi_square,
        dof=terms - 1,
        p_value=float(chdtrc(terms - 1, chi_square)),
        largest=float(np.nanmax(np.abs(difference / std_error))),
        rms=float(np.sqrt(np.nanmean(difference**2))),
        scale=scale * (1.0 + level),
        misfit=misfit,
    )


def _common(a: ShadingData, b: ShadingData) -> NDArray[np.bool_]:
    """Return the bins that both use."""
    same = a.plane_shape == b.plane_shape and np.array_equal(a.rows, b.rows) and np.array_equal(a.columns, b.columns)
    if not same:
        raise ValueError("shading is compared bin by bin; cut both planes into the same bins")
    used = a.used & b.used
    if min(used.shape) < 8 or int(used.sum()) <= 2 * int(np.prod(_terms(used))):
        raise ValueError(f"only {int(used.sum())} bins are used by both; too few to compare shading")
    return used


def _terms(used: NDArray[np.bool_]) -> tuple[int, int]:
    """Return how many splines along rows and columns."""
    return min(TERMS[0], used.shape[0] // 2), min(TERMS[1], used.shape[1] // 2)


def _ratio(
    a: ShadingData, b: ShadingData, used: NDArray[np.bool_], grid: TensorGrid, *, same_sensor: bool
) -> tuple[float, FloatArray, FloatArray]:
    """Return the scale of b over a, b/(scale a) - 1 per bin and its weight; divided by a smooth a, so without bias."""
    signal_a, signal_b = (np.where(used, data.signal_dn, 0.0) for data in (a, b))
    scale = float(signal_b.sum() / signal_a.sum())
    temporal = np.where(used, b.temporal_variance_dn2 + scale**2 * a.temporal_variance_dn2, 1.0)
    even = np.where(used, 1.0 / temporal, 0.0)
    smooth = grid.surface(
        symmetric_inverse(grid.gram(even), cutoff=_CUTOFF, whole=False) @ grid.moments(even * signal_a)
    )
    if not scale > 0.0 or float(smooth[used].min()) <= 0.0:
        raise ValueError("a plane shows no light above black in some place; shading cannot be compared there")
    smooth = np.where(used, scale * smooth, 1.0)
    variance = temporal / smooth**2
    if not same_sensor:
        variance = variance + np.where(used, a.fixed_variance + b.fixed_variance, 0.0)
    return scale, (signal_b - scale * signal_a) / smooth, np.where(used, 1.0 / variance, 0.0)


def _view(
    data: ShadingData, used: NDArray[np.bool_], shape: tuple[int, int]
) -> tuple[FloatArray, FloatArray, NDArray[np.bool_]]:
    """Return rows and columns of bins spread over the plane, and where both bursts have a bin."""
    at_row, at_column = (
        np.unique(np.linspace(0.0, have - 1.0, min(want, have)).round().astype(np.intp))
        for have, want in zip(used.shape, shape, strict=True)
    )
    return data.rows[at_row], data.columns[at_column], used[np.ix_(at_row, at_column)]


def _errors(grid: TensorGrid, covariance: FloatArray) -> FloatArray:
    """Return the standard error of a surface of splines on a grid, from the covariance of its coefficients."""
    rows, columns = grid.kept.shape
    along = covariance.reshape(rows, columns, rows, columns)
    variance = np.einsum("va,vc,hb,hd,abcd->vh", *[grid.row_basis] * 2, *[grid.column_basis] * 2, along, optimize=True)
    return np.sqrt(np.maximum(variance, 0.0))
