"""Read noise before quantization, from the temporal variance of unlit pixels (METHOD 3.1, 3.3, 3.6).

Which case applies: noise well above half a code is the variance less q^2/12; below, the rounding law is inverted, which
needs levels that cover all phases of a code; without that spread the phase is unknown, and so is the noise: an interval
is all that can be said.
"""

import math
from dataclasses import dataclass
from functools import lru_cache
from typing import Final

import numpy as np

from fullwell.fit.rounding_region import possible_before_rounding
from fullwell.model.quantization import (
    quantization_variance,
    rounded_pattern_at_phase,
    rounded_variance,
    rounded_variance_at_phase,
    rounded_variance_slope,
)
from fullwell.units import DN, DN2, ONE, Measured, square_root

COVERING_SPREAD: Final = 0.5
"""Spread of the pixels' levels, in codes, from which all phases count as covered."""
MEASURABLE: Final = 0.45
"""Noise, in codes, below which an unknown phase leaves no more than an interval: a level at the edge of two codes makes
any less noise look like 0.41."""

_NO_PHASE: Final = 1.25
"""Noise and spread together, in codes, from which on a phase moves a variance by 1e-12 code^2 at most."""
_CONVERGED: Final = 1e-15
"""Part of the noise that a last step may be: some roundings."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ReadNoise:
    """Read noise with the quantization removed.

    Parameters
    ----------
    noise
        Standard deviation [DN].
    variance
        Its signed square [DN^2].
    quantization_limited
        Whether the unknown phase of the level within a code leaves only an interval.

    """

    noise: Measured
    variance: Measured
    quantization_limited: bool

    @property
    def flags(self) -> tuple[str, ...]:
        """Return the flags of its rows."""
        limit = ("upper-limit",) if self.noise.std_error is None else ()
        return (*(("quantization-limited",) if self.quantization_limited else ()), *limit)


def analogue_read_noise(
    temporal_variance: Measured, *, quantization_step: float = 1.0, spatial_spread_dn: float, n: int | None = None
) -> ReadNoise:
    """Return the noise that rounding was applied to (METHOD 3.3).

    Parameters
    ----------
    temporal_variance
        Mean over the pixels of the variance of one pixel over frames, quantization included [DN^2].
    quantization_step
        Distance of two codes q [DN].
    spatial_spread_dn
        Standard deviation over the pixels of their levels, free of temporal noise (DSNU); it decides whether the
        levels cover all phases of a code [DN].
    n
        Values behind the variance: where hardly any of them left their code, the rule of three bounds how often they
        may; None leaves that to the standard error.

    Returns
    -------
    ReadNoise
        Where the phase matters but noise above 0.45 q keeps its effect small, the standard error includes it.

    """
    noise = unrounded_noise(temporal_variance.value, step=quantization_step)
    covered = spatial_spread_dn >= COVERING_SPREAD * quantization_step
    if noise < MEASURABLE * quantization_step and not covered:
        unseen = 0.0 if n is None else 3.0 / n
        return _over_unknown_phase(temporal_variance, noise, quantization_step, max(spatial_spread_dn, 0.0), unseen)
    if noise >= 0.5 * quantization_step:
        value, slope = temporal_variance.value - quantization_variance(quantization_step), 1.0
    else:
        value = noise**2
        slope = rounded_variance_slope(max(noise, 1e-6 * quantization_step), step=quantization_step)
    phase = 0.0 if covered else phase_effect(noise, step=quantization_step, spread=max(spatial_spread_dn, 0.0))
    std_error = math.hypot(temporal_variance.std_error or 0.0, phase / math.sqrt(2.0)) / slope
    variance = Measured.student(value, std_error, temporal_variance.dof, DN2)
    return ReadNoise(noise=square_root(variance, DN), variance=variance, quantization_limited=False)


@lru_cache(1024)
def unrounded_noise(variance_dn2: float, *, step: float = 1.0) -> float:
    """Invert the rounding law averaged over all phases (METHOD 3.3), by Newton's method between bounds.

    Parameters
    ----------
    variance_dn2
        Temporal variance of rounded codes [DN^2].
    step
        Distance of two codes q [DN].

    Returns
    -------
    float
        Noise before rounding [DN]; zero for a variance at or below zero.

    Examples
    --------
    >>> round(unrounded_noise(rounded_variance(0.2)), 9)
    0.2

    """
    if variance_dn2 <= 0.0:
        return 0.0
    noise = math.sqrt(variance_dn2)
    low, high = 0.0, noise + step
    while True:
        surplus = rounded_variance(noise, step=step) - variance_dn2
        low, high = (low, noise) if surplus > 0.0 else (noise, high)
        newton = noise - surplus / (2.0 * noise * rounded_variance_slope(noise, step=step))
        found = newton if low < newton < high else (low + high) / 2.0
        if not abs(found - noise) > _CONVERGED * noise:  # what is not a number ends the search too
            return found
        noise = found


@lru_cache(1024)
def phase_effect(noise: float, *, step: float = 1.0, spread: float = 0.0) -> float:
    """Return how far one unknown phase moves the variance at most from its mean over phases [DN^2].

    The noise may be less than it seems by just that effect, which is larger then; below a third of a code, where that
    has no end, it is taken to be 0.7 of what it seems. It falls as exp(-2 pi^2 (noise^2 + spread^2) / q^2).
    """
    if math.hypot(noise, spread) >= _NO_PHASE * step:
        return 0.0
    phases = np.array([0.0, 0.5 * step])

    def effect(of: float) -> float:
        whole = rounded_variance_at_phase(max(math.hypot(of, spread), 1e-3 * step), phases, step=step)
        extremes = whole - rounded_pattern_at_phase(spread, phases, noise=of, step=step)
        return float(np.abs(extremes - rounded_variance(of, step=step)).max())

    return effect(max(math.sqrt(max(noise**2 - effect(noise), 0.0)), 0.7 * noise))


def temporal_range(variance: Measured, *, unseen: float, step: float) -> tuple[float, float]:
    """Return the ends of a temporal variance for `possible_before_rounding` [code^2].

    They lie two and a half errors to either side, since the pattern has to lie between ends of its own as well.
    """
    slack = max(2.5 * (variance.std_error or 0.0) / step**2, unseen)
    return variance.value / step**2 - slack, variance.value / step**2 + slack


def _over_unknown_phase(variance: Measured, noise: float, step: float, spread: float, unseen: float) -> ReadNoise:
    """Return every noise that some phase reconciles with the variance; its error is that of a uniform law."""
    temporal = temporal_range(variance, unseen=unseen, step=step)
    pattern = (spread / step) ** 2
    slack = 0.1 * pattern + unseen + 1.5 * (temporal[1] - temporal[0])
    possible = possible_before_rounding(temporal, (pattern - slack, pattern + slack))
    ends = (0.0, noise) if possible is None else (possible.noise[0] * step, possible.noise[1] * step)
    low, high = min(ends[0], noise), max(ends[1], noise)
    std_error = (high - low) / math.sqrt(12.0)
    return ReadNoise(
        noise=Measured.interval(noise, std_error, (low, high), DN),
        variance=Measured.interval(noise**2, (high**2 - low**2) / math.sqrt(12.0), (low**2, high**2), DN2),
        quantization_limited=True,
    )


def excess_ratio(scatter_dn4: float, temporal_variance_dn2: float, *, frames: int, pixels: int) -> Measured:
    """Return how much more the per-pixel variances scatter than Gaussian noise would make them (METHOD 3.6).

    Parameters
    ----------
    scatter_dn4
        Variance over pixels of the per-pixel variance [DN^4].
    temporal_variance_dn2
        Mean over pixels of the per-pixel variance [DN^2].
    frames, pixels
        L and n.

    Returns
    -------
    Measured
        1 for Gaussian noise; the error is what Gaussian noise leaves [1].

    """
    dof = frames - 1
    ratio = scatter_dn4 / (2.0 * temporal_variance_dn2**2 / dof) if temporal_variance_dn2 > 0.0 else 1.0
    return Measured.normal(ratio, math.sqrt((2.0 + 12.0 / dof) / pixels), ONE)
