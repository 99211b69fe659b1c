"""The cosine-fourth law with free centre and focal length by weighted least squares (METHOD 6.2)."""

from dataclasses import dataclass, replace
from typing import Final, Self

import numpy as np

from fullwell.fit.shading.projection import Normal, project
from fullwell.fit.shading.solution import Solution, from_normal
from fullwell.fit.shading.weighting import FloatArray, WeightedBins
from fullwell.kernels.cosine_sums import cosine_sums
from fullwell.model.shading import CosineSurface

_SMALLEST_QUADRATIC: Final = 0.05
_UPPER: Final = np.triu_indices(4)


def fit_cosine(bins: WeightedBins) -> Solution:
    """Return the cosine-fourth law with free centre and focal length.

    Raises
    ------
    ValueError
        Where there are not more bins than terms, or no minimum is found.

    """
    law = _Law.over(bins)
    found = project(law, np.zeros(3), bins=bins.bins)
    total, temporal = (law.information(found.parameters, weight) for weight in bins.scatter_weights())
    return from_normal(found, total=None if bins.robust_weight is None else total, temporal=temporal)


def likely_centre(bins: WeightedBins, cosine: FloatArray | None = None) -> tuple[float, float]:
    """Return the centre of the cosine-fourth law, no further out than half the plane, or the plane's middle [pixel].

    Parameters
    ----------
    bins
        Of the plane.
    cosine
        Parameters of the law that `fit_cosine` found; None: it is fitted here.

    """
    rows, columns = bins.plane.rows, bins.plane.columns
    try:
        axis = CosineSurface(plane=bins.plane).axis(fit_cosine(bins).values if cosine is None else cosine)
    except ValueError:
        axis = None
    row, column = bins.plane.middle if axis is None else axis[:2]
    return min(max(row, -0.5 * rows), 1.5 * rows), min(max(column, -0.5 * columns), 1.5 * columns)


@dataclass(frozen=True, slots=True, kw_only=True)
class _Law:
    """The law over bins, whose places count in half diagonals from the middle of the plane; its amplitude is linear."""

    surface: CosineSurface
    y: FloatArray
    x: FloatArray
    signal: FloatArray
    weight: FloatArray

    @classmethod
    def over(cls, bins: WeightedBins) -> Self:
        y, x = bins.plane.centred(bins.rows, bins.columns)
        return cls(surface=CosineSurface(plane=bins.plane), y=y, x=x, signal=bins.signal_dn, weight=bins.fitting_weight)

    @property
    def linear(self) -> int:
        """One."""
        return 1

    def allowed(self, parameters: FloatArray) -> bool:
        """Whether the quadratic stays clear of zero over the plane, so that the surface stays finite."""
        plane = self.surface.plane
        y = np.linspace(0.0, plane.rows - 1.0, 9)[:, None]
        x = np.linspace(0.0, plane.columns - 1.0, 9)[None, :]
        return bool(np.min(self.surface.quadratic(y, x, parameters[1:])) > _SMALLEST_QUADRATIC)

    def normal(self, parameters: FloatArray) -> Normal:
        """Return the normal equations with the best amplitude: it moves the residuals in the direction of its own."""
        found = self._sums(parameters, self.weight)
        more = found.gradient[0] / found.information[0, 0]
        moved = replace(
            found,
            parameters=np.append(parameters[0] + more, parameters[1:]),
            gradient=found.gradient - more * found.information[0],
            chi_square=found.chi_square - more * float(found.gradient[0]),
        )
        scale = _scale(moved.parameters)
        return replace(moved, information=np.outer(scale, scale) * moved.information, gradient=scale * moved.gradient)

    def information(self, parameters: FloatArray, weight: FloatArray) -> FloatArray:
        """Return J W J' of the derivatives by all parameters for other weights of the bins."""
        scale = _scale(parameters)
        return np.outer(scale, scale) * self._sums(parameters, weight).information

    def _sums(self, parameters: FloatArray, weight: FloatArray) -> Normal:
        amplitude, a, b, u = (float(one) for one in parameters)
        sums = cosine_sums(self.y, self.x, self.signal, weight, (amplitude, a, b, u))
        information = np.empty((4, 4))
        information[_UPPER] = information.T[_UPPER] = sums[5:]
        return Normal(parameters=parameters, information=information, gradient=sums[1:5], chi_square=float(sums[0]))


def _scale(parameters: FloatArray) -> FloatArray:
    """Return what the functions of the sums become derivatives by: 1 and -2 A."""
    slope = -2.0 * parameters[0]
    return np.array([1.0, slope, slope, slope])
