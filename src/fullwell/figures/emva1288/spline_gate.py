"""The gate of Release 4.0 Linear: the photon transfer is so straight that one system gain describes it, (51)."""

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from fullwell.figures.emva1288.line import Line
from fullwell.figures.emva1288.sweep import Floats, Sweep

LIMIT: Final = 0.03
"""Mean relative deviation from which the camera is to be evaluated by Release 4.0 General."""

_INTERVALS: Final = ((50, 8), (30, 7), (12, 6))
"""Intervals of the spline by the number of steps that are there at least."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class SplineGate:
    """How far the slope of a spline through the photon transfer strays from the system gain.

    Parameters
    ----------
    deviation
        Mean relative deviation over the steps up to 70 % of saturation.
    floor
        What noise alone would make of it.
    error
        Standard error of ``deviation``.
    intervals
        Of the spline.

    """

    deviation: float
    floor: float
    error: float
    intervals: int


def basis(x: Floats) -> Floats:
    """Return the cubic B-spline of unit knots.

    Examples
    --------
    >>> basis(np.array([0, 0.5, 1, 1.5, 2])).round(9)
    array([0.66666667, 0.47916667, 0.16666667, 0.02083333, 0.        ])

    """
    distance = np.abs(x)
    inner = 2.0 / 3.0 - distance**2 + distance**3 / 2.0
    outer = (2.0 - distance) ** 3 / 6.0
    return np.where(distance < 1.0, inner, np.where(distance < 2.0, outer, 0.0))


def basis_slope(x: Floats) -> Floats:
    """Return the derivative of the cubic B-spline of unit knots.

    Examples
    --------
    >>> basis_slope(np.array([0, 0.5, 1, 1.5, 2])).round(9) + 0.0
    array([ 0.   , -0.625, -0.5  , -0.125,  0.   ])

    """
    distance, side = np.abs(x), np.sign(x)
    inner = -2.0 * x * (1.0 - 0.75 * distance)
    outer = -0.5 * side * (2.0 - distance) ** 2
    return np.where(distance < 1.0, inner, np.where(distance < 2.0, outer, 0.0))


def spline_gate(sweep: Sweep, chosen: NDArray[np.bool_], *, line: Line, saturation_signal: float) -> SplineGate | None:
    """Fit a spline to the photon transfer up to saturation and compare its slopes with the system gain.

    Parameters
    ----------
    sweep
        The steps.
    chosen
        Those up to 70 % of saturation.
    line
        The photon-transfer line.
    saturation_signal
        Where the spline ends [DN].

    Returns
    -------
    SplineGate or None
        None where there are too few steps for a spline.

    """
    below = (sweep.signal >= 0.0) & (sweep.signal <= saturation_signal)
    intervals = next((most for least, most in _INTERVALS if below.sum() >= least), None)
    compared = chosen & below
    if intervals is None or not compared.any():
        return None
    knots = saturation_signal / intervals
    centres = np.arange(intervals + 3) - 1.0
    places = sweep.signal[:, np.newaxis] / knots - centres
    solver = np.linalg.pinv(basis(places[below]))
    slopes = basis_slope(places[compared]) / knots @ solver
    found = slopes @ sweep.light_variance[below]
    errors = slopes * sweep.light_variance_error[below]
    # The line's slope rests on the same points, so its error is part of the difference.
    x = sweep.signal[chosen]
    own = np.zeros(sweep.steps)
    own[chosen] = (x - x.mean()) / np.sum((x - x.mean()) ** 2)
    difference = errors - own[below] * sweep.light_variance_error[below]
    spread = np.sqrt(np.sum(difference**2, axis=1)) / line.slope
    deviation = np.abs(found - line.slope) / line.slope
    signs = np.sign(found - line.slope)
    error = float(np.sqrt(np.sum(np.mean(signs[:, np.newaxis] * difference, axis=0) ** 2))) / line.slope
    return SplineGate(
        deviation=float(deviation.mean()),
        floor=float(np.sqrt(2.0 / np.pi) * spread.mean()),
        error=error,
        intervals=intervals,
    )
