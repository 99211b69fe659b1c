"""Saturation capacity, signal-to-noise ratio and dynamic range per ISO, from the flats alone (METHOD 7)."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fullwell.figures.conversions import to_electrons
from fullwell.figures.dynamic_range import dynamic_range
from fullwell.figures.ratios import Ratio
from fullwell.figures.results import Column, Curve, Row
from fullwell.figures.saturation import LOWER_BOUND, SaturationLevel, plateau, temporal_variance_peak
from fullwell.figures.snr import SnrMaximum, snr_curve, snr_maximum
from fullwell.findings import Finding, Severity
from fullwell.glossary import SNR_THRESHOLDS
from fullwell.units import DN, ELECTRON, ONE, Measured
from fullwell.workflow.measure.bursts import IsoBursts
from fullwell.workflow.measure.levels import ChannelLevels
from fullwell.workflow.measure.noise_coefficients import ChannelModel
from fullwell.workflow.measure.photon_transfer import ChannelTransfer
from fullwell.workflow.measure.section import RowWriter, Section
from fullwell.workflow.measure.transfer_points import TransferPoint, clipped_share

CURVE_POINTS = 48


@dataclass(frozen=True, slots=True, kw_only=True)
class NoiseModel:
    """A, B, C of a single frame with their covariance, from the three-term model or else the straight line."""

    coefficients: NDArray[np.float64]
    covariance: NDArray[np.float64]
    dof: float | None
    flags: tuple[str, ...] = ()


def measure_range(
    bursts: IsoBursts,
    levels: Sequence[ChannelLevels],
    transfers: Sequence[ChannelTransfer],
    models: Sequence[ChannelModel],
) -> Section:
    """Measure saturation, SNR and dynamic range of every channel whose system gain and black level are known."""
    rows: list[Row] = []
    curves: list[Curve] = []
    short: list[str] = []
    for level, transfer in zip(levels, transfers, strict=True):
        flats = _flats(bursts, transfer)
        system_gain = transfer.system_gain
        if level.black is None or system_gain is None or not flats:
            continue
        peak, top = _saturation(level, flats)
        model = _noise_model(transfer, models)
        rows += _saturation_rows(bursts, level.channel, system_gain, peak, top)
        rows += ratio_rows(bursts, transfer.channel, model, peak, thresholds=SNR_THRESHOLDS)
        curves.append(_snr_curve(bursts, transfer, model, peak))
        if LOWER_BOUND in peak.flags:
            short.append(level.channel)
    return Section(rows=tuple(rows), findings=_findings(bursts, short), curves=tuple(curves))


def _flats(bursts: IsoBursts, transfer: ChannelTransfer) -> list[TransferPoint]:
    points = [point for point in transfer.points if point.burst in bursts.flats and point.burst.frames > 1]
    return sorted(points, key=lambda point: point.burst.exposure_s)


def _saturation(level: ChannelLevels, flats: Sequence[TransferPoint]) -> tuple[SaturationLevel, SaturationLevel | None]:
    """Find where the brightest tiles saturate: lens shading would smear the whole plane over many levels."""
    planes = [point.burst.plane(level.channel) for point in flats]
    bright = _brightest(planes[0].tiles.mean - level.black_dn)
    weights = planes[0].tiles.n[bright]
    shares = [clipped_share(plane.tiles, level.white_dn, plane.frames) for plane in planes]
    signal = np.array([np.average(plane.tiles.mean[bright], weights=weights) for plane in planes])
    variance = np.array([np.average(plane.tiles.temporal_variance[bright], weights=weights) for plane in planes])
    clipped = np.array([np.average(share[bright], weights=weights) for share in shares])
    black = 0.0 if level.black is None else level.black.std_error or 0.0
    errors = np.hypot([plane.mean_std_error or 0.0 for plane in planes], black)
    peak = temporal_variance_peak(signal - level.black_dn, variance, clipped, std_error_dn=errors)
    return peak, plateau(signal - level.black_dn, clipped, errors) if len(flats) > 1 else None


def _brightest(signal_dn: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Choose the tiles within 2 % of the brightest, in the darkest flat, where nothing saturates yet."""
    return signal_dn >= 0.98 * float(signal_dn.max())


def _noise_model(transfer: ChannelTransfer, models: Sequence[ChannelModel]) -> NoiseModel:
    for model in models:
        if model.channel == transfer.channel:
            return NoiseModel(
                coefficients=model.coefficients,
                covariance=model.covariance,
                dof=model.dof,
                flags=("quantization-limited",) if model.only_an_interval else (),
            )
    if transfer.fit is None:
        raise ValueError("a noise model needs a photon-transfer fit")
    coefficients, covariance = transfer.fit.single_frame()
    return NoiseModel(coefficients=coefficients, covariance=covariance, dof=transfer.fit.dof)


def _saturation_rows(
    bursts: IsoBursts, channel: str, system_gain: Measured, peak: SaturationLevel, top: SaturationLevel | None
) -> tuple[Row, ...]:
    write = RowWriter(bursts=bursts).row
    rows: list[Row] = []
    for method, found, source in (("temporal-variance-peak", peak, "METHOD 7 (a)"), ("plateau", top, "METHOD 7 (b)")):
        if found is None:
            continue
        recommended = method == "temporal-variance-peak"
        rows += [
            write(
                "saturation_capacity",
                channel,
                method,
                measured,
                source=source,
                flags=found.flags,
                recommended=recommended,
            )
            for measured in (found.signal, _in_electrons(found, system_gain))
        ]
    return tuple(rows)


def _in_electrons(found: SaturationLevel, system_gain: Measured) -> Measured:
    if found.signal.std_error is None:
        return Measured.exact(found.signal.value / system_gain.value, ELECTRON)
    return to_electrons(found.signal, system_gain)


def ratio_rows(
    bursts: IsoBursts, channel: str, model: NoiseModel, peak: SaturationLevel, *, thresholds: Sequence[float]
) -> tuple[Row, ...]:
    """Return the SNR at saturation, and the dynamic range down to each threshold of it."""
    flags = peak.bound_flags
    write = RowWriter(bursts=bursts).row
    rows: list[Row] = []
    for method, found in _maxima(model, peak):
        recommended = method == "noise-model"
        rows += [
            write("snr_max", channel, method, measured, source="METHOD 7", flags=flags, recommended=recommended)
            for measured in (found.decibel, found.plain)
        ]
    for threshold in thresholds:
        found = _range(model, peak, threshold)
        if found is not None:
            rows += [
                write(
                    "dynamic_range",
                    channel,
                    "noise-model",
                    measured,
                    source="METHOD 7",
                    snr_threshold=threshold,
                    flags=(*flags, *model.flags),
                    recommended=True,
                )
                for measured in (found.decibel, found.stops, found.plain)
            ]
    return tuple(rows)


def _maxima(model: NoiseModel, peak: SaturationLevel) -> tuple[tuple[str, Ratio], ...]:
    """Return the SNR at saturation by its two methods; none where the noise model is not positive there."""

    def maximum(signal: Measured) -> SnrMaximum:
        return snr_maximum(model.coefficients, model.covariance, signal, dof=model.dof)

    try:
        total = peak.through(lambda signal: maximum(signal).total)
        shot_only = peak.through(lambda signal: maximum(signal).shot_only)
    except ValueError:
        return ()
    return ("noise-model", total), ("shot-only", shot_only)


def _range(model: NoiseModel, peak: SaturationLevel, threshold: float) -> Ratio | None:
    def reach(signal: Measured) -> Ratio:
        return dynamic_range(model.coefficients, model.covariance, signal, snr=threshold, dof=model.dof).range

    try:
        return peak.through(reach)
    except ValueError:
        return None


def _snr_curve(bursts: IsoBursts, transfer: ChannelTransfer, model: NoiseModel, peak: SaturationLevel) -> Curve:
    system_gain = float(model.coefficients[1])
    highest = max(peak.signal.value, *(point.plane_signal_dn for point in transfer.points))
    grid = np.geomspace(min(0.3 * system_gain, 0.1 * highest), highest, CURVE_POINTS)
    grid = grid[np.polynomial.polynomial.polyval(grid, model.coefficients) > 0.0]
    measured = [point for point in transfer.points if point.admitted and point.signal_dn > 0.1 * system_gain]
    signal = [*grid.tolist(), *(point.signal_dn for point in measured)]
    snr = [
        *snr_curve(grid, model.coefficients).tolist(),
        *(point.signal_dn / math.sqrt(point.variance_dn2) for point in measured),
    ]
    kinds = ["model"] * len(grid) + ["measured"] * len(measured)
    return Curve(
        name="snr",
        columns=(
            Column(name="iso", unit=ONE, values=(bursts.iso,) * len(signal)),
            Column(name="channel", unit="", values=(transfer.channel,) * len(signal)),
            Column(name="signal", unit=DN, values=tuple(signal)),
            Column(name="signal_e", unit=ELECTRON, values=tuple(one / system_gain for one in signal)),
            Column(name="snr", unit=ONE, values=tuple(snr)),
            Column(name="kind", unit="", values=tuple(kinds)),
        ),
    )


def _findings(bursts: IsoBursts, short: Sequence[str]) -> tuple[Finding, ...]:
    if not short:
        return ()
    message = (
        f"the flats of {', '.join(short)} at {bursts.label} do not reach saturation: saturation capacity, maximum SNR "
        "and dynamic range are lower bounds; add exposures until the frames clip"
    )
    return (Finding(code="saturation-not-reached", severity=Severity.WARNING, message=message),)
