"""Read noise, and its row and column parts, from the shortest unlit burst (METHOD 3)."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

from fullwell.figures.results import Row
from fullwell.figures.saturation import GRID_LIMITED
from fullwell.findings import Finding, Severity
from fullwell.fit.censored import fit_censored_normal, trim_hot_pixels
from fullwell.fit.legacy.read_noise import legacy_read_noise
from fullwell.fit.median_pixel import median_pixel_noise
from fullwell.fit.photon_transfer import fit_photon_transfer
from fullwell.fit.pooling import SharedErrors, mean_of_sites
from fullwell.fit.read_noise import analogue_read_noise, excess_ratio
from fullwell.fit.variance_components import temporal_variance, variance_components
from fullwell.frames.series import Kind
from fullwell.report.numbers import show_exposure
from fullwell.statistics.series import LegacyBurst, PlaneStatistics
from fullwell.units import DN, DN2, Measured
from fullwell.workflow.measure.bursts import Burst, IsoBursts
from fullwell.workflow.measure.rounding import rounding_error_dn2
from fullwell.workflow.measure.section import RowWriter, Section

READ_NOISE = "read_noise"
TOLD = 4.0
"""Standard errors that a variance extrapolated to no exposure has to be."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ChannelNoise:
    """The recommended read noise of one channel, quantization removed.

    Parameters
    ----------
    variance
        Signed, [DN^2].
    shared
        What of its standard error channels have in common.
    method, flags, source, n
        As in its row.

    """

    channel: str
    variance: Measured
    shared: SharedErrors
    method: str
    flags: tuple[str, ...]
    source: str
    n: int


def choose_burst(bursts: IsoBursts) -> Burst | None:
    """Return the burst read noise is measured on: the shortest bias burst of two frames or more, else dark burst."""
    for group in (bursts.biases, bursts.darks):
        for burst in group:
            if burst.frames > 1:
                return burst
    return None


def measure_read_noise(bursts: IsoBursts) -> Section:
    """Measure read noise, row and column noise of every channel at one ISO, in DN."""
    burst = choose_burst(bursts)
    if burst is None:
        message = (
            f"no two unlit frames of one exposure at {bursts.label}: read noise is not measured; "
            "take a burst of at least 5 bias frames (shortest exposure, no light)"
        )
        return Section(findings=(Finding(code="no-bias-frames", severity=Severity.WARNING, message=message),))
    noises: list[ChannelNoise] = []
    rows: list[Row] = []
    for plane in burst.statistics.planes:
        noise = _channel_noise(bursts, plane)
        noises.append(noise)
        rows += noise_rows(bursts, noise)
        if "black-clipped" not in noise.flags:
            rows += _tail_rows(bursts, burst, plane)
            rows += _component_rows(bursts, plane)
        rows += _legacy_rows(bursts, plane.channel, plane.legacy, noise.flags)
    rows += _whole_mosaic_rows(bursts, burst, noises)
    return Section(rows=tuple(rows), findings=_findings(bursts, burst, noises))


def _channel_noise(bursts: IsoBursts, plane: PlaneStatistics) -> ChannelNoise:
    if plane.channel in bursts.black_clipped:
        return _censored_noise(plane)
    darks = [burst.plane(plane.channel) for burst in bursts.darks if burst.frames > 1]
    mixed: tuple[str, ...] = ()
    total = total_temporal_variance(plane)
    if not any(burst.frames > 1 for burst in bursts.biases):
        exposures_s = [burst.exposure_s for burst in bursts.darks if burst.frames > 1]
        at_zero = _without_exposure(exposures_s, [total_temporal_variance(dark) for dark in darks])
        total, mixed = (at_zero, ()) if at_zero is not None else (total, ("mixed",))
    n = plane.n * plane.frames
    noise = analogue_read_noise(total, quantization_step=plane.code_step, spatial_spread_dn=plane.body_spread, n=n)
    return ChannelNoise(
        channel=plane.channel,
        variance=noise.variance,
        shared=_shared_errors(plane),
        method="temporal-variance",
        flags=(*noise.flags, *mixed),
        source="METHOD 3.1",
        n=plane.n * plane.frames,
    )


def _censored_noise(plane: PlaneStatistics) -> ChannelNoise:
    histogram = plane.histogram
    counts = trim_hot_pixels(histogram.counts)
    censored = fit_censored_normal(histogram.first_code, counts, clipped_low=True, clipped_high=False)
    sigma, error = censored.noise.value, censored.noise.std_error or math.inf
    known = error < sigma
    variance = Measured.normal(sigma**2, 2.0 * sigma * error, DN2) if known else Measured.exact(sigma**2, DN2)
    return ChannelNoise(
        channel=plane.channel,
        variance=variance,
        shared=SharedErrors(),
        method="censored-likelihood",
        flags=("black-clipped", "mixed"),
        source="METHOD 3.4",
        n=int(histogram.counts.sum()),
    )


def _shared_errors(plane: PlaneStatistics) -> SharedErrors:
    """Return the errors by noise of whole frames, rows and columns, and by the unknown phase of rounding."""
    parts = variance_components(plane.mean_squares, plane.shape)
    frames, rows, columns = plane.shape
    lines = SharedErrors.of_variances(
        frame=parts.t.value,
        row=parts.tv.value,
        column=parts.th.value,
        dof=(frames - 1, (frames - 1) * (rows - 1), (frames - 1) * (columns - 1)),
    )
    return replace(lines, rounding=(rounding_error_dn2(plane, plane.temporal_variance), None))


def total_temporal_variance(plane: PlaneStatistics) -> Measured:
    """Return the temporal variance of a plane with row, column and frame noise in its error [DN^2]."""
    return temporal_variance(plane.mean_squares, plane.shape, pixel_scatter_dn4=plane.temporal_variance_scatter)


def _without_exposure(exposures_s: Sequence[float], variances: Sequence[Measured]) -> Measured | None:
    """Extrapolate the variance of dark frames to no exposure: the shot noise of dark current grows with time.

    None where there are fewer than two exposures, nothing varies, or they lie too close together to tell.
    """
    if len(set(exposures_s)) < 2 or not all(one.value > 0.0 and one.std_error for one in variances):
        return None
    dof = [2.0 * (one.value / (one.std_error or math.inf)) ** 2 for one in variances]
    at_zero = fit_photon_transfer(exposures_s, [one.value for one in variances], dof, n=None, terms=2).intercept
    return at_zero if at_zero.value > TOLD * (at_zero.std_error or 0.0) else None


def noise_rows(bursts: IsoBursts, noise: ChannelNoise) -> tuple[Row, Row]:
    """Return the read noise of one channel and its signed variance twin."""
    return RowWriter(bursts=bursts).root_and_variance(
        READ_NOISE,
        noise.channel,
        noise.method,
        noise.variance,
        DN,
        source=noise.source,
        n=noise.n,
        flags=[flag for flag in noise.flags if flag != "upper-limit"],
    )


def _tail_rows(bursts: IsoBursts, burst: Burst, plane: PlaneStatistics) -> tuple[Row, ...]:
    """Return the noise of the median pixel, and how far the pixels scatter beyond normal noise (METHOD 3.6)."""
    typical = median_pixel_noise(
        plane.temporal_variance_median, frames=plane.frames, pixels=plane.n, quantization_step=plane.code_step
    )
    excess = excess_ratio(plane.temporal_variance_scatter, plane.temporal_variance, frames=plane.frames, pixels=plane.n)
    write = RowWriter(bursts=bursts).row
    n = plane.n * plane.frames
    flags = (*typical.flags, GRID_LIMITED, *(() if burst.kind is Kind.BIAS else ("mixed",)))
    return (
        write(READ_NOISE, plane.channel, "median-pixel", typical.noise, source="METHOD 3.6", n=n, flags=flags),
        write("read_noise_excess", plane.channel, "scatter-ratio", excess, source="METHOD 3.6", n=n, recommended=True),
    )


def _component_rows(bursts: IsoBursts, plane: PlaneStatistics) -> tuple[Row, ...]:
    components = variance_components(plane.mean_squares, plane.shape)
    write = RowWriter(bursts=bursts).root_and_variance
    n = plane.n * plane.frames
    parts = (("read_noise_row", components.tv), ("read_noise_column", components.th))
    return tuple(
        row
        for quantity, variance in parts
        for row in write(quantity, plane.channel, "anova", variance, DN, source="METHOD 3.5", n=n)
    )


def _legacy_rows(bursts: IsoBursts, channel: str, legacy: LegacyBurst | None, flags: Sequence[str]) -> tuple[Row, ...]:
    if legacy is None:
        return ()
    write = RowWriter(bursts=bursts).row
    n = legacy.n * legacy.frames
    flows = legacy_read_noise(legacy)
    own = tuple(flag for flag in flags if flag == "black-clipped")
    return (
        write(
            READ_NOISE,
            channel,
            "legacy-pair-difference",
            flows.pair_difference,
            source="PIXEL4A flow 1",
            n=n,
            flags=own,
        ),
        write(
            READ_NOISE,
            channel,
            "legacy-burst-mean",
            flows.burst_mean,
            source="PIXEL4A flow 2",
            n=n,
            flags=own,
        ),
    )


def _whole_mosaic_rows(bursts: IsoBursts, burst: Burst, noises: Sequence[ChannelNoise]) -> tuple[Row, ...]:
    """Return the sensor's read noise over all channels: the mean of the channels' variances."""
    if len(noises) < 2:
        return ()
    pooled = ChannelNoise(
        channel="all",
        variance=_mean_variance(noises),
        shared=SharedErrors(),
        method=noises[0].method,
        flags=tuple(sorted({flag for noise in noises for flag in noise.flags})),
        source=noises[0].source,
        n=sum(noise.n for noise in noises),
    )
    return (*noise_rows(bursts, pooled), *_legacy_rows(bursts, "all", burst.statistics.legacy, pooled.flags))


def _mean_variance(noises: Sequence[ChannelNoise]) -> Measured:
    """Return the mean of the channels' variances [DN^2]."""
    variances = [noise.variance for noise in noises]
    pooled = mean_of_sites(variances, [noise.shared for noise in noises])
    if not any("quantization-limited" in noise.flags for noise in noises):
        return pooled
    ends = [one.ci95 or (one.value, one.value) for one in variances]
    low, high = (sum(end[side] for end in ends) / len(ends) for side in (0, 1))
    error = sum(one.std_error or 0.0 for one in variances) / len(variances)
    return Measured.interval(pooled.value, error, (low, high), DN2)


def _findings(bursts: IsoBursts, burst: Burst, noises: Sequence[ChannelNoise]) -> tuple[Finding, ...]:
    mixed = [noise.channel for noise in noises if "mixed" in noise.flags and "black-clipped" not in noise.flags]
    if not mixed:
        return ()
    message = (
        f"no bias frames at {bursts.label}: read noise of {', '.join(mixed)} comes from dark frames of "
        f"{show_exposure(burst.exposure_s)} and includes the shot noise of their dark current; "
        "take a burst of bias frames"
    )
    return (Finding(code="read-noise-mixed", severity=Severity.WARNING, message=message),)
