"""How much a lens shades: the surface at the corners and edges of the plane, relative to its maximum."""

from dataclasses import dataclass
from functools import cache
from typing import Final

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import hadamard

from fullwell.fit.shading.data import ShadingData
from fullwell.fit.shading.surface import ShadingModel
from fullwell.model.shading import CosineSurface, RadialSurface
from fullwell.units import ONE, Measured

PIXEL: Final = "pixel"
_SHADES: Final = 2.0
"""Standard errors from which a curvature is one."""
_GRID: Final = (13, 17)
"""Rows and columns where a maximum is looked for; with the maximum itself fewer than 256."""


@dataclass(frozen=True, slots=True, kw_only=True)
class CornerAndEdges:
    """Relative illumination, 1 at the maximum of the surface [1]; ``cos4-fixed`` was not measured: without errors.

    Parameters
    ----------
    corner
        Mean over the centres of the four corner pixels of the plane.
    edge_x
        Mean over the first and the last column, in the middle row.
    edge_y
        Mean over the first and the last row, in the middle column.

    """

    corner: Measured
    edge_x: Measured
    edge_y: Measured


@dataclass(frozen=True, slots=True, kw_only=True)
class OpticalAxis:
    """Where the axis of the lens meets the plane [pixel of the plane].

    Parameters
    ----------
    row, column
        The place, from 0 at the centre of the first pixel.
    focal_length
        Of the cosine-fourth law; None for others. Times the pitch of the plane it is a length.

    """

    row: Measured
    column: Measured
    focal_length: Measured | None


def corner_and_edges(model: ShadingModel, *, temporal: bool = False) -> CornerAndEdges:
    """Return corner and edges of a surface; their errors count that of the maximum and all covariances.

    The maximum of a surface that hardly shades is partly that of its noise: what it is too high by is taken off, and
    counts as an error too. A free centre can follow noise further than that. Where the bins do not tell the plane from
    an even one, the error is at least what seems to be missing from 1.

    Parameters
    ----------
    model
        A fitted surface.
    temporal
        Errors by temporal noise alone, for comparisons of bursts of one sensor.

    """
    row, column = _places(model)
    value, covariance = model.surface_and_covariance(row, column, temporal=temporal)
    excess = _excess_of_maximum(model)
    top = value[-1] - excess

    def share(places: slice) -> Measured:
        ratio = float(value[places].mean() / top)
        if model.name == "cos4-fixed":
            return Measured.exact(ratio, ONE)
        slope = np.zeros(value.size)
        slope[places] = 1.0 / value[places].size
        slope[-1] = -ratio
        variance = (float(slope @ covariance @ slope) + (ratio * excess) ** 2) / top**2
        least = 0.0 if model.shades else abs(1.0 - ratio)
        return Measured.normal(ratio, max(float(np.sqrt(max(variance, 0.0))), least), ONE)

    return CornerAndEdges(corner=share(slice(0, 4)), edge_x=share(slice(4, 6)), edge_y=share(slice(6, 8)))


def _places(model: ShadingModel) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return rows and columns of four corners, two edges in x, two in y, and the maximum [pixel]."""
    bottom, right = (size - 1.0 for size in model.plane_shape)
    middle_row, middle_column = bottom / 2.0, right / 2.0
    row = [0.0, 0.0, bottom, bottom, middle_row, middle_row, 0.0, bottom, model.centre[0]]
    column = [0.0, right, 0.0, right, 0.0, right, middle_column, middle_column, model.centre[1]]
    return np.array(row), np.array(column)


def _excess_of_maximum(model: ShadingModel) -> float:
    """Return how much higher the maximum of the surface is than of its expectation, on average [DN].

    Estimated as the mean excess that the surface's own errors would add to it: the parameters move along all axes of
    their errors at once, in patterns of signs that are balanced and orthogonal (a Hadamard matrix), on a grid.
    """
    rows, columns = (np.linspace(0.0, size - 1.0, count) for size, count in zip(model.plane_shape, _GRID, strict=True))
    row = np.append(np.repeat(rows, columns.size), model.centre[0])
    column = np.append(np.tile(columns, rows.size), model.centre[1])
    value = model.surface(row, column)
    axes = _axes_of_errors(model.equation.jacobian(row, column, model.values), model.covariance)
    moved = value[:, None] + axes @ _signs()[1 : 1 + axes.shape[1]]
    return float(np.mean(np.max(moved - moved[-1], axis=0)))


@cache
def _signs() -> NDArray[np.float64]:
    """Return 256 balanced and orthogonal patterns of signs."""
    return hadamard(256).astype(np.float64)


def _axes_of_errors(slopes: NDArray[np.float64], covariance: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the axes of the errors of n places, each as long as its standard error, shape (n, axes) [DN].

    They are the eigenvectors of slopes' C slopes, found in the smaller space of the parameters.

    Parameters
    ----------
    slopes
        Derivatives by the parameters, shape (parameters, n).
    covariance
        C, of the parameters.

    """
    variance, directions = np.linalg.eigh(covariance)
    factor = (directions * np.sqrt(np.maximum(variance, 0.0))).T @ slopes
    if factor.shape[0] > factor.shape[1]:
        variance, axes = np.linalg.eigh(factor.T @ factor)
        axes *= np.sqrt(np.maximum(variance, 0.0))
    else:
        variance, turned = np.linalg.eigh(factor @ factor.T)
        axes = factor.T @ turned
    return axes[:, variance > 1e-9 * variance[-1]]


def residual_rms(model: ShadingModel, data: ShadingData) -> Measured:
    """Return the root mean square of the relative residuals of the bins, noise included [1]."""
    fitted = model.surface(data.rows[:, None], data.columns[None, :])
    used = data.used & (fitted > 0.0)
    residual = data.signal_dn[used] / fitted[used] - 1.0
    rms = float(np.sqrt(np.mean(residual**2)))
    return Measured.normal(rms, rms / float(np.sqrt(2.0 * max(residual.size, 1))), ONE)


def optical_axis(model: ShadingModel) -> OpticalAxis | None:
    """Return centre and focal length of ``cos4``, or the centre of ``radial``.

    Returns
    -------
    OpticalAxis or None
        None for models without a centre of their own, where the bins do not tell the plane from an even one, and where
        the curvature is below two of its errors: nothing shades then, and centre and focal length mean nothing.

    """
    surface = model.equation
    if not model.shades:
        return None
    if isinstance(surface, RadialSurface):
        error = np.sqrt(np.diag(model.covariance))
        row, column = (Measured.normal(float(model.values[at]), float(error[at]), PIXEL) for at in (-2, -1))
        return OpticalAxis(row=row, column=column, focal_length=None)
    if not isinstance(surface, CosineSurface) or surface.axis(model.values) is None:
        return None
    if model.values[-1] < _SHADES * np.sqrt(model.covariance[-1, -1]):
        return None
    return _cosine_axis(surface, model)


def _cosine_axis(surface: CosineSurface, model: ShadingModel) -> OpticalAxis:
    """Return the axis of the cosine-fourth law, its errors by central differences of a tenth of an error."""
    found = np.array(surface.axis(model.values))
    error = np.sqrt(np.diag(model.covariance))
    slopes = np.zeros((3, model.values.size))
    for at in range(1, model.values.size):
        move = np.zeros(model.values.size)
        move[at] = 0.1 * error[at]
        ends = [surface.axis(model.values + sign * move) for sign in (1.0, -1.0)]
        if ends[0] is not None and ends[1] is not None:
            slopes[:, at] = np.subtract(ends[0], ends[1]) / (2.0 * move[at])
    errors = np.sqrt(np.diag(slopes @ model.covariance @ slopes.T))
    row, column, focal = (Measured.normal(float(v), float(e), PIXEL) for v, e in zip(found, errors, strict=True))
    return OpticalAxis(row=row, column=column, focal_length=focal)
