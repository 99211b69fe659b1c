"""Surfaces with a few parameters that are not linear, by variable projection (METHOD 6.2).

The linear ones are solved for at each place of the others; what moves the others is a Gauss-Newton step of both
together with analytic derivatives (Kaufman), damped where it would not lower chi-square (Levenberg and Marquardt).
"""

from dataclasses import dataclass
from typing import Final, Protocol

import numpy as np

from fullwell.fit.shading.solution import Solution, at_minimum
from fullwell.fit.shading.weighting import FloatArray, WeightedBins, symmetric_inverse
from fullwell.model.shading import RADIAL_POWERS, CosineSurface, RadialSurface

_STEPS: Final = 60
_NEGLIGIBLE: Final = 1e-4
"""A step that lowers chi-square by less moves nothing by more than a hundredth of its error."""
_SMALLEST_QUADRATIC: Final = 0.05


class Separable(Protocol):
    """A surface whose first parameters are linear."""

    @property
    def linear(self) -> int:
        """How many are."""
        ...

    def functions(self, row: FloatArray, column: FloatArray, parameters: FloatArray) -> FloatArray:
        """Return what the linear parameters multiply at n places, a row each."""
        ...

    def jacobian(self, row: FloatArray, column: FloatArray, parameters: FloatArray) -> FloatArray:
        """Return the derivatives by all parameters; the first rows are `functions`."""
        ...

    def allowed(self, parameters: FloatArray) -> bool:
        """Whether the surface means something there."""
        ...


@dataclass(frozen=True, slots=True, kw_only=True)
class SeparableCosine(CosineSurface):
    """The cosine-fourth law: the amplitude is linear."""

    @property
    def linear(self) -> int:
        """One."""
        return 1

    def allowed(self, parameters: FloatArray) -> bool:
        """Whether the quadratic stays clear of zero over the plane, so that the surface stays finite."""
        y = np.linspace(0.0, self.plane.rows - 1.0, 9)[:, None]
        x = np.linspace(0.0, self.plane.columns - 1.0, 9)[None, :]
        return bool(np.min(self.quadratic(y, x, parameters[1:])) > _SMALLEST_QUADRATIC)


@dataclass(frozen=True, slots=True, kw_only=True)
class SeparableRadial(RadialSurface):
    """The radial surface: all but tilt and centre are linear."""

    @property
    def linear(self) -> int:
        """As many as even powers of the radius, the zeroth included."""
        return self.powers + 1

    def allowed(self, parameters: FloatArray) -> bool:
        """Whether the centre lies no further outside the plane than the plane is large."""
        row, column = float(parameters[-2]), float(parameters[-1])
        rows, columns = self.plane.rows, self.plane.columns
        return -rows <= row <= 2 * rows and -columns <= column <= 2 * columns


def fit_cosine(bins: WeightedBins) -> Solution:
    """Return the cosine-fourth law with free centre and focal length.

    Raises
    ------
    ValueError
        Where there are not more bins than terms, or no minimum is found.

    """
    surface = SeparableCosine(plane=bins.plane)
    return at_minimum(surface, project(surface, bins, np.zeros(3)), bins)


def fit_radial(bins: WeightedBins, *, powers: int = RADIAL_POWERS) -> Solution:
    """Return even powers of the radius times a tilted plane, about a free centre.

    Parameters
    ----------
    bins
        Of the plane.
    powers
        Even powers above the zeroth.

    Raises
    ------
    ValueError
        Where there are not more bins than terms, or no minimum is found.

    """
    surface = SeparableRadial(plane=bins.plane, powers=powers)
    start = np.array([0.0, 0.0, *_likely_centre(bins)])
    return at_minimum(surface, project(surface, bins, start), bins)


def _likely_centre(bins: WeightedBins) -> tuple[float, float]:
    """Return the centre of a cosine-fourth law over every third bin, no further out than half the plane [pixel]."""
    rows, columns = bins.plane.rows, bins.plane.columns
    law = SeparableCosine(plane=bins.plane)
    try:
        axis = law.axis(_Descent.over(bins, law, every=3).minimum(np.zeros(3)))
    except ValueError:
        axis = None
    row, column = bins.plane.middle if axis is None else axis[:2]
    return min(max(row, -0.5 * rows), 1.5 * rows), min(max(column, -0.5 * columns), 1.5 * columns)


def project(surface: Separable, bins: WeightedBins, start: FloatArray) -> FloatArray:
    """Return the parameters of least chi-square.

    Parameters
    ----------
    surface
        With linear parameters first.
    bins
        Of the plane; every third row and column leads the way, where there are many.
    start
        The parameters that are not linear.

    Raises
    ------
    ValueError
        Where there are not more bins than terms, or no minimum is found.

    """
    if bins.signal_dn.shape[0] >= 90 and bins.signal_dn.shape[1] >= 90:
        thin = _Descent.over(bins, surface, every=3)
        if thin.signal.size > 4 * (surface.linear + start.size):
            start = thin.minimum(start)[surface.linear :]
    return _Descent.over(bins, surface, every=1).minimum(start)


@dataclass(frozen=True, slots=True, kw_only=True)
class _Descent:
    """The bins in use, one after the other, and the surface that goes down to them."""

    surface: Separable
    row: FloatArray
    column: FloatArray
    signal: FloatArray
    weight: FloatArray

    @classmethod
    def over(cls, bins: WeightedBins, surface: Separable, *, every: int) -> "_Descent":
        grid = (slice(None, None, every), slice(None, None, every))
        weight = bins.fitting_weight[grid]
        used = weight > 0.0
        row, column = np.broadcast_arrays(bins.rows[::every, None], bins.columns[None, ::every])
        return cls(
            surface=surface,
            row=row[used],
            column=column[used],
            signal=bins.signal_dn[grid][used],
            weight=weight[used],
        )

    def solved(self, parameters: FloatArray) -> tuple[FloatArray, float]:
        """Return the parameters with the linear ones solved for, and chi-square."""
        linear = self.surface.linear
        functions = self.surface.functions(self.row, self.column, parameters)
        weighted = functions * self.weight
        found = symmetric_inverse(weighted @ functions.T, whole=False) @ (weighted @ self.signal)
        residual = self.signal - found @ functions
        return np.concatenate([found, parameters[linear:]]), float(np.sum(self.weight * residual**2))

    def minimum(self, start: FloatArray) -> FloatArray:
        """Return the parameters of least chi-square from a start of those that are not linear."""
        linear = self.surface.linear
        if self.signal.size <= linear + start.size:
            raise ValueError(f"{linear + start.size} terms need more than the {self.signal.size} bins there are")
        now, chi_square = self.solved(np.concatenate([np.ones(linear), start]))
        damping = 0.0
        for _ in range(_STEPS):
            step = self._step(now, damping)
            trial, trial_chi_square = now + step, np.inf
            if self.surface.allowed(trial):
                trial, trial_chi_square = self.solved(trial)
            gained = chi_square - trial_chi_square
            if gained >= 0.0:
                now, chi_square, damping = trial, trial_chi_square, damping * 0.1 if damping > 1e-6 else 0.0
            else:
                damping = max(10.0 * damping, 1e-3)
            if abs(gained) < _NEGLIGIBLE or damping > 1e9:
                return now
        raise ValueError("the fit does not settle: the shading is too weak to show a centre")

    def _step(self, now: FloatArray, damping: float) -> FloatArray:
        """Return the damped Gauss-Newton step of all parameters."""
        slopes = self.surface.jacobian(self.row, self.column, now)
        weighted = slopes * self.weight
        residual = self.signal - now[: self.surface.linear] @ slopes[: self.surface.linear]
        information = weighted @ slopes.T
        diagonal = np.diag(information).copy()
        floor = 1e-30 * float(diagonal.max())
        raised = information + np.diag(damping * diagonal + floor)
        return symmetric_inverse(raised, whole=False) @ (weighted @ residual)
