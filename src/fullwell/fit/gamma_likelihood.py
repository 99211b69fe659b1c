"""The engine of every fit to variances: gamma likelihood, identity link, by iterated weighted least squares.

A variance estimate with nu degrees of freedom follows sigma^2 chi^2(nu) / nu: a gamma law whose mean is linear in the
coefficients. Maximizing its likelihood is weighted least squares with weights nu / (2 mu^2), repeated until the model
variance mu stands still: closed form per step, no starting values (METHOD 1.2). Leading axes are independent data sets,
so thousands of them are solved in one call.
"""

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

MAX_ITERATIONS: Final = 200
_TOLERANCE: Final = 1e-9
"""Largest step of a coefficient at convergence, in standard errors."""
_SMALLEST_RATIO: Final = 1e-2
"""A model variance is never taken smaller than this share of the measured one while iterating."""


@dataclass(frozen=True, slots=True, kw_only=True)
class GammaFit:
    """Solution of `fit_gamma`, leading axes as in the data.

    Parameters
    ----------
    coefficients
        Shape (..., p).
    covariance
        Absolute covariance (X' W X)^-1, shape (..., p, p); residuals play no part in it.
    predicted
        Model variance mu of each point, shape (..., N).
    effective_dof
        Degrees of freedom behind each point once its low-signal excess is counted, shape (..., N).
    converged
        Whether every coefficient stood still, shape (...).

    """

    coefficients: NDArray[np.float64]
    covariance: NDArray[np.float64]
    predicted: NDArray[np.float64]
    effective_dof: NDArray[np.float64]
    converged: NDArray[np.bool_]


def fit_gamma(
    design: NDArray[np.float64],
    response: NDArray[np.float64],
    dof: NDArray[np.float64],
    *,
    low_signal: NDArray[np.float64] | None = None,
    used: NDArray[np.bool_] | None = None,
) -> GammaFit:
    """Fit ``response`` = ``design`` @ coefficients, where each response is a variance estimate (METHOD 1.2, 1.3).

    Parameters
    ----------
    design
        Shape (..., N, p). Where ``low_signal`` is given, the first coefficient is A and the second B.
    response
        Variance estimates, shape (..., N) [DN^2].
    dof
        Degrees of freedom nu of each, shape (..., N) or broadcastable.
    low_signal
        Factor of B^2 A in the variance of a point beyond 2 mu^2 / nu: 1/n for n pixel values behind it. It is what the
        noise of the mean signal and the skewness and kurtosis of the Poisson law leave at low read noise (METHOD 1.3).
    used
        Points that take part, shape (..., N); all by default.

    Returns
    -------
    GammaFit

    """
    nu = np.broadcast_to(np.asarray(dof, np.float64), response.shape)
    weight_of_use = np.ones(response.shape) if used is None else used.astype(np.float64)
    floor = np.maximum(np.abs(response) * _SMALLEST_RATIO, np.finfo(np.float64).tiny ** 0.25)
    predicted = np.maximum(response, floor)
    excess = np.zeros(response.shape)
    coefficients = np.zeros((*response.shape[:-1], design.shape[-1]))
    step = np.full(response.shape[:-1], np.inf)
    information = np.zeros((*coefficients.shape, design.shape[-1]))
    for iteration in range(MAX_ITERATIONS):
        weights = weight_of_use / (2.0 * predicted**2 / nu + excess)
        new, information = _weighted_least_squares(design, response, weights)
        if iteration >= MAX_ITERATIONS // 2:
            new = 0.5 * (new + coefficients)
        change = new - coefficients
        step = np.sqrt(np.abs(np.einsum("...i,...ij,...j->...", change, information, change)))
        coefficients = new
        predicted = np.maximum(np.einsum("...np,...p->...n", design, coefficients), floor)
        if low_signal is not None:
            leading = np.maximum(coefficients[..., 0], 0.0) * coefficients[..., 1] ** 2
            excess = leading[..., None] * low_signal
        if np.all(step < _TOLERANCE):
            break
    weights = 1.0 / (2.0 * predicted**2 / nu + excess)
    _, information = _weighted_least_squares(design, response, weights * weight_of_use)
    return GammaFit(
        coefficients=coefficients,
        covariance=_inverse(information),
        predicted=predicted,
        effective_dof=2.0 * predicted**2 * weights,
        converged=step < 1e3 * _TOLERANCE,
    )


def signed_deviance(
    response: NDArray[np.float64], predicted: NDArray[np.float64], dof: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Return the signed residual r = +-sqrt(nu (q - 1 - ln q)), q = s^2 / mu, about standard normal (METHOD 1.8)."""
    ratio = np.maximum(response / predicted, 1e-12)
    return np.sign(ratio - 1.0) * np.sqrt(np.maximum(dof * (ratio - 1.0 - np.log(ratio)), 0.0))


def _weighted_least_squares(
    design: NDArray[np.float64], response: NDArray[np.float64], weights: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the coefficients and X' W X, its columns equilibrated while solving."""
    weighted = design * weights[..., None]
    information = np.einsum("...np,...nq->...pq", weighted, design)
    score = np.einsum("...np,...n->...p", weighted, response)
    scale = _column_scale(information)
    scaled = information * scale[..., :, None] * scale[..., None, :]
    solution = np.linalg.solve(scaled, (score * scale)[..., None])[..., 0]
    return solution * scale, information


def _column_scale(information: NDArray[np.float64]) -> NDArray[np.float64]:
    diagonal = np.diagonal(information, axis1=-2, axis2=-1)
    return 1.0 / np.sqrt(np.where(diagonal > 0.0, diagonal, 1.0))


def _inverse(information: NDArray[np.float64]) -> NDArray[np.float64]:
    scale = _column_scale(information)
    scaled = information * scale[..., :, None] * scale[..., None, :]
    return np.linalg.inv(scaled) * scale[..., :, None] * scale[..., None, :]
