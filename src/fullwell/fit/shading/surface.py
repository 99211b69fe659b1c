"""A fitted shading surface: its parameters, what it is worth anywhere in the plane, and how well it is known."""

from collections.abc import Mapping
from dataclasses import dataclass, fields
from typing import Any, Final, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fullwell.fit.goodness import MISFIT_SIZE
from fullwell.model.shading import (
    CosineSurface,
    FixedCosineSurface,
    Plane,
    RadialSurface,
    Surface,
    polynomial_surface,
    spline_surface,
)

FloatArray = NDArray[np.float64]

DEGREES: Final = {"poly22": 2, "poly44": 4, "poly66": 6, "poly88": 8}
"""Total degrees of the polynomial models."""
_CLOSE: Final = 1e-3
"""Distance to which a maximum is searched [pixel]: there the surface differs by nothing that counts."""

_COARSE: Final = np.linspace(-1.0, 1.0, 49)
_FINE: Final = np.linspace(-1.0, 1.0, 25)
"""Places along each side of the first grid that is searched, and of those that close in."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ShadingModel:
    """One surface fitted to one plane (METHOD 6.2).

    Parameters
    ----------
    name
        ``p-spline``, ``radial``, ``cos4``, ``cos4-fixed``, ``poly22``, ``poly44``, ``poly66`` or ``poly88``.
    plane_shape
        Rows and columns of the plane [pixel].
    parameter_names
        What each parameter is.
    values
        Fitted parameters, shape (P,); amplitudes in DN.
    covariance
        Of the parameters, shape (P, P): temporal noise and PRNU, as for any sensor of this kind; scaled by
        ``error_scale`` squared.
    temporal_covariance
        By temporal noise alone: what a repeat with the same sensor would scatter by. Scaled alike.
    effective_terms
        Parameters, or for the penalized spline the trace of its smoother.
    chi_square
        Weighted sum of squared residuals; robust weights counted.
    dof
        Bins less effective terms.
    gcv
        Generalized cross-validation, chi_square/n / (1 - terms/n)^2; about 1 for a model that fits.
    gcv_error
        Its standard error sqrt(2/n), relative to this model's own value.
    error_scale
        What the errors are scaled by, 1 or more: bins scatter by more than their noise, or the richest model of the
        same fit explains so much more that this one's own errors would not cover what it misses.
    misfit
        Whether they are scaled by more than a tenth.
    centre
        Row and column of the maximum of the surface inside the plane [pixel of the plane].
    maximum_dn
        Value there [DN].
    focal_length_pixels
        The focal length that ``cos4-fixed`` was given [pixel of the plane]; None for the others.
    spline_terms
        Splines along rows and along columns of ``p-spline``; None for the others.
    even_p
        Chance that an evenly lit plane would seem to shade as much, by the models of the same fit together; 0 where
        it was not asked.

    """

    name: str
    plane_shape: tuple[int, int]
    parameter_names: tuple[str, ...]
    values: FloatArray
    covariance: FloatArray
    temporal_covariance: FloatArray
    effective_terms: float
    chi_square: float
    dof: float
    gcv: float
    gcv_error: float
    error_scale: float
    misfit: bool
    centre: tuple[float, float]
    maximum_dn: float
    focal_length_pixels: float | None = None
    spline_terms: tuple[int, int] | None = None
    even_p: float = 0.0

    @property
    def shades(self) -> bool:
        """Whether the bins tell the plane from an evenly lit one (size 1 %)."""
        return self.even_p < MISFIT_SIZE

    @property
    def equation(self) -> Surface:
        """The surface with its parameters still open."""
        plane = Plane(rows=self.plane_shape[0], columns=self.plane_shape[1])
        return equation(self.name, plane, focal_length_pixels=self.focal_length_pixels, spline_terms=self.spline_terms)

    def surface(self, row: ArrayLike, column: ArrayLike) -> FloatArray:
        """Return the surface at positions in the plane [DN].

        Parameters
        ----------
        row, column
            Positions [pixel of the plane, from 0 at the centre of the first]; broadcast against each other, so
            ``surface(rows[:, None], columns[None, :])`` is a grid, and fast.

        """
        return self.equation.value(row, column, self.values)

    def surface_and_covariance(
        self, row: ArrayLike, column: ArrayLike, *, temporal: bool = False
    ) -> tuple[FloatArray, FloatArray]:
        """Return the surface at n positions and the covariance between them.

        Parameters
        ----------
        row, column
            Positions, shape (n,) [pixel of the plane].
        temporal
            Temporal noise alone.

        Returns
        -------
        tuple of ndarray
            Values, shape (n,) [DN], and covariance, shape (n, n) [DN^2].

        """
        row, column = np.broadcast_arrays(np.asarray(row, np.float64), np.asarray(column, np.float64))
        equation = self.equation
        slopes = equation.jacobian(row, column, self.values)
        covariance = self.temporal_covariance if temporal else self.covariance
        return equation.value(row, column, self.values), slopes.T @ covariance @ slopes

    def to_arrays(self) -> dict[str, NDArray[Any]]:
        """Return all there is as plain arrays, for ``numpy.savez``; `from_arrays` takes them back."""
        known = {field.name: getattr(self, field.name) for field in fields(self)}
        return {name: np.asarray(value) for name, value in known.items() if value is not None}

    @classmethod
    def from_arrays(cls, arrays: Mapping[str, NDArray[Any]]) -> Self:
        """Return the model that `to_arrays` wrote out; arrays of other names are passed over."""
        kept = ("values", "covariance", "temporal_covariance")
        found: dict[str, Any] = {}
        for name in (field.name for field in fields(cls) if field.name in arrays):
            plain = arrays[name].tolist()
            found[name] = (
                np.asarray(arrays[name], np.float64)
                if name in kept
                else (tuple(plain) if isinstance(plain, list) else plain)
            )
        return cls(**found)


def equation(
    name: str, plane: Plane, *, focal_length_pixels: float | None, spline_terms: tuple[int, int] | None
) -> Surface:
    """Return the surface of a model's name.

    Parameters
    ----------
    name
        As of `ShadingModel`.
    plane
        Size of the plane.
    focal_length_pixels
        For ``cos4-fixed`` [pixel of the plane].
    spline_terms
        For ``p-spline``.

    Raises
    ------
    ValueError
        Where the name is unknown, or what it needs is not given.

    """
    if name in DEGREES:
        return polynomial_surface(plane, DEGREES[name])
    if name == "p-spline" and spline_terms is not None:
        return spline_surface(plane, spline_terms)
    if name == "cos4-fixed" and focal_length_pixels is not None:
        return FixedCosineSurface(plane=plane, focal_length_pixels=focal_length_pixels)
    if name == "cos4":
        return CosineSurface(plane=plane)
    if name == "radial":
        return RadialSurface(plane=plane)
    raise ValueError(f"there is no shading model {name!r} with what is known")


def maximum(surface: Surface, values: FloatArray, plane: Plane) -> tuple[float, float, float]:
    """Return row and column of the maximum of a surface inside the plane, and the value there.

    A grid finds it, finer ones around it close in.
    """
    ends = np.array([[plane.rows - 1.0], [plane.columns - 1.0]])
    centre, reach = np.array(plane.middle), np.array([plane.rows / 2.0, plane.columns / 2.0])
    steps, value = _COARSE, 0.0
    while reach.max() > _CLOSE:
        row, column = np.clip(centre[:, None] + reach[:, None] * steps, 0.0, ends)
        grid = surface.value(row[:, None], column[None, :], values)
        best_row, best_column = divmod(int(np.argmax(grid)), column.size)
        centre = np.array([row[best_row], column[best_column]])
        value = float(grid[best_row, best_column])
        reach *= 4.0 / (steps.size - 1)
        steps = _FINE
    return float(centre[0]), float(centre[1]), value
