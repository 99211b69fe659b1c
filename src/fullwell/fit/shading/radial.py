"""Even powers of the radius times a tilted plane, about a free centre, by weighted least squares (METHOD 6.2).

For all its parameters the surface and its derivatives are polynomials of row and column, of a degree known beforehand.
So the bins are condensed first: to the few sums that polynomials of that degree see of them (`_Condensed`).
"""

from dataclasses import dataclass
from functools import cache
from typing import Self

import numpy as np

from fullwell.fit.shading.cosine import likely_centre
from fullwell.fit.shading.polynomial import polynomial_gram
from fullwell.fit.shading.projection import Normal, project
from fullwell.fit.shading.solution import Solution, from_normal
from fullwell.fit.shading.weighting import UNDETERMINED, FloatArray, TensorGrid, WeightedBins, symmetric_inverse
from fullwell.model.shading import RADIAL_POWERS, Plane, RadialSurface, polynomial_surface


def fit_radial(bins: WeightedBins, *, cosine: FloatArray | None = None, powers: int = RADIAL_POWERS) -> Solution:
    """Return even powers of the radius times a tilted plane, about a free centre.

    Parameters
    ----------
    bins
        Of the plane.
    cosine
        Parameters of the cosine-fourth law over the same bins, whose centre is the first guess, where it was fitted.
    powers
        Even powers above the zeroth.

    Raises
    ------
    ValueError
        Where there are not more bins than terms, or no minimum is found.

    """
    law = _Condensed.of(bins, powers)
    found = project(law, np.array([0.0, 0.0, *likely_centre(bins, cosine)]), bins=bins.bins)
    total, temporal = (law.information(found.parameters, bins, weight) for weight in bins.scatter_weights())
    return from_normal(found, total=None if bins.robust_weight is None else total, temporal=temporal)


@dataclass(frozen=True, slots=True, kw_only=True)
class _Condensed:
    """The surface over what polynomials see of the bins; all but tilt and centre are linear.

    Let G be the sums over the bins of weighted products of all P polynomials, m those of their products with the
    signal, and c the coefficients of a surface: chi-square is (m - G c)' G^-1 (m - G c) and a constant.

    Parameters
    ----------
    surface
        Powers, tilt and centre.
    row, column
        n places at which the surface is asked for [pixel].
    coefficients
        Takes its values there to c, shape (n, P).
    seen
        Takes them to G^1/2 c, shape (n, K); directions that no bin determines are left out.
    target
        G^-1/2 m, shape (K,).

    """

    surface: RadialSurface
    row: FloatArray
    column: FloatArray
    coefficients: FloatArray
    seen: FloatArray
    target: FloatArray

    @classmethod
    def of(cls, bins: WeightedBins, powers: int) -> Self:
        if 1 in bins.signal_dn.shape:
            raise ValueError(UNDETERMINED)
        degree = 2 * powers + 1
        row, column, coefficients = _places(bins.plane, degree)
        values, vectors = np.linalg.eigh(polynomial_gram(bins, bins.fitting_weight, degree))
        known = values > 1e-13 * values[-1]
        root, vectors = np.sqrt(values[known]), vectors[:, known]
        grid = TensorGrid.of(polynomial_surface(bins.plane, degree), bins.rows, bins.columns)
        moments = grid.moments(bins.fitting_weight * bins.signal_dn)
        return cls(
            surface=RadialSurface(plane=bins.plane, powers=powers),
            row=row,
            column=column,
            coefficients=coefficients,
            seen=coefficients @ (vectors * root),
            target=(moments @ vectors) / root,
        )

    @property
    def linear(self) -> int:
        """As many as even powers of the radius, the zeroth included."""
        return self.surface.powers + 1

    def allowed(self, parameters: FloatArray) -> bool:
        """Whether the centre lies no further outside the plane than the plane is large."""
        row, column = float(parameters[-2]), float(parameters[-1])
        rows, columns = self.surface.plane.rows, self.surface.plane.columns
        return -rows <= row <= 2 * rows and -columns <= column <= 2 * columns

    def normal(self, parameters: FloatArray) -> Normal:
        """Return the normal equations, the linear parameters solved for."""
        functions = self.surface.functions(self.row, self.column, parameters) @ self.seen
        linear = symmetric_inverse(functions @ functions.T, whole=False) @ (functions @ self.target)
        found = np.concatenate([linear, parameters[self.linear :]])
        slopes = self.surface.jacobian(self.row, self.column, found) @ self.seen
        residual = self.target - linear @ functions
        return Normal(
            parameters=found,
            information=slopes @ slopes.T,
            gradient=slopes @ residual,
            chi_square=float(residual @ residual),
        )

    def information(self, parameters: FloatArray, bins: WeightedBins, weight: FloatArray) -> FloatArray:
        """Return J W J' of the derivatives by all parameters for other weights of the bins."""
        slopes = self.surface.jacobian(self.row, self.column, parameters) @ self.coefficients
        return slopes @ polynomial_gram(bins, weight, 2 * self.surface.powers + 1) @ slopes.T


@cache
def _places(plane: Plane, degree: int) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return places in a plane, and what takes a polynomial's values there to its coefficients (Gauss' quadrature)."""
    nodes, shares = np.polynomial.legendre.leggauss(degree + 1)
    along = np.polynomial.legendre.legvander(nodes, degree) * shares[:, None] * (np.arange(degree + 1) + 0.5)
    kept = polynomial_surface(plane, degree).kept
    row, column = ((nodes + 1.0) * (size / 2.0) - 0.5 for size in (plane.rows, plane.columns))
    coefficients = np.einsum("pi,qj->pqij", along, along)[:, :, kept].reshape(nodes.size**2, -1)
    return np.repeat(row, nodes.size), np.tile(column, nodes.size), coefficients
