"""The Imatest page on sensor noise: its fit of the noise coefficients and its offset.

Its Appendix 2 and its text contradict each other: both are here. METHOD 1.5 and 2.2 say by how much each is off.
"""

import math
from dataclasses import dataclass
from typing import Final, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fullwell.fit.solvers import levenberg_marquardt
from fullwell.units import DN, ONE, Measured

_NEARLY_ZERO: Final = 1e-3
"""Start of k_fpn: published as 0, where its derivative vanishes and the optimizer would never move it."""


@dataclass(frozen=True, slots=True, kw_only=True)
class LegacyNoiseCoefficients:
    """k_dark, k_shot and k_fpn as published, without errors [1].

    Parameters
    ----------
    k_dark, k_shot, k_fpn
        Of the normalized signal V = S / D.
    fixed_pattern_dropped
        Whether the second stage, without k_fpn, was taken.

    """

    k_dark: Measured
    k_shot: Measured
    k_fpn: Measured
    fixed_pattern_dropped: bool


def fit_legacy_imatest(
    signal_dn: ArrayLike, variance_dn2: ArrayLike, *, digital_maximum: float, objective: Literal["variance", "sigma"]
) -> LegacyNoiseCoefficients:
    """Fit the k's with Levenberg and Marquardt in two stages, as published.

    Parameters
    ----------
    signal_dn
        Mean above the black level of each patch, shape (N,) [DN].
    variance_dn2
        Single-frame variance of each patch [DN^2].
    digital_maximum
        D [DN].
    objective
        ``sigma`` as Appendix 2.2 has it: differences of noise, unweighted. ``variance`` as the text has it: differences
        of squared noise, weighted towards the dark by 1 / s^2.

    Returns
    -------
    LegacyNoiseCoefficients
        Where the first stage ends with k_fpn below zero, the second one without k_fpn is taken.

    """
    order = np.argsort(np.asarray(signal_dn, np.float64), kind="stable")
    level = np.asarray(signal_dn, np.float64)[order] / digital_maximum
    variance = np.asarray(variance_dn2, np.float64)[order] / digital_maximum**2
    dark = math.sqrt(variance[0])
    shot = math.sqrt(max(variance[-1] - variance[0], variance[-1] * 1e-6) / (level[-1] - level[0]))
    powers = np.stack([level**0, level, level**2], axis=-1)
    full = _fit_k(np.array([dark, shot, _NEARLY_ZERO]), powers, variance, objective)
    dropped = bool(full[2] < 0.0)
    if dropped:
        reduced = _fit_k(np.array([dark, shot]), powers[:, :2], variance, objective)
        full = np.append(reduced, 0.0)
    return LegacyNoiseCoefficients(
        k_dark=Measured.exact(abs(full[0]), ONE),
        k_shot=Measured.exact(abs(full[1]), ONE),
        k_fpn=Measured.exact(full[2], ONE),
        fixed_pattern_dropped=dropped,
    )


def legacy_offset_ratio(lowest_dn: float, highest_dn: float, *, ratio: float = 1e5) -> Measured:
    """Return the offset that makes highest over lowest patch equal ``ratio``: it absorbs all flare (METHOD 2.2)."""
    return Measured.exact((highest_dn - ratio * lowest_dn) / (1.0 - ratio), DN)


def _fit_k(
    start: NDArray[np.float64],
    powers: NDArray[np.float64],
    variance: NDArray[np.float64],
    objective: Literal["variance", "sigma"],
) -> NDArray[np.float64]:
    noise = np.sqrt(variance)

    def residuals(k: NDArray[np.float64]) -> NDArray[np.float64]:
        model = powers @ k**2
        return np.sqrt(model) - noise if objective == "sigma" else (model - variance) / noise

    def jacobian(k: NDArray[np.float64]) -> NDArray[np.float64]:
        by_k = 2.0 * powers * k
        divisor = 2.0 * np.sqrt(powers @ k**2) if objective == "sigma" else noise
        return by_k / divisor[:, None]

    return levenberg_marquardt(residuals, jacobian, start)[0]
