"""Saturation, signal-to-noise ratio and dynamic range of the sensor, from the patches of a chart (METHOD 7)."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fullwell.figures.camera_dynamic_range import QUALITY_DECIBELS
from fullwell.figures.conversions import to_electrons
from fullwell.figures.results import Row
from fullwell.figures.saturation import (
    ADC_LIMITED,
    LOWER_BOUND,
    SaturationLevel,
    last_consistent_level,
    plateau,
    temporal_variance_peak,
)
from fullwell.findings import Finding, Severity
from fullwell.fit.gamma_likelihood import signed_deviance
from fullwell.fit.legacy.chart import legacy_max_noise_patch, legacy_patch_range
from fullwell.raw.cfa import ALL
from fullwell.statistics.chart import MAX_CLIPPED, PatchPoint
from fullwell.units import DN_PER_ELECTRON, ELECTRON, Measured
from fullwell.workflow.measure.chart.levels import ChartLevels
from fullwell.workflow.measure.chart.noise_model import ChartModel
from fullwell.workflow.measure.chart.shots import Shots
from fullwell.workflow.measure.dynamic_range import NoiseModel, ratio_rows
from fullwell.workflow.measure.section import RowWriter, Section

THRESHOLDS = tuple(10.0 ** (decibel / 20.0) for decibel in QUALITY_DECIBELS)
"""Signal-to-noise ratios that dynamic range is told for [1]."""
TURNED = 5.0
"""Standard errors by which the variance must fall for saturation to be reached."""
PEAK = "temporal-variance-peak"
LAST = "last-consistent-level"


@dataclass(frozen=True, slots=True, kw_only=True)
class ChannelRange:
    """Where a channel, or all together, saturates.

    Parameters
    ----------
    channel
        Its name, or ``all``.
    peak
        METHOD 7 (a): largest variance between frames, of single frames where there are no bursts.
    top, last
        METHOD 7 (b) and (c); None where the patches do not tell.

    """

    channel: str
    peak: SaturationLevel
    top: SaturationLevel | None
    last: SaturationLevel | None


def measure_ranges(
    shots: Shots, levels: ChartLevels, models: Sequence[ChartModel]
) -> tuple[Section, tuple[ChannelRange, ...]]:
    """Measure saturation, SNR and dynamic range of every channel, and of all as one sensor."""
    rows: list[Row] = []
    ranges: list[ChannelRange] = []
    for model in models:
        if model.coefficients[1] <= 0.0:
            continue
        points = _points(shots, model.channel)
        signal = _signals(points, levels, model.channel)
        found = _saturation(shots, levels, model, points, signal)
        ranges.append(found)
        rows += _saturation_rows(shots, model, found)
        noise = NoiseModel(coefficients=model.coefficients, covariance=model.covariance, dof=model.fit.dof)
        rows += ratio_rows(shots.bursts, model.channel, noise, found.peak, thresholds=THRESHOLDS)
        rows += _legacy_rows(shots, model, found.peak, points, signal)
    return Section(rows=tuple(rows), findings=_findings(shots, ranges)), tuple(ranges)


def _points(shots: Shots, channel: str) -> tuple[PatchPoint, ...]:
    chosen = shots.channels if channel == ALL else (channel,)
    return tuple(point for one in chosen for point in shots.points(one) if point.dof > 0)


def _signals(points: Sequence[PatchPoint], levels: ChartLevels, channel: str) -> NDArray[np.float64]:
    """Return signals above the level that the channel's model counts from [DN]."""
    if channel != ALL or levels.alike:
        return np.array([point.mean_dn for point in points]) - levels.of(channel).level.value
    return np.array([point.mean_dn - levels.of(point.channel).level.value for point in points])


def noise_of(shots: Shots, point: PatchPoint) -> float:
    """Return a patch's temporal variance where there are bursts, that of a single frame where not [DN^2]."""
    return point.temporal_variance_dn2 if shots.has_bursts and point.frames > 1 else point.variance_dn2


def _saturation(
    shots: Shots,
    levels: ChartLevels,
    model: ChartModel,
    points: Sequence[PatchPoint],
    signal: NDArray[np.float64],
) -> ChannelRange:
    clipped = np.array([point.clipped_high for point in points])
    variance = np.array([noise_of(shots, point) for point in points])
    order = np.argsort(signal, kind="stable")
    error = np.array([(point.variance_dn2 / (point.n * point.frames)) ** 0.5 for point in points])
    dof = np.array([point.dof for point in points])
    if _turns(variance[order], dof[order], clipped[order]):
        doubt = np.hypot(error, levels.of(model.channel).error_dn)
        peak = temporal_variance_peak(signal, variance, clipped, std_error_dn=doubt)
    else:
        peak = temporal_variance_peak(signal[order[-1:]], variance[order[-1:]], clipped[order[-1:]])
    top = plateau(signal[order], clipped[order], error[order]) if clipped[order[-1]] > ADC_LIMITED else None
    total = np.array([point.variance_dn2 for point in points])
    expected = np.polynomial.polynomial.polyval(signal, model.coefficients)
    residual = signed_deviance(total, np.maximum(expected, np.finfo(np.float64).tiny), dof)
    bright = signal > 0.5 * float(signal.max())
    last = last_consistent_level(signal[bright], residual[bright])
    return ChannelRange(channel=model.channel, peak=peak, top=top, last=last)


def _turns(variance: NDArray[np.float64], dof: NDArray[np.float64], clipped: NDArray[np.float64]) -> bool:
    """Tell whether the variance falls beyond chance after its peak, points by ascending signal."""
    peak = int(np.argmax(variance))
    after = slice(peak + 1, None)
    doubt = np.sqrt(2.0 * (variance[peak] ** 2 / dof[peak] + variance[after] ** 2 / dof[after]))
    falls = variance[peak] - variance[after] > TURNED * doubt
    return bool(np.any(falls | (clipped[after] > MAX_CLIPPED)))


def _saturation_rows(shots: Shots, model: ChartModel, found: ChannelRange) -> tuple[Row, ...]:
    write = RowWriter(bursts=shots.bursts).row
    mixed = () if shots.has_bursts else ("mixed",)
    system_gain = Measured.student(
        float(model.coefficients[1]), float(model.covariance[1, 1]) ** 0.5, model.fit.dof, DN_PER_ELECTRON
    )
    levels = (
        (PEAK, found.peak, "METHOD 7 (a)", mixed),
        ("plateau", found.top, "METHOD 7 (b)", ()),
        (LAST, found.last, "METHOD 7 (c)", ()),
    )
    return tuple(
        write(
            "saturation_capacity",
            model.channel,
            method,
            measured,
            source=source,
            flags=(*level.flags, *extra),
            recommended=method == PEAK,
        )
        for method, level, source, extra in levels
        if level is not None
        for measured in (level.signal, _in_electrons(level.signal, system_gain))
    )


def _in_electrons(signal: Measured, system_gain: Measured) -> Measured:
    if signal.std_error is None:
        return signal.scaled(1.0 / system_gain.value, ELECTRON)
    return to_electrons(signal, system_gain)


def _legacy_rows(
    shots: Shots,
    model: ChartModel,
    peak: SaturationLevel,
    points: Sequence[PatchPoint],
    signal: NDArray[np.float64],
) -> tuple[Row, ...]:
    """Return saturation and dynamic range as the published page reads them off the patches of the nominal exposure.

    The largest noise is on a patch before the last by chance, or as another channel's, where nothing saturates: bounds.
    """
    nominal = {id(point) for scene in shots.scenes for point in scene.brightest.points}
    chosen = [index for index, point in enumerate(points) if id(point) in nominal]
    variance = np.array([points[index].variance_dn2 for index in chosen])
    densities = [points[index].density for index in chosen]
    write = RowWriter(bursts=shots.bursts).row
    saturation = legacy_max_noise_patch(signal[chosen], variance, system_gain=float(model.coefficients[1]))
    rows = [
        write(
            "saturation_capacity",
            model.channel,
            "legacy-max-noise-patch",
            measured,
            source="METHOD 7",
            flags=_bound(peak, saturation.flags),
        )
        for measured in (saturation.signal, saturation.electrons)
    ]
    known = [np.nan if density is None else density for density in densities]
    usable = np.isfinite(known).sum() > 2
    for threshold in THRESHOLDS:
        reach = legacy_patch_range(signal[chosen], variance, known if usable else None, snr=threshold)
        if reach is not None:
            rows += [
                write(
                    "dynamic_range",
                    model.channel,
                    "legacy-patch",
                    measured,
                    source="METHOD 8",
                    snr_threshold=threshold,
                    flags=_bound(peak, reach.flags),
                )
                for measured in (reach.decibel, reach.stops)
            ]
    return tuple(rows)


def _bound(peak: SaturationLevel, flags: tuple[str, ...]) -> tuple[str, ...]:
    return (LOWER_BOUND,) if LOWER_BOUND in peak.flags else flags


def _findings(shots: Shots, ranges: Iterable[ChannelRange]) -> tuple[Finding, ...]:
    short = [one.channel for one in ranges if LOWER_BOUND in one.peak.flags]
    if not short:
        return ()
    message = (
        f"the patches of {', '.join(short)} at {shots.bursts.label} do not reach saturation: saturation capacity, "
        "maximum SNR and dynamic range are lower bounds; expose so that the lightest patch just clips"
    )
    return (Finding(code="saturation-not-reached", severity=Severity.WARNING, message=message),)
