"""What the lens adds: stray light, and the dynamic range of the whole camera (METHOD 2.2, 7)."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np

from fullwell.figures.camera_dynamic_range import (
    camera_dynamic_range,
    iso15739_like,
    patch_nearest,
    patch_variance,
)
from fullwell.figures.ratios import Ratio
from fullwell.figures.results import Row
from fullwell.figures.tonal_response import tonal_response
from fullwell.findings import Finding, Severity
from fullwell.fit.flare import FlareFit, fit_flare
from fullwell.fit.pooling import mean_sharing_errors, pool_channels
from fullwell.raw.cfa import ALL
from fullwell.statistics.chart import PatchPoint
from fullwell.units import DN, Measured
from fullwell.workflow.measure.chart.levels import BlackLevel, ChartLevels
from fullwell.workflow.measure.chart.line_noise import LineNoise
from fullwell.workflow.measure.chart.noise_model import ChartModel
from fullwell.workflow.measure.chart.ranges import THRESHOLDS, ChannelRange, noise_of
from fullwell.workflow.measure.chart.shots import Scene, Shots
from fullwell.workflow.measure.section import RowWriter, Section

DOCUMENTED_DENSITY = 2.0
"""Density of the patch that the published page takes for black."""
SPREAD = 0.5
"""Density range of a chart from where on stray light shows."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ChannelFlare:
    """Stray light of one channel, or of all as the mean of the channels.

    ``without_dark`` tells whether dark current has been taken off; ``stray_dn`` is the flare of one channel in DN.
    """

    channel: str
    flare: Measured
    at_offset: Measured
    without_dark: bool
    stray_dn: float = math.nan


def measure_camera(
    shots: Shots,
    levels: ChartLevels,
    models: Sequence[ChartModel],
    ranges: Sequence[ChannelRange],
    *,
    lines: LineNoise,
    dark_current: Mapping[str, Measured],
) -> Section:
    """Measure stray light where densities and an identified black level allow, and what it costs.

    Parameters
    ----------
    shots, levels, models, ranges
        What was measured before.
    lines
        Noise of rows and columns, which patches share.
    dark_current
        By channel, where dark frames told it [DN/s].

    """
    flares = _flares(shots, levels, lines, dark_current)
    rows: list[Row] = [
        RowWriter(bursts=shots.bursts).row(
            "flare", one.channel, "density-fit", one.flare, source="METHOD 2.2", recommended=True
        )
        for one in flares
    ]
    by_channel = {one.channel: one for one in flares}
    for model in models:
        found = next((one for one in ranges if one.channel == model.channel), None)
        if found is None:
            continue
        flare = by_channel.get(model.channel)
        if flare is not None:
            rows += _camera_rows(shots, model, found, flare)
        rows += _black_patch_rows(shots, model, found, flare)
    return Section(rows=tuple(rows), findings=_findings(shots, levels, flares))


def known_densities(shots: Shots) -> bool:
    """Tell whether the patches have densities enough for stray light and tonal response."""
    known = [patch.density for scene in shots.scenes for patch in scene.patches if patch.density is not None]
    return len(set(known)) >= 3 and max(known) - min(known) >= SPREAD


def _flares(
    shots: Shots, levels: ChartLevels, lines: LineNoise, dark_current: Mapping[str, Measured]
) -> tuple[ChannelFlare, ...]:
    scene = next((scene for scene in shots.scenes if len(scene.patches) > 2), None)
    if scene is None or not known_densities(shots):
        return ()
    seconds = scene.brightest.exposure_s or 0.0
    known = seconds > 0.0 and dark_current.keys() >= set(shots.channels)
    fits: list[FlareFit] = []
    for channel in shots.channels:
        dark = dark_current[channel].scaled(seconds, DN) if known else Measured.exact(0.0, DN)
        fit = _flare(scene, levels.of(channel), lines, cfa=shots.cfa, dark=dark)
        if fit is None:
            return ()
        fits.append(fit)
    found = [
        ChannelFlare(
            channel=channel,
            flare=fit.flare,
            at_offset=fit.flare_at_offset,
            without_dark=known,
            stray_dn=fit.flare.value * fit.response.value,
        )
        for channel, fit in zip(shots.channels, fits, strict=True)
    ]
    if len(found) > 1:
        alike = any(fit.density_scatter > 0.0 for fit in fits)
        flare, at_offset = (
            _together(part, alike=alike) for part in ([one.flare for one in found], [one.at_offset for one in found])
        )
        found.append(ChannelFlare(channel=ALL, flare=flare, at_offset=at_offset, without_dark=known))
    return tuple(found)


def _together(flares: Sequence[Measured], *, alike: bool) -> Measured:
    """Return the flare of all channels; where patches differ from their densities they all err alike."""
    if not alike:
        return pool_channels(flares)[0]
    mean = mean_sharing_errors(flares)
    known = [one.dof for one in flares if one.dof is not None]
    return Measured.student(mean.value, mean.std_error or 0.0, min(known, default=None), mean.unit)


def _flare(scene: Scene, black: BlackLevel, lines: LineNoise, *, cfa: str, dark: Measured) -> FlareFit | None:
    places = {patch.name: (patch.x + patch.width / 2, patch.y + patch.height / 2) for patch in scene.patches}
    points = [point for point in scene.brightest.of(black.channel) if point.density is not None]
    if not points:
        return None
    by_line = lines.of_means([points], scene.patches, cfa=cfa)[0, :, 0]
    try:
        return fit_flare(
            [point.mean_dn - black.level.value if point.admitted else math.nan for point in points],
            np.sqrt([point.variance_dn2 / (point.n * point.frames) for point in points] + np.diagonal(by_line)),
            [math.nan if point.density is None else point.density for point in points],
            offset_std_error_dn=black.error_dn,
            identified=black.identified,
            dark_signal_dn=dark.value,
            dark_signal_std_error_dn=dark.std_error or 0.0,
            places=[places[point.patch] for point in points],
            covariance_dn2=by_line - np.diag(np.diagonal(by_line)),
        )
    except ValueError:
        return None


def _camera_rows(shots: Shots, model: ChartModel, found: ChannelRange, flare: ChannelFlare) -> tuple[Row, ...]:
    def at(signal: Measured, threshold: float) -> Ratio:
        return camera_dynamic_range(
            model.coefficients, model.covariance, signal, flare.at_offset, snr=threshold, dof=model.fit.dof
        ).range

    rows: list[Row] = []
    for threshold in THRESHOLDS:
        try:
            reach = found.peak.through(partial(at, threshold=threshold))
        except ValueError:
            continue
        rows += [
            RowWriter(bursts=shots.bursts).row(
                "camera_dynamic_range",
                model.channel,
                "scene-referenced",
                measured,
                source="METHOD 7",
                snr_threshold=threshold,
                flags=found.peak.bound_flags,
                recommended=True,
            )
            for measured in (reach.decibel, reach.stops)
        ]
    return tuple(rows)


def _black_patch_rows(
    shots: Shots, model: ChartModel, found: ChannelRange, flare: ChannelFlare | None
) -> tuple[Row, ...]:
    """Return the clipping level over the noise of the darkest patch, and over that of the patch nearest density 2."""
    channels = shots.channels if model.channel == ALL else (model.channel,)
    exposure = shots.scenes[0].brightest
    points = [point for channel in channels for point in exposure.of(channel) if point.admitted]
    if not points:
        return ()
    chosen: list[tuple[PatchPoint, str | None]] = [(min(points, key=lambda point: point.mean_dn), None)]
    densities = [math.nan if point.density is None else point.density for point in points]
    if known_densities(shots) and max(d for d in densities if d == d) >= DOCUMENTED_DENSITY:  # noqa: PLR0124 - NaN
        nearest = points[patch_nearest(densities, DOCUMENTED_DENSITY)]
        chosen.append((nearest, f"patch:{nearest.patch}"))
    stray = 0.0 if flare is None else max(flare.at_offset.value, 0.0)

    def at(signal: Measured, variance: Measured) -> Ratio:
        return iso15739_like(signal, variance, flare_dn=stray * signal.value)

    rows: list[Row] = []
    for point, region in chosen:
        dof = point.temporal_dof if shots.has_bursts and point.frames > 1 else point.dof
        try:
            reach = found.peak.through(partial(at, variance=patch_variance(noise_of(shots, point), dof)))
        except ValueError:
            continue
        flags = {*found.peak.bound_flags, *(() if shots.has_bursts else ("mixed",))}
        rows += [
            RowWriter(bursts=shots.bursts).row(
                "camera_dynamic_range",
                model.channel,
                "iso15739-like",
                measured,
                source="METHOD 7",
                n=point.n * point.frames,
                region=region,
                flags=flags,
                recommended=region is None,
            )
            for measured in (reach.decibel, reach.stops)
        ]
    return tuple(rows)


def _findings(shots: Shots, levels: ChartLevels, flares: Sequence[ChannelFlare]) -> tuple[Finding, ...]:
    if not known_densities(shots):
        return ()
    if not levels.shared.identified:
        message = (
            "stray light and black level add to every patch alike: with a black level that nothing identifies, neither "
            "flare nor the camera's dynamic range is measured"
        )
        return (Finding(code="flare-not-identified", severity=Severity.INFO, message=message),)
    seen = [one for one in flares if one.flare.ci95 is not None and one.flare.ci95[0] > 0.0]
    darkest = _stray_share(shots, levels, flares)
    if not seen or darkest is None:
        return ()
    dark = "taken off" if seen[-1].without_dark else "included"
    message = (
        f"stray light is seen in the dark patches: {100.0 * seen[-1].flare.value:.3g} % of the lightest patch, "
        f"{100.0 * darkest:.0f} % of the signal of the darkest one, dark current of the exposure {dark}; "
        "shoot in a dark room, mask everything around the chart, and keep lights and white surfaces out of the lens"
    )
    severity = Severity.WARNING if darkest > 0.5 else Severity.INFO
    return (Finding(code="stray-light", severity=severity, message=message),)


def _stray_share(shots: Shots, levels: ChartLevels, flares: Sequence[ChannelFlare]) -> float | None:
    """Return how much of the darkest patch's signal is stray light, at most 1."""
    if not flares:
        return None
    channel = flares[0].channel
    points = [point for point in shots.scenes[0].brightest.of(channel) if point.admitted and point.density is not None]
    if not points:
        return None
    signals = np.array([point.mean_dn for point in points]) - levels.of(channel).level.value
    darkest = float(signals.min())
    return min(flares[0].stray_dn / darkest, 1.0) if darkest > 0.0 else 1.0


def tonal_points(shots: Shots, levels: ChartLevels, channel: str) -> tuple[tuple[str, float, float, float, float], ...]:
    """Return patch, log exposure, log pixel value with and without offset, and slope of one channel's patches."""
    if not known_densities(shots):
        return ()
    points = shots.scenes[0].brightest.of(channel)
    found = tonal_response(
        [point.mean_dn for point in points],
        [math.nan if point.density is None else point.density for point in points],
        offset_dn=levels.of(channel).level.value,
        white_dn=levels.digital_maximum,
    )
    columns = (found.log_exposure, found.log_pixel, found.log_signal, found.slope)
    return tuple(
        (points[int(index)].patch, float(exposure), float(pixel), float(signal), float(slope))
        for index, exposure, pixel, signal, slope in zip(found.patch, *columns, strict=True)
    )
