"""The mean of unlit frames against exposure: its intercept is the black level, its slope the dark current."""

import math
from collections.abc import Sequence
from dataclasses import replace

from fullwell.fit.dark import DarkLine, fit_dark_line
from fullwell.fit.variance_components import grand_mean_variance
from fullwell.frames.series import Kind
from fullwell.statistics.series import PlaneStatistics
from fullwell.units import DN, DN2, Measured, combined_dof
from fullwell.workflow.measure.bursts import Burst
from fullwell.workflow.measure.rounding import mean_rounding_error_dn


def dark_frames_level(bursts: Sequence[Burst], channels: Sequence[str]) -> Measured | None:
    """Return the mean dark signal extrapolated to no exposure (METHOD 2.3 ii), fixed pattern included in its error.

    The intercept of the line through burst means, where there are two exposures or more, or the mean of the bias
    frames. None without unlit frames, and where dark frames of one exposure cannot tell level from dark signal.
    Several channels are averaged burst by burst before the line is fitted, so that what they share (frame offsets)
    stays in the error.
    """
    line = mean_dark_line(bursts, channels)
    if line is not None:
        return _with_fixed_pattern(line.intercept, bursts[0], channels)
    biases = [burst for burst in bursts if burst.kind is Kind.BIAS]
    return single_burst_level(biases[0], channels) if biases else None


def single_burst_level(burst: Burst, channels: Sequence[str]) -> Measured:
    """Return the mean of one burst, its dark signal included [DN]."""
    planes = [burst.plane(channel) for channel in channels]
    totals = [_mean_variances(plane)[0] for plane in planes]
    variance_dn2 = sum(one.value for one in totals) / len(totals) ** 2 + _rounding_variance_dn2(planes)
    dof = min((one.dof for one in totals if one.dof is not None), default=None)
    return Measured.student(sum(plane.mean for plane in planes) / len(planes), math.sqrt(variance_dn2), dof, DN)


def mean_dark_line(bursts: Sequence[Burst], channels: Sequence[str]) -> DarkLine | None:
    """Fit the line through burst means against exposure, channels averaged burst by burst (METHOD 4.1).

    Weights are those of white pixel noise: frames over temporal variance. Two exposures leave no scatter about the
    line; the error then comes from the scatter of the frames. Where the noise is so small that rounding at an
    unknown phase shifts a mean, that shift is an error of each burst. None for fewer than two exposures.
    """
    exposures = [burst.exposure_s for burst in bursts]
    if len(set(exposures)) < 2:
        return None
    planes = [[burst.plane(channel) for channel in channels] for burst in bursts]
    variances = [sum(_mean_variances(plane)[1].value for plane in group) / len(group) ** 2 for group in planes]
    line = fit_dark_line(
        exposures,
        [sum(plane.mean for plane in group) / len(group) for group in planes],
        weights=[sum(_white_weight(plane) for plane in group) for group in planes],
        mean_std_error_dn=[math.sqrt(variance) for variance in variances],
        mean_dof=[max(burst.frames - 1, 1) for burst in bursts],
    )
    rounding_dn2 = max(_rounding_variance_dn2(group) for group in planes)
    mean_s = sum(exposures) / len(exposures)
    spread_s2 = sum((exposure - mean_s) ** 2 for exposure in exposures)
    return replace(
        line,
        slope=_widened(line.slope, rounding_dn2 / spread_s2),
        intercept=_widened(line.intercept, rounding_dn2 * (1.0 / len(exposures) + mean_s**2 / spread_s2)),
    )


def _with_fixed_pattern(level: Measured, burst: Burst, channels: Sequence[str]) -> Measured:
    """Add to a temporal error what the finite number of pixels leaves open [DN]."""
    spread = [_mean_variances(burst.plane(channel)) for channel in channels]
    fixed_dn2 = sum(max(total.value - temporal.value, 0.0) for total, temporal in spread) / len(spread) ** 2
    return _widened(level, fixed_dn2 if burst.frames > 1 else 0.0)


def _widened(measured: Measured, variance: float) -> Measured:
    """Add an independent, well known variance to an error, its degrees of freedom combined."""
    if variance == 0.0 or measured.std_error is None:
        return measured
    dof = combined_dof((measured.std_error, measured.dof), (math.sqrt(variance), None))
    return Measured.student(measured.value, math.sqrt(measured.std_error**2 + variance), dof, measured.unit)


def _mean_variances(plane: PlaneStatistics) -> tuple[Measured, Measured]:
    """Return the variance of the plane's mean with and without its fixed pattern [DN^2]."""
    if plane.frames < 2:
        single = Measured.exact(plane.spatial_variance / plane.n, DN2)
        return single, single
    variances = grand_mean_variance(plane.mean_squares, plane.shape)
    total, temporal = variances.total, variances.temporal
    return replace(total, value=max(total.value, temporal.value)), temporal


def _rounding_variance_dn2(planes: Sequence[PlaneStatistics]) -> float:
    """Return the variance of a mean over channels from rounding at a phase that they may share [DN^2]."""
    return max(mean_rounding_error_dn(plane) for plane in planes) ** 2


def _white_weight(plane: PlaneStatistics) -> float:
    return plane.frames / plane.temporal_variance if plane.temporal_variance > 0.0 else float(plane.frames)
