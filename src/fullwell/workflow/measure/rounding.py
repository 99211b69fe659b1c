"""What rounding to whole codes leaves unknown of a temporal variance when the noise is small (METHOD 3.3)."""

import math
from collections.abc import Iterable

from fullwell.fit.read_noise import ReadNoise, analogue_read_noise, phase_effect, unrounded_noise
from fullwell.fit.rounded_pattern import NO_EFFECT, pattern_phase_effect
from fullwell.model.quantization import quantization_variance, rounded_variance
from fullwell.statistics.series import PlaneStatistics
from fullwell.units import DN2, Measured
from fullwell.workflow.measure.bursts import IsoBursts

NOTABLE_SHIFT_DN = 0.01


def rounding_error_dn2(plane: PlaneStatistics, variance_dn2: float) -> float:
    """Return one standard error of a temporal variance from the unknown phase of its level within a code [DN^2].

    Noise above about half the distance of two codes, or levels that differ by as much between pixels, leave nothing
    of the error; less noise may be any that some phase reconciles with the variance (METHOD 3.3).
    """
    step = plane.code_step
    found = _noise_of(plane, variance_dn2)
    if found.quantization_limited and found.noise.ci95 is not None:
        effect = max(abs(rounded_variance(end, step=step) - variance_dn2) for end in found.noise.ci95)
    else:
        noise = unrounded_noise(variance_dn2, step=step)
        effect = phase_effect(noise, step=step, spread=_spread_dn(plane))
    return effect / math.sqrt(2.0)


def only_an_interval(plane: PlaneStatistics) -> bool:
    """Tell whether the unknown phase leaves no more than an interval of the temporal noise, as of read noise."""
    return _noise_of(plane, plane.temporal_variance).quantization_limited


def _noise_of(plane: PlaneStatistics, variance_dn2: float) -> ReadNoise:
    return analogue_read_noise(
        Measured.exact(variance_dn2, DN2),
        quantization_step=plane.code_step,
        spatial_spread_dn=plane.body_spread,
        n=plane.n * plane.frames,
    )


def _spread_dn(plane: PlaneStatistics) -> float:
    """Return the spread of the pixels' levels before rounding, without hot ones [DN].

    What is rounded has the variance of noise and levels together.
    """
    step = plane.code_step
    whole, noise = (unrounded_noise(one, step=step) for one in (plane.body_variance, plane.temporal_variance))
    return math.sqrt(max(whole**2 - noise**2, 0.0))


def phase_aware_dof(plane: PlaneStatistics, variance_dn2: float, dof: float, *, sharing: int = 1) -> float:
    """Return the degrees of freedom of a temporal variance, lowered by `rounding_error_dn2`.

    Of ``sharing`` variances at one phase, which err together, each tells that share of what one alone does.
    """
    if variance_dn2 <= 0.0:
        return dof
    phase_dn2 = rounding_error_dn2(plane, variance_dn2)
    return 2.0 * variance_dn2**2 / (2.0 * variance_dn2**2 / dof + sharing * phase_dn2**2)


def phase_aware_spatial_dof(plane: PlaneStatistics, variance_dn2: float, dof: float, *, sharing: int = 1) -> float:
    """Return the degrees of freedom of a spatial variance, lowered by what the unknown phase makes of the pattern."""
    step = plane.code_step
    noise = unrounded_noise(plane.temporal_variance, step=step)
    if noise >= NO_EFFECT * step:
        return dof
    by_noise = rounding_error_dn2(plane, plane.temporal_variance) / plane.frames
    by_pattern = pattern_phase_effect(plane.body_spread**2, noise=noise, step=step) / math.sqrt(2.0)
    phase_dn2 = math.hypot(by_noise, by_pattern)
    least = max(variance_dn2, quantization_variance(step) / plane.frames)
    return 2.0 * least**2 / (2.0 * least**2 / dof + sharing * phase_dn2**2)


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
