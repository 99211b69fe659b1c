"""Bins far from the surface, such as dust, get little weight (METHOD 6.4)."""

from collections.abc import Callable
from dataclasses import replace
from typing import Final

import numpy as np

from fullwell.fit.shading.polynomial import fit_polynomial
from fullwell.fit.shading.solution import Solution
from fullwell.fit.shading.spline import fit_spline, spline_terms
from fullwell.fit.shading.surface import DEGREES
from fullwell.fit.shading.weighting import FloatArray, TensorGrid, WeightedBins
from fullwell.model.shading import TensorSurface, polynomial_surface, spline_surface

Fit = Callable[[WeightedBins, TensorSurface], Solution]

REACH: Final = 4.685
"""Standard deviations beyond which a bin has no weight: 95 % efficient for normal noise."""
MEAN_WEIGHT: Final = 0.9151076240
"""Mean of the weight over normal residuals."""
MEAN_WEIGHTED_SQUARE: Final = 0.7577759186
"""Mean over normal residuals of weight times squared residual."""
_ROUNDS: Final = 12
_SETTLED: Final = 1e-3


def biweight(residual: FloatArray) -> FloatArray:
    """Return Tukey's weight of residuals in standard deviations: (1 - (r/4.685)^2)^2, 0 beyond."""
    return np.square(np.maximum(1.0 - np.square(residual / REACH), 0.0))


def robust_bins(bins: WeightedBins) -> WeightedBins:
    """Return the bins with robust weights from a polynomial first, then from the spline surface, until they settle.

    The scale of the residuals is that of their median, at least the known noise.

    Raises
    ------
    ValueError
        Where there are too few bins for either.

    """
    weight = np.ones_like(bins.weight)
    for surface, fit, rounds in _stages(bins):
        for _ in range(rounds):
            before = weight
            weight = _weights(replace(bins, robust_weight=weight), surface, fit)
            if float(np.max(np.abs(weight - before))) < _SETTLED:
                break
    return replace(bins, robust_weight=weight)


def _stages(bins: WeightedBins) -> list[tuple[TensorSurface, Fit, int]]:
    """Return what to fit, how, and how often: the stiff polynomial first, it cannot follow a spot."""
    degrees = sorted(DEGREES.values(), reverse=True)
    degree = next((one for one in degrees if (one + 1) * (one + 2) < bins.bins), degrees[-1])
    found: list[tuple[TensorSurface, Fit, int]] = [(polynomial_surface(bins.plane, degree), fit_polynomial, 4)]
    try:
        return [*found, (spline_surface(bins.plane, spline_terms(bins)), fit_spline, _ROUNDS)]
    except ValueError:
        return found


def _weights(bins: WeightedBins, surface: TensorSurface, fit: Fit) -> FloatArray:
    """Return the weights that the residuals of one fit give."""
    fitted = TensorGrid.of(surface, bins.rows, bins.columns).surface(fit(bins, surface).values)
    residual = (bins.signal_dn - fitted) * np.sqrt(bins.weight)
    scale = max(1.0, 1.4826 * float(np.median(np.abs(residual[bins.weight > 0.0]))))
    return biweight(residual / scale)
