"""Fixed pattern of the sensor in spite of the chart's texture: two framings of one chart (METHOD 1.9).

A pixel keeps its response, the texture moves with the chart, temporal noise is new in every frame: the covariance of
the relative residuals of two framings, aligned on the sensor, is the squared PRNU alone.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from fullwell.fit.noise_coefficients import boundary_variance
from fullwell.statistics.tiles import SURFACE_TERMS
from fullwell.units import ONE, Measured

_SMALLEST_SIDE: Final = 8
_LAGS: Final = 4
"""Pixels over which a chart's texture may be correlated; it widens the scatter of the covariance."""
_ITERATIONS: Final = 4
_VARIANCES: Final = ("first", "second")


@dataclass(frozen=True, slots=True, kw_only=True)
class TwoFramings:
    """What two framings say together.

    Parameters
    ----------
    prnu_variance
        Squared PRNU, signed [1].
    first_variance, second_variance
        Relative variance in each framing alone, weighted as the covariance: temporal noise and texture included [1].
    neighbour_covariance
        Covariance with the pixels beside, zero but for what is smooth over pixels and common to both framings: light
        that a surface of second order cannot follow, or a shift too small for the texture; its error is the most that
        texture smooth over pixels makes it [1].
    clean
        Whether ``neighbour_covariance`` is zero within three standard errors.
    n
        Pixels in common.

    """

    prnu_variance: Measured
    first_variance: float
    second_variance: float
    neighbour_covariance: Measured
    clean: bool
    n: int


def two_framings(
    first_dn: Sequence[NDArray[np.float64]], second_dn: Sequence[NDArray[np.float64]], *, framings: int = 2
) -> TwoFramings:
    """Return the squared PRNU from pixels that two framings of a chart have in common (METHOD 1.9).

    Parameters
    ----------
    first_dn, second_dn
        Signal above black of one CFA plane, one array per region that lies inside a patch in both framings: the same
        pixels of the sensor in both, each of shape (rows, columns), at least 8 x 8. The patches may differ between the
        framings; the chart has to be shifted by 3 pixels or more [DN].
    framings
        From how many the pairs were made, each with each: pairs that share a framing, or only the sensor, err together.

    Returns
    -------
    TwoFramings
        Regions are weighted by inverse variance, sqrt((v1 v2 + c^2) / nu) being the standard error of each; where the
        texture is smooth over pixels, v1 v2 is the sum over lags of the products of the autocovariances. What the
        removal of the surfaces can take off at most, where both see the same coarse texture, is in the error.

    Raises
    ------
    ValueError
        Without regions, or where two that belong together differ in shape, are too small or not positive.

    Notes
    -----
    DSNU is common to both framings as well and adds DSNU^2 / (S1 S2): give no regions near black.

    """
    regions = [_region(one, other) for one, other in zip(first_dn, second_dn, strict=True)]
    if not regions:
        raise ValueError("two framings need at least one region that both show inside a patch")
    covariance = np.array([region.covariance for region in regions])
    dof = np.array([region.dof for region in regions], np.float64)
    noise = np.array([region.noise for region in regions])
    weights = dof / noise
    for _ in range(_ITERATIONS):
        weights = dof / (noise + float(np.average(covariance, weights=weights)) ** 2)
    pooled = float(np.average(covariance, weights=weights))
    leak = float(np.average([region.leak for region in regions], weights=weights))
    first, second = (float(np.average([getattr(one, name) for one in regions], weights=weights)) for name in _VARIANCES)
    alike = _alike(math.sqrt(first * second), max(pooled, 0.0), framings)
    error = math.hypot(math.sqrt(alike / float(weights.sum())), leak)
    beside = float(np.average([region.neighbours for region in regions], weights=weights))
    return TwoFramings(
        prnu_variance=boundary_variance(pooled, error, dof=None),
        first_variance=first,
        second_variance=second,
        neighbour_covariance=Measured.normal(beside, error, ONE),
        clean=abs(beside) <= 3.0 * error,
        n=sum(region.n for region in regions),
    )


def _alike(variance: float, shared: float, framings: int) -> float:
    """Return how much more the mean over all pairs scatters than that of independent ones, seen on the same pixels.

    Of one pair the product of residuals has the variance v^2 + c^2, v that of a framing and c the covariance; with a
    pair that has one framing in common the covariance v c + c^2, with one that has none 2 c^2.
    """
    own = variance**2 + shared**2
    with_one = 2 * (framings - 2)
    with_none = (framings - 2) * (framings - 3) / 2
    return 1.0 + (with_one * (variance * shared + shared**2) + with_none * 2.0 * shared**2) / own


@dataclass(frozen=True, slots=True, kw_only=True)
class _Region:
    """One region: covariance, that with the four pixels beside, variances, and nu Var(covariance) for no PRNU.

    ``leak`` is the most that texture, smooth over the shift, can take off with the surfaces.
    """

    n: int
    dof: int
    covariance: float
    neighbours: float
    first: float
    second: float
    noise: float
    leak: float


def _region(first_dn: NDArray[np.float64], second_dn: NDArray[np.float64]) -> _Region:
    if first_dn.shape != second_dn.shape or min(first_dn.shape) < _SMALLEST_SIDE:
        raise ValueError("regions of two framings show the same pixels of the sensor, at least 8 x 8 of them")
    one, other = _relative_residuals(first_dn), _relative_residuals(second_dn)
    dof = one.size - SURFACE_TERMS
    across = [float(np.mean(a * b)) for a, b in _beside(one, other)]
    own, others = _autocovariance(one), _autocovariance(other)
    white = float(own[0, 0] * others[0, 0])
    scale = one.size / dof
    return _Region(
        n=one.size,
        dof=dof,
        covariance=float(np.sum(one * other)) / dof,
        neighbours=sum(across) / len(across),
        first=float(own[0, 0]) * scale,
        second=float(others[0, 0]) * scale,
        noise=max(white, float(np.sum(own * others))) * scale**2,
        leak=SURFACE_TERMS / dof * max(min(float(own.sum()), float(others.sum())), 0.0),
    )


def _relative_residuals(signal_dn: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return signal / surface - 1 of a quadratic surface."""
    v, u = (axis.ravel() - axis.mean() for axis in np.mgrid[: signal_dn.shape[0], : signal_dn.shape[1]])
    design = np.stack([np.ones_like(u), u, v, u * u, u * v, v * v], axis=-1)
    basis, _ = np.linalg.qr(design)
    flat = np.asarray(signal_dn, np.float64).ravel()
    surface = basis @ (basis.T @ flat)
    if not np.all(surface > 0.0):
        raise ValueError("regions of two framings need a signal above black")
    return (flat / surface - 1.0).reshape(signal_dn.shape)


def _beside(one: NDArray[np.float64], other: NDArray[np.float64]) -> list[tuple[NDArray[np.float64], ...]]:
    """Return the four pairings of each pixel with a pixel beside it."""
    return [
        (one[:-1], other[1:]),
        (one[1:], other[:-1]),
        (one[:, :-1], other[:, 1:]),
        (one[:, 1:], other[:, :-1]),
    ]


def _autocovariance(residuals: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the autocovariance at lags up to four pixels either way; [0, 0] is the variance."""
    shape = tuple(size + _LAGS for size in residuals.shape)
    power = np.abs(np.fft.rfft2(residuals, s=shape)) ** 2
    full = np.fft.irfft2(power, s=shape) / residuals.size
    lags = np.arange(-_LAGS, _LAGS + 1)
    return np.roll(full[np.ix_(lags, lags)], (-_LAGS, -_LAGS), axis=(0, 1))
