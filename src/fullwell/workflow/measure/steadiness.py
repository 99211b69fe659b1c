"""Do the frames keep still? Drift over a series, and exposures that do not follow the others."""

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.special import stdtr

from fullwell.figures.results import Column, Curve
from fullwell.findings import Finding, Severity
from fullwell.report.numbers import show_exposure, show_signed
from fullwell.units import DN, PERCENT, Measured
from fullwell.workflow.measure.bursts import Burst, IsoBursts
from fullwell.workflow.measure.levels import ChannelLevels
from fullwell.workflow.measure.photon_transfer import ChannelTransfer
from fullwell.workflow.measure.section import Section
from fullwell.workflow.measure.transfer_points import TransferPoint

DRIFT_SIGNIFICANCE = 1e-4
SMALLEST_DEVIATION = 0.005
NOTABLE_FLICKER = 0.01
"""Relative spread of frame means: its square is then 3 % of the variance of 300 electrons."""


def measure_steadiness(
    bursts: IsoBursts, levels: Sequence[ChannelLevels], transfers: Sequence[ChannelTransfer]
) -> Section:
    """Look for drift within every series, and for exposures off the line of the longer ones."""
    every = (*bursts.unlit, *bursts.flats)
    drifting = [name for name, group in _groups(bursts).items() if _drifts(group)]
    findings: list[Finding] = []
    if drifting:
        message = (
            f"the frame means of the {' and '.join(drifting)} series at {bursts.label} drift within the series: let "
            "camera and light settle before a burst; black level and dark current of drifting frames are not reliable"
        )
        findings.append(Finding(code="drift", severity=Severity.WARNING, message=message))
    findings += _flicker_findings(bursts)
    known = [(one, level.black) for level, one in zip(levels, transfers, strict=True) if level.black is not None]
    findings += _exposure_findings(bursts, known)
    curves = [_frame_means(bursts, every)] if every else []
    curves += [_response(bursts, transfer) for transfer, _ in known if _lit(bursts, transfer)]
    return Section(findings=tuple(findings), curves=tuple(curves))


def _flicker_findings(bursts: IsoBursts) -> tuple[Finding, ...]:
    """Return what is to be said of a lamp whose light changes from frame to frame."""
    spreads = {
        burst.exposure_s: float(means.std(ddof=1) / means.mean())
        for burst in bursts.flats
        if burst.frames > 1
        and (means := np.mean([plane.frame_means for plane in burst.statistics.planes], axis=0)).mean() > 0.0
    }
    worst = max(spreads, key=lambda exposure_s: spreads[exposure_s], default=None)
    if worst is None or spreads[worst] < NOTABLE_FLICKER:
        return ()
    message = (
        f"the light of the flats at {bursts.label} changes from frame to frame, by {100.0 * spreads[worst]:.2g} % at "
        f"{worst:g} s: where the lens shades, that looks like temporal noise, and the system "
        "gain may be off; use a lamp on direct current, or exposures of many of its periods"
    )
    return (Finding(code="flat-flicker", severity=Severity.WARNING, message=message),)


def _groups(bursts: IsoBursts) -> dict[str, list[NDArray[np.float64]]]:
    """Return the frame means of every series of three frames or more, by kind, relative to the mean for flats."""
    groups = {"bias": bursts.biases, "dark": bursts.darks, "flat": bursts.flats}
    found: dict[str, list[NDArray[np.float64]]] = {}
    for name, group in groups.items():
        for burst in group:
            if burst.frames > 2:
                means = np.mean([plane.frame_means for plane in burst.statistics.planes], axis=0)
                found.setdefault(name, []).append(means / means.mean() if name == "flat" else means)
    return found


def _drifts(group: Sequence[NDArray[np.float64]]) -> bool:
    """Test the slope of frame means over the frame index, common to the series of one kind, two-sided."""
    product = spread = scatter = 0.0
    dof = 0
    for means in group:
        index = np.arange(len(means)) - (len(means) - 1) / 2.0
        own = float((index * means).sum() / (index**2).sum())
        product += float((index * means).sum())
        spread += float((index**2).sum())
        scatter += float(((means - means.mean() - own * index) ** 2).sum())
        dof += len(means) - 2
    slope = product / spread
    if scatter == 0.0:
        return slope != 0.0
    return bool(2.0 * stdtr(dof, -abs(slope) / math.sqrt(scatter / dof / spread)) < DRIFT_SIGNIFICANCE)


def _lit(bursts: IsoBursts, transfer: ChannelTransfer) -> list[TransferPoint]:
    return [
        point
        for point, on_curve in zip(transfer.points, transfer.on_curve, strict=True)
        if (on_curve or point.burst.frames < 2)
        and point.burst in bursts.flats
        and point.burst.exposure_s > 0.0
        and point.clipped_fraction == 0.0
    ]


def deviations(points: Sequence[TransferPoint], *, black_error_dn: float = 0.0) -> list[tuple[float, float]]:
    """Return how far each point lies off the proportion of signal to exposure, and one standard error of that.

    The proportion is the median over the longer half of the exposures. The error is what the scatter of frame means
    leaves of the point and of those that make the median, and what the error of the black level does to both [DN].
    """
    signals = np.array([point.plane_signal_dn for point in points])
    exposures_s = np.array([point.burst.exposure_s for point in points])
    rates = signals / exposures_s
    longer = np.argsort(exposures_s, kind="stable")[len(points) // 2 :]
    ordered = longer[np.argsort(rates[longer], kind="stable")]
    middle = ordered[(ordered.size - 1) // 2 : ordered.size // 2 + 1]
    share = np.where(np.isin(np.arange(len(points)), middle), 1.0 / middle.size, 0.0)
    reference = float(share @ rates)
    known = [point.burst.plane(point.channel).mean_std_error for point in points]
    errors_dn = np.array([error or 0.0 for error in known])
    found: list[tuple[float, float]] = []
    for index, rate in enumerate(rates):
        by_signal = -share * rate / reference
        by_signal[index] += 1.0
        by_signal /= reference * exposures_s
        error = math.hypot(*(by_signal * errors_dn), black_error_dn * float(by_signal.sum()))
        found.append((float(rate) / reference - 1.0, math.inf if known[index] is None else error))
    return found


def _exposure_findings(bursts: IsoBursts, known: Sequence[tuple[ChannelTransfer, Measured]]) -> tuple[Finding, ...]:
    lights = {(burst.exposure_s, burst.series.photons) for burst in bursts.flats}
    if len(lights) > len({exposure_s for exposure_s, _photons in lights}):
        return ()  # the light was varied, not the time
    said: dict[float, float] = {}
    for transfer, black in known:
        points = [point for point in _lit(bursts, transfer) if point.plane_signal_dn > 0.0]
        if len(points) < 3:
            continue
        off = deviations(points, black_error_dn=black.std_error or 0.0)
        for point, (deviation, error) in zip(points, off, strict=True):
            if abs(deviation) > max(SMALLEST_DEVIATION, 4.0 * error):
                worst = said.get(point.burst.exposure_s, 0.0)
                said[point.burst.exposure_s] = max(deviation, worst, key=abs)
    if not said:
        return ()
    named = ", ".join(
        f"{show_exposure(exposure_s)} {show_signed(100.0 * deviation)} %"
        for exposure_s, deviation in sorted(said.items())
    )
    message = (
        f"signal is not proportional to exposure at {bursts.label}: {named} against the median of the longer half; "
        "the exposure times, the light, the response or the black level are not what they seem"
    )
    return (Finding(code="exposure-deviates", severity=Severity.WARNING, message=message),)


def _frame_means(bursts: IsoBursts, every: Sequence[Burst]) -> Curve:
    rows = [
        (burst.kind.value, burst.exposure_s, plane.channel, index, float(mean))
        for burst in every
        for plane in burst.statistics.planes
        for index, mean in enumerate(plane.frame_means)
    ]
    kinds, exposures, channels, indices, means = zip(*rows, strict=True)
    return Curve(
        name="frame_means",
        columns=(
            Column(name="kind", unit="", values=kinds),
            Column(name="iso", unit="1", values=(bursts.iso,) * len(rows)),
            Column(name="exposure_s", unit="s", values=exposures),
            Column(name="channel", unit="", values=channels),
            Column(name="frame", unit="1", values=indices),
            Column(name="mean", unit=DN, values=means),
        ),
    )


def _response(bursts: IsoBursts, transfer: ChannelTransfer) -> Curve:
    points = _lit(bursts, transfer)
    off = [deviation for deviation, _ in deviations(points)]
    signals = tuple(point.plane_signal_dn for point in points)
    return Curve(
        name="exposure_response",
        columns=(
            Column(name="iso", unit="1", values=(bursts.iso,) * len(points)),
            Column(name="channel", unit="", values=(transfer.channel,) * len(points)),
            Column(name="exposure_s", unit="s", values=tuple(point.burst.exposure_s for point in points)),
            Column(name="photons", unit="p", values=tuple(point.burst.series.photons for point in points)),
            Column(name="signal", unit=DN, values=signals),
            Column(
                name="fitted",
                unit=DN,
                values=tuple(signal / (1.0 + one) for signal, one in zip(signals, off, strict=True)),
            ),
            Column(name="deviation", unit=PERCENT, values=tuple(100.0 * one for one in off)),
        ),
    )
