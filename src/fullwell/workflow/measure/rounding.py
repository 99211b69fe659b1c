"""What rounding to whole codes leaves unknown of a temporal variance when the noise is small (METHOD 3.3)."""

import math
from collections.abc import Iterable

from fullwell.fit.read_noise import phase_effect, unrounded_noise
from fullwell.fit.rounded_pattern import NO_EFFECT, pattern_phase_effect
from fullwell.model.quantization import quantization_variance
from fullwell.statistics.series import PlaneStatistics
from fullwell.workflow.measure.bursts import IsoBursts

NOTABLE_SHIFT_DN = 0.01


def rounding_error_dn2(plane: PlaneStatistics, variance_dn2: float) -> float:
    """Return one standard error of a temporal variance from the unknown phase of its level within a code [DN^2].

    Noise above about half the distance of two codes, or levels that differ by as much between pixels, leave nothing
    of the error (METHOD 3.3).
    """
    noise = unrounded_noise(variance_dn2, step=plane.code_step)
    return phase_effect(noise, step=plane.code_step, spread=_spread_dn(plane)) / math.sqrt(2.0)


def _spread_dn(plane: PlaneStatistics) -> float:
    """Return the spread of the pixels' levels before rounding, without hot ones [DN].

    What is rounded has the variance of noise and levels together.
    """
    step = plane.code_step
    whole, noise = (unrounded_noise(one, step=step) for one in (plane.body_variance, plane.temporal_variance))
    return math.sqrt(max(whole**2 - noise**2, 0.0))


def phase_aware_dof(plane: PlaneStatistics, variance_dn2: float, dof: float) -> float:
    """Return the degrees of freedom of a temporal variance, lowered by `rounding_error_dn2`."""
    if variance_dn2 <= 0.0:
        return dof
    phase_dn2 = rounding_error_dn2(plane, variance_dn2)
    return 2.0 * variance_dn2**2 / (2.0 * variance_dn2**2 / dof + phase_dn2**2)


def phase_aware_spatial_dof(plane: PlaneStatistics, variance_dn2: float, dof: float) -> float:
    """Return the degrees of freedom of a spatial variance, lowered by what the unknown phase makes of the pattern."""
    step = plane.code_step
    noise = unrounded_noise(plane.temporal_variance, step=step)
    if noise >= NO_EFFECT * step:
        return dof
    by_noise = phase_effect(noise, step=step, spread=_spread_dn(plane)) / plane.frames
    by_pattern = pattern_phase_effect(plane.body_spread**2, noise=noise, step=step)
    phase_dn2 = math.hypot(by_noise, by_pattern) / math.sqrt(2.0)
    least = max(variance_dn2, quantization_variance(step) / plane.frames)
    return 2.0 * least**2 / (2.0 * least**2 / dof + phase_dn2**2)


def mean_rounding_error_dn(plane: PlaneStatistics) -> float:
    """Return the standard error of a plane's mean from rounding at an unknown phase of the code [DN].

    The mean of rounded values swings about the true level with amplitude exp(-2 pi^2 s^2) / pi codes, s^2 the variance
    of what is rounded over pixels and frames, hot pixels aside; that amplitude is taken, since one phase is one draw.
    """
    step = plane.code_step
    noise = unrounded_noise(plane.body_variance, step=step) / step
    return step * math.exp(-2.0 * math.pi**2 * noise**2) / math.pi


def rounding_flags(bursts: IsoBursts, channels: Iterable[str]) -> set[str]:
    """Return ``quantization-limited`` where rounding may shift the mean of an unlit burst notably."""
    planes = [burst.plane(channel) for burst in bursts.unlit for channel in channels]
    limited = any(mean_rounding_error_dn(plane) > NOTABLE_SHIFT_DN for plane in planes)
    return {"quantization-limited"} if limited else set()
