"""Stray light, from the densities of a chart and an offset that other evidence identifies (METHOD 2.2, 2.3).

Flare and offset add to every patch alike: one exposure of one chart tells their sum, never both.
"""

import math
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fullwell.fit.goodness import is_misfit
from fullwell.fit.solvers import root_between
from fullwell.units import DN, ONE, Measured

_FEWEST: Final = 3
_ITERATIONS: Final = 6
_LARGEST_SCATTER: Final = 0.5
"""Share of its light by which a patch may differ from its density."""


@dataclass(frozen=True, slots=True, kw_only=True)
class FlareFit:
    """Signal = response (10^-(density - lowest density) + flare) + dark signal, fitted to one channel.

    Parameters
    ----------
    flare
        Stray light as a fraction of the signal that the lightest patch has without it, signed; the error of the offset
        is in its own [1].
    flare_at_offset
        The same for the offset as it is given and with the dark signal in it, whose noise patches have too: for
        `camera_dynamic_range`, where an error of the offset drops out [1].
    response
        Signal of the lightest patch without stray light [DN].
    density_scatter
        What patches differ from their densities by, beyond their noise, as a standard deviation of density; it is in
        the errors.
    chi_square, dof
        Of the residuals over their noise alone, before ``density_scatter`` was allowed for.

    """

    flare: Measured
    flare_at_offset: Measured
    response: Measured
    density_scatter: float
    chi_square: float
    dof: int


def fit_flare(
    signal_dn: ArrayLike,
    std_error_dn: ArrayLike,
    densities: ArrayLike,
    *,
    offset_std_error_dn: float,
    identified: bool,
    dark_signal_dn: float = 0.0,
    dark_signal_std_error_dn: float = 0.0,
) -> FlareFit:
    """Fit stray light to the densities of a chart (METHOD 2.2).

    Parameters
    ----------
    signal_dn
        Mean above the identified offset of each patch of one channel, shape (N,); NaN for clipped patches, whose
        density still says which is the lightest [DN].
    std_error_dn
        Of each mean, that of the offset not included, shape (N,) [DN].
    densities
        Density of each patch, shape (N,); NaN where unknown.
    offset_std_error_dn
        Standard error of the offset [DN].
    identified
        Whether other evidence than this chart's densities identifies the offset (`FusedLevel.identified`).
    dark_signal_dn, dark_signal_std_error_dn
        What dark current adds to every patch during the exposure, and its standard error [DN].

    Returns
    -------
    FlareFit

    Raises
    ------
    ValueError
        Where the offset is not identified: flare and offset then cannot be told apart; with fewer than three different
        densities; where patches do not get darker with density.

    """
    signal, noise, density = (np.asarray(values, np.float64) for values in (signal_dn, std_error_dn, densities))
    if not identified:
        raise ValueError("flare and offset add alike: densities tell flare only where other evidence gives the offset")
    known = np.isfinite(signal) & np.isfinite(density) & np.isfinite(noise) & (noise > 0.0)
    if np.unique(density[known]).size < _FEWEST:
        raise ValueError("flare needs three patches of different density or more")
    points = _Points(
        signal=signal[known],
        variance=noise[known] ** 2,
        transmission=10.0 ** -(density[known] - float(np.nanmin(density))),
    )
    dof = points.signal.size - 2
    alone = _line(points, 0.0)
    scatter = 0.0 if alone.excess <= 0.0 else _scatter(points)
    line = alone if scatter == 0.0 else _line(points, scatter)
    misfit = is_misfit(line.chi_square, dof)
    covariance = line.covariance * (line.chi_square / dof if misfit else 1.0)
    law = float(dof) if scatter > 0.0 or misfit else None
    response, constant = line.coefficients
    with_dark, its_error = _share_of(response, constant, covariance)
    flare, error = _share_of(response, constant - dark_signal_dn, covariance)
    level_error = math.hypot(offset_std_error_dn, dark_signal_std_error_dn) / response
    return FlareFit(
        flare=Measured.student(flare, math.hypot(error, level_error), law, ONE),
        flare_at_offset=Measured.student(with_dark, its_error, law, ONE),
        response=Measured.student(response, math.sqrt(float(covariance[0, 0])), law, DN),
        density_scatter=scatter / math.log(10.0),
        chi_square=alone.chi_square,
        dof=dof,
    )


def _share_of(response: float, constant: float, covariance: NDArray[np.float64]) -> tuple[float, float]:
    """Return a constant over the response, and its standard error [1]."""
    share = constant / response
    gradient = np.array([-share, 1.0]) / response
    return share, math.sqrt(float(gradient @ covariance @ gradient))


@dataclass(frozen=True, slots=True, kw_only=True)
class _Points:
    signal: NDArray[np.float64]
    variance: NDArray[np.float64]
    transmission: NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True)
class _Line:
    """Signal against transmission: response and constant, their covariance, chi-square, and the score of the scatter.

    ``excess`` is the derivative of the restricted likelihood by the scatter's variance: zero at its maximum.
    """

    coefficients: NDArray[np.float64]
    covariance: NDArray[np.float64]
    chi_square: float
    excess: float


def _line(points: _Points, scatter: float) -> _Line:
    """Fit a line whose points scatter by their noise and by a share ``scatter`` of the light that passes the chart."""
    design = np.stack([points.transmission, np.ones_like(points.transmission)], axis=-1)
    response = float(points.signal.max())
    coefficients, covariance = np.zeros(2), np.zeros((2, 2))
    weights = light = np.ones_like(points.transmission)
    for _ in range(1 if scatter == 0.0 else _ITERATIONS):
        light = response * points.transmission
        weights = 1.0 / (points.variance + (scatter * light) ** 2)
        covariance = np.asarray(np.linalg.inv(design.T @ (weights[:, None] * design)), np.float64)
        coefficients = covariance @ (design.T @ (weights * points.signal))
        response = float(coefficients[0])
    residuals = points.signal - design @ coefficients
    leverage = weights * np.einsum("ip,pq,iq->i", design, covariance, design)
    share = weights * light**2
    if response <= 0.0:
        raise ValueError("the patches do not get darker with density: check the densities and their order")
    return _Line(
        coefficients=coefficients,
        covariance=covariance,
        chi_square=float(weights @ residuals**2),
        excess=float(share @ (weights * residuals**2 - (1.0 - leverage))),
    )


def _scatter(points: _Points) -> float:
    """Return the share of the light that maximizes the restricted likelihood, at most ``_LARGEST_SCATTER``."""

    def excess(scatter: float) -> float:
        return _line(points, scatter).excess

    return _LARGEST_SCATTER if excess(_LARGEST_SCATTER) > 0.0 else root_between(excess, 0.0, _LARGEST_SCATTER)
