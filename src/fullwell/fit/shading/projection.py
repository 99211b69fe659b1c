"""Surfaces with a few parameters that are not linear, by variable projection (METHOD 6.2).

The linear ones are solved for at each place of the others; what moves the others is a Gauss-Newton step of both
together with analytic derivatives (Kaufman), damped where it would not lower chi-square (Levenberg and Marquardt).
"""

from dataclasses import dataclass
from typing import Final, Protocol

import numpy as np

from fullwell.fit.shading.weighting import FloatArray, symmetric_inverse

_STEPS: Final = 60
_NEGLIGIBLE: Final = 1e-4
"""A step that lowers chi-square by less moves nothing by more than a hundredth of its error."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Normal:
    """Normal equations about a place, the linear parameters solved for.

    Parameters
    ----------
    parameters
        The place, shape (P,).
    information
        J W J', shape (P, P), of the derivatives J by all parameters.
    gradient
        J W r of the residuals r, shape (P,).
    chi_square
        r' W r, but for a constant.

    """

    parameters: FloatArray
    information: FloatArray
    gradient: FloatArray
    chi_square: float

    def step(self, damping: float) -> FloatArray:
        """Return the damped Gauss-Newton step of all parameters."""
        diagonal = np.diag(self.information).copy()
        floor = 1e-30 * float(diagonal.max())
        raised = self.information + np.diag(damping * diagonal + floor)
        return symmetric_inverse(raised, whole=False) @ self.gradient


class Separable(Protocol):
    """A surface over bins whose first parameters are linear."""

    @property
    def linear(self) -> int:
        """How many are."""
        ...

    def normal(self, parameters: FloatArray) -> Normal:
        """Return the normal equations where the parameters that are not linear have these values."""
        ...

    def allowed(self, parameters: FloatArray) -> bool:
        """Whether the surface means something there."""
        ...


def project(surface: Separable, start: FloatArray, *, bins: int) -> Normal:
    """Return the normal equations at the parameters of least chi-square.

    Parameters
    ----------
    surface
        With linear parameters first.
    start
        The parameters that are not linear.
    bins
        How many are used.

    Raises
    ------
    ValueError
        Where there are not more bins than terms, or no minimum is found.

    """
    terms = surface.linear + start.size
    if bins <= terms:
        raise ValueError(f"{terms} terms need more than the {bins} bins there are")
    now, damping = surface.normal(np.concatenate([np.ones(surface.linear), start])), 0.0
    for _ in range(_STEPS):
        place = now.parameters + now.step(damping)
        trial = surface.normal(place) if surface.allowed(place) else None
        gained = -np.inf if trial is None else now.chi_square - trial.chi_square
        if trial is not None and gained >= 0.0:
            now, damping = trial, damping * 0.1 if damping > 1e-6 else 0.0
        else:
            damping = max(10.0 * damping, 1e-3)
        if abs(gained) < _NEGLIGIBLE or damping > 1e9:
            return now
    raise ValueError("the fit does not settle: the shading is too weak to show a centre")
