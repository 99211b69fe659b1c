"""Stray light, from the densities of a chart and an offset that other evidence identifies (METHOD 2.2, 2.3).

Flare and offset add to every patch alike: one exposure of one chart tells their sum, never both. Patches that err by a
share of their light do not err at random where the light is uneven: a smooth surface over the chart takes that.
"""

import math
from dataclasses import dataclass, replace
from typing import Final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fullwell.fit.goodness import is_misfit
from fullwell.fit.solvers import root_between
from fullwell.units import DN, ONE, Measured

_FEWEST: Final = 3
_ITERATIONS: Final = 6
_EVEN: Final = 2
"""Terms of a response that is the same all over the chart, and a constant."""
_DEGENERATE: Final = 1e-6
"""Size of a term, beside the largest, below which the places of the patches do not tell it from others."""
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
        What patches differ from their densities by, beyond their noise and uneven light, as a standard deviation of
        density; it is in the errors.
    uneven
        Whether a surface of uneven light was fitted beside.
    chi_square, dof
        Of the residuals over their noise alone, before ``density_scatter`` was allowed for.

    """

    flare: Measured
    flare_at_offset: Measured
    response: Measured
    density_scatter: float
    uneven: bool
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
    places: ArrayLike | None = None,
    covariance_dn2: ArrayLike = 0.0,
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
    places
        Where the patches lie, shape (N, 2), in any unit. Where noise alone does not explain the residuals, the light is
        taken for a plane over the chart, or a quadratic surface, if that leaves half of the patches to tell how well;
        None: for even.
    covariance_dn2
        What means have in common, such as the noise of the rows they share, shape (N, N); zero for each with itself,
        since its own part is in ``std_error_dn`` [DN^2].

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
    points = _evenly_lit(signal[known], noise[known], density[known] - float(np.nanmin(density)))
    alone = _line(points, 0.0)
    if alone.excess > 0.0 and places is not None:
        points = _unevenly_lit(points, np.asarray(places, np.float64), known, int(np.nanargmin(density)))
        alone = _line(points, 0.0)
    scatter = 0.0 if alone.excess <= 0.0 else _scatter(points)
    line = alone if scatter == 0.0 else _line(points, scatter)
    dof = points.signal.size - line.coefficients.size
    misfit = is_misfit(line.chi_square, dof)
    common = np.broadcast_to(np.asarray(covariance_dn2, np.float64), signal.shape * 2)[np.ix_(known, known)]
    covariance = line.covariance * (line.chi_square / dof if misfit else 1.0)
    covariance = covariance + line.influence @ common @ line.influence.T
    law = float(dof) if scatter > 0.0 or misfit else None
    with_dark, its_error = _share_of(points.lightest, line.coefficients, covariance, less_dn=0.0)
    flare, error = _share_of(points.lightest, line.coefficients, covariance, less_dn=dark_signal_dn)
    light = np.append(points.lightest, 0.0)
    response = float(light @ line.coefficients)
    level_error = math.hypot(offset_std_error_dn, dark_signal_std_error_dn) / response
    return FlareFit(
        flare=Measured.student(flare, math.hypot(error, level_error), law, ONE),
        flare_at_offset=Measured.student(with_dark, its_error, law, ONE),
        response=Measured.student(response, math.sqrt(float(light @ covariance @ light)), law, DN),
        density_scatter=scatter / math.log(10.0),
        uneven=light.size > _EVEN,
        chi_square=alone.chi_square,
        dof=dof,
    )


def _share_of(
    lightest: NDArray[np.float64],
    coefficients: NDArray[np.float64],
    covariance: NDArray[np.float64],
    *,
    less_dn: float,
) -> tuple[float, float]:
    """Return the constant, less a part that is none of it, over the response there, and its standard error [1]."""
    light = np.append(lightest, 0.0)
    response = float(light @ coefficients)
    share = (float(coefficients[-1]) - less_dn) / response
    gradient = (np.eye(light.size)[-1] - share * light) / response
    return share, math.sqrt(float(gradient @ covariance @ gradient))


@dataclass(frozen=True, slots=True, kw_only=True)
class _Points:
    """What is fitted; ``surface`` holds the terms of the light at each patch, ``lightest`` those at the lightest."""

    signal: NDArray[np.float64]
    variance: NDArray[np.float64]
    transmission: NDArray[np.float64]
    surface: NDArray[np.float64]
    lightest: NDArray[np.float64]


def _evenly_lit(signal: NDArray[np.float64], noise: NDArray[np.float64], density: NDArray[np.float64]) -> _Points:
    """Return the points of a chart in even light; densities count from the lightest patch."""
    return _Points(
        signal=signal,
        variance=noise**2,
        transmission=10.0**-density,
        surface=np.ones((signal.size, 1)),
        lightest=np.ones(1),
    )


def _unevenly_lit(points: _Points, places: NDArray[np.float64], known: NDArray[np.bool_], lightest: int) -> _Points:
    """Return the points with a surface of as many terms as leave half of them to tell the scatter."""
    x, y = ((places - places.mean(axis=0)) / max(float(np.ptp(places)), 1e-300)).T
    for terms in ((x**0, x, y, x**2, x * y, y**2), (x**0, x, y)):
        every = np.stack(terms, axis=-1)
        left, sizes, _ = np.linalg.svd(every[known], full_matrices=False)
        told = sizes > _DEGENERATE * sizes[0]
        if 2 * (points.signal.size - int(told.sum()) - 1) >= points.signal.size:
            to_told = np.linalg.pinv(every[known], rcond=_DEGENERATE) @ left[:, told]
            return replace(points, surface=left[:, told], lightest=every[lightest] @ to_told)
    return points


@dataclass(frozen=True, slots=True, kw_only=True)
class _Line:
    """Signal against transmission: terms of the response and, last, a constant; their covariance, chi-square.

    ``influence`` is by what they move with each signal; ``excess`` is the derivative of the restricted likelihood by
    the scatter's variance: zero at its maximum.
    """

    coefficients: NDArray[np.float64]
    covariance: NDArray[np.float64]
    influence: NDArray[np.float64]
    chi_square: float
    excess: float


def _line(points: _Points, scatter: float) -> _Line:
    """Fit a line whose points scatter by their noise and by a share ``scatter`` of the light that passes the chart."""
    passed = points.transmission[:, None] * points.surface
    design = np.append(passed, np.ones((passed.shape[0], 1)), axis=-1)

    def weighted(light: NDArray[np.float64]) -> NDArray[np.float64]:
        return 1.0 / (points.variance + (scatter * light) ** 2)

    light = float(points.signal.max()) * points.transmission
    for _ in range(0 if scatter == 0.0 else _ITERATIONS - 1):
        light = passed @ _solved(points.signal, design, weighted(light))[0][:-1]
    weights = weighted(light)
    coefficients, covariance = _solved(points.signal, design, weights)
    light = passed @ coefficients[:-1]
    residuals = points.signal - design @ coefficients
    leverage = weights * np.einsum("ip,pq,iq->i", design, covariance, design)
    share = weights * light**2
    if points.lightest @ coefficients[:-1] <= 0.0:
        raise ValueError("the patches do not get darker with density: check the densities and their order")
    return _Line(
        coefficients=coefficients,
        covariance=covariance,
        influence=covariance @ (weights[:, None] * design).T,
        chi_square=float(weights @ residuals**2),
        excess=float(share @ (weights * residuals**2 - (1.0 - leverage))),
    )


def _solved(
    signal: NDArray[np.float64], design: NDArray[np.float64], weights: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the coefficients of weighted least squares and their covariance."""
    covariance = np.asarray(np.linalg.inv(design.T @ (weights[:, None] * design)), np.float64)
    return covariance @ (design.T @ (weights * signal)), covariance


def _scatter(points: _Points) -> float:
    """Return the share of the light that maximizes the restricted likelihood, at most ``_LARGEST_SCATTER``."""

    def excess(scatter: float) -> float:
        return _line(points, scatter).excess

    return _LARGEST_SCATTER if excess(_LARGEST_SCATTER) > 0.0 else root_between(excess, 0.0, _LARGEST_SCATTER)
