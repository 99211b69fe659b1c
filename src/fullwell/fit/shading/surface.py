"""A fitted shading surface: its parameters, what it is worth anywhere in the plane, and how well it is known."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

FloatArray = NDArray[np.float64]


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
        Errors are scaled by this, 1 or more: the spline fits so much better that the model's own errors do not cover
        what it misses.
    misfit
        Whether they are.
    centre
        Row and column of the maximum of the surface inside the plane [pixel of the plane].
    maximum_dn
        Value there [DN].
    focal_length_pixels
        The focal length that ``cos4-fixed`` was given [pixel of the plane]; None for the others.

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

    def surface(self, row: ArrayLike, column: ArrayLike) -> FloatArray:
        """Return the surface at positions in the plane [DN].

        Parameters
        ----------
        row, column
            Positions [pixel of the plane, from 0 at the centre of the first]; broadcast against each other, so
            ``surface(rows[:, None], columns[None, :])`` is a grid, and fast.

        """
        raise NotImplementedError

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
        raise NotImplementedError

    def map(self, *, step: int = 1) -> FloatArray:
        """Return the surface over the whole plane, 1 at its centre.

        Parameters
        ----------
        step
            Every how many pixels, from the first pixel of the plane.

        Returns
        -------
        ndarray
            Shape (ceil(rows / step), ceil(columns / step)) [1].

        """
        raise NotImplementedError

    def to_arrays(self) -> dict[str, NDArray[Any]]:
        """Return all there is as plain arrays, for ``numpy.savez``; `from_arrays` takes them back."""
        raise NotImplementedError

    @classmethod
    def from_arrays(cls, arrays: Mapping[str, NDArray[Any]]) -> Self:
        """Return the model that `to_arrays` wrote out."""
        raise NotImplementedError
