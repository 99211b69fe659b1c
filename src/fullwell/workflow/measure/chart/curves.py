"""Curves of chart shots: what the report plots.

``chart_points``
    Every patch of every channel at every exposure, with the noise model beside it.
``chart_noise_model``
    The fitted coefficients, with black level and digital maximum they go by.
``chart_snr``
    Signal-to-noise ratio: the model's line and the patches.
``chart_tonal_response``
    Logarithms of pixel value and exposure, black level left in and taken off.
``chart_bracket``
    Exposures of one scene, each patch relative to the line through black.
"""

import math
from collections.abc import Sequence

import numpy as np

from fullwell.figures.results import Column, Curve
from fullwell.figures.snr import snr_curve
from fullwell.fit.gamma_likelihood import signed_deviance
from fullwell.fit.noise_coefficients import DIGITAL_MAXIMUM_IS
from fullwell.raw.cfa import ALL
from fullwell.statistics.chart import PatchPoint
from fullwell.units import DN, DN2, DN_PER_ELECTRON, ELECTRON, ONE
from fullwell.workflow.measure.chart.camera import tonal_points
from fullwell.workflow.measure.chart.evidence import BlackEvidence
from fullwell.workflow.measure.chart.levels import ChartLevels
from fullwell.workflow.measure.chart.noise_model import ChartModel
from fullwell.workflow.measure.chart.ranges import ChannelRange
from fullwell.workflow.measure.chart.shots import Shots

CURVE_POINTS = 64
_POINT_COLUMNS = (
    ("iso", ONE),
    ("scene", ""),
    ("exposure", ONE),
    ("exposure_s", "s"),
    ("frames", ONE),
    ("patch", ""),
    ("channel", ""),
    ("density", ONE),
    ("mean", DN),
    ("signal", DN),
    ("variance", DN2),
    ("variance_std_error", DN2),
    ("dof", ONE),
    ("temporal_variance", DN2),
    ("clipped", ONE),
    ("fitted", DN2),
    ("residual", ONE),
    ("used", ""),
)
_Value = float | int | str | None


def chart_curves(
    shots: Shots,
    levels: ChartLevels,
    models: Sequence[ChartModel],
    ranges: Sequence[ChannelRange],
    evidence: Sequence[BlackEvidence],
) -> tuple[Curve, ...]:
    """Return every curve that has points."""
    made = (
        _points(shots, levels, models),
        _models(shots, levels, models),
        _snr(shots, levels, models, ranges),
        _tonal(shots, levels),
        _bracket(shots, evidence),
    )
    return tuple(curve for curve in made if curve.columns and curve.columns[0].values)


def _curve(name: str, head: Sequence[tuple[str, str]], lines: Sequence[tuple[_Value, ...]]) -> Curve:
    columns = list(zip(*lines, strict=True)) or [()] * len(head)
    return Curve(
        name=name,
        columns=tuple(
            Column(name=title, unit=unit, values=tuple(_finite(value) for value in values))
            for (title, unit), values in zip(head, columns, strict=True)
        ),
    )


def _finite(value: _Value) -> _Value:
    return None if isinstance(value, float) and not math.isfinite(value) else value


def _points(shots: Shots, levels: ChartLevels, models: Sequence[ChartModel]) -> Curve:
    by_channel = {model.channel: model for model in models}
    lines: list[tuple[_Value, ...]] = []
    for scene in shots.scenes:
        for number, exposure in enumerate(scene.exposures):
            for point in exposure.points:
                signal = point.mean_dn - levels.of(point.channel).level.value
                fitted, residual = _judged(point, by_channel.get(point.channel), signal)
                lines.append(
                    (
                        shots.bursts.iso,
                        scene.name,
                        number,
                        exposure.exposure_s,
                        exposure.frames,
                        point.patch,
                        point.channel,
                        point.density,
                        point.mean_dn,
                        signal,
                        point.variance_dn2,
                        point.variance_dn2 * math.sqrt(2.0 / point.dof) if point.dof > 0 else None,
                        point.dof,
                        point.temporal_variance_dn2,
                        max(point.clipped_low, point.clipped_high),
                        fitted,
                        residual,
                        "yes" if point.admitted else "no",
                    )
                )
    return _curve("chart_points", _POINT_COLUMNS, lines)


def _judged(point: PatchPoint, model: ChartModel | None, signal: float) -> tuple[float | None, float | None]:
    """Return the model's variance of a single frame and the signed deviance from it."""
    if model is None:
        return None, None
    fitted = float(np.polynomial.polynomial.polyval(signal, model.coefficients))
    if fitted <= 0.0 or not point.admitted:
        return fitted, None
    found = signed_deviance(np.array([point.variance_dn2]), np.array([fitted]), np.array([point.dof]))
    return fitted, float(found[0])


def _models(shots: Shots, levels: ChartLevels, models: Sequence[ChartModel]) -> Curve:
    head = (
        ("iso", ONE),
        ("channel", ""),
        ("dark", DN2),
        ("shot", DN_PER_ELECTRON),
        ("fixed_pattern", ONE),
        ("black_level", DN),
        ("digital_maximum", DN),
        ("convention", ""),
        ("deviance", ONE),
        ("deviance_dof", ONE),
    )
    lines: list[tuple[_Value, ...]] = [
        (
            shots.bursts.iso,
            model.channel,
            *(float(value) for value in model.coefficients),
            levels.of(model.channel).level.value,
            levels.digital_maximum,
            DIGITAL_MAXIMUM_IS,
            model.fit.deviance,
            model.fit.deviance_dof,
        )
        for model in models
    ]
    return _curve("chart_noise_model", head, lines)


def _snr(shots: Shots, levels: ChartLevels, models: Sequence[ChartModel], ranges: Sequence[ChannelRange]) -> Curve:
    head = (("iso", ONE), ("channel", ""), ("signal", DN), ("signal_e", ELECTRON), ("snr", ONE), ("kind", ""))
    lines: list[tuple[_Value, ...]] = []
    for model in models:
        found = next((one for one in ranges if one.channel == model.channel), None)
        if found is None:
            continue
        system_gain = float(model.coefficients[1])
        top = max(found.peak.signal.value, system_gain)
        grid = np.geomspace(min(0.3 * system_gain, 0.1 * top), top, CURVE_POINTS)
        grid = grid[np.polynomial.polynomial.polyval(grid, model.coefficients) > 0.0]
        pairs = [
            (*pair, "model") for pair in zip(grid.tolist(), snr_curve(grid, model.coefficients).tolist(), strict=True)
        ]
        if model.channel != ALL:
            pairs += [
                (signal, signal / math.sqrt(point.variance_dn2), "measured")
                for point in shots.points(model.channel)
                if point.admitted and (signal := point.mean_dn - levels.of(model.channel).level.value) > 0.0
            ]
        lines += [
            (shots.bursts.iso, model.channel, signal, signal / system_gain, snr, kind) for signal, snr, kind in pairs
        ]
    return _curve("chart_snr", head, lines)


def _tonal(shots: Shots, levels: ChartLevels) -> Curve:
    head = (
        ("iso", ONE),
        ("channel", ""),
        ("patch", ""),
        ("log_exposure", ONE),
        ("log_pixel", ONE),
        ("log_signal", ONE),
        ("slope", ONE),
    )
    lines: list[tuple[_Value, ...]] = [
        (shots.bursts.iso, channel, *line)
        for channel in shots.channels
        for line in tonal_points(shots, levels, channel)
    ]
    return _curve("chart_tonal_response", head, lines)


def _bracket(shots: Shots, evidence: Sequence[BlackEvidence]) -> Curve:
    head = (
        ("iso", ONE),
        ("scene", ""),
        ("channel", ""),
        ("patch", ""),
        ("exposure", ONE),
        ("ratio", ONE),
        ("mean", DN),
        ("signal", DN),
        ("residual", ONE),
        ("used", ""),
    )
    lines: list[tuple[_Value, ...]] = []
    for one in evidence:
        if one.channel not in shots.channels:
            continue
        for bracket in one.brackets:
            scene, solved = shots.scenes[bracket.scene], bracket.solved
            for number, exposure in enumerate(scene.exposures):
                lines += [
                    (
                        shots.bursts.iso,
                        scene.name,
                        one.channel,
                        point.patch,
                        number,
                        solved.ratios[number].value,
                        point.mean_dn,
                        point.mean_dn - solved.offset.value,
                        float(solved.residuals[number, index]),
                        "yes" if solved.used[number, index] else "no",
                    )
                    for index, point in enumerate(exposure.of(one.channel))
                ]
    return _curve("chart_bracket", head, lines)
