"""The k's as published: two objectives that contradict each other, beside the recommended fit (METHOD 1.5)."""

import math
from collections.abc import Sequence
from typing import Literal

from fullwell.figures.results import Row
from fullwell.findings import Finding, Severity
from fullwell.fit.legacy.imatest import fit_legacy_imatest
from fullwell.raw.cfa import ALL
from fullwell.statistics.chart import PatchPoint
from fullwell.workflow.measure.chart.evidence import BlackEvidence
from fullwell.workflow.measure.chart.levels import ChartLevels
from fullwell.workflow.measure.chart.noise_model import ChartModel
from fullwell.workflow.measure.chart.shots import Shots
from fullwell.workflow.measure.section import RowWriter, Section

OBJECTIVES: tuple[Literal["variance", "sigma"], ...] = ("variance", "sigma")


def published_coefficients(shots: Shots, levels: ChartLevels, models: Sequence[ChartModel]) -> Section:
    """Fit the k's of every channel, and of all as one curve, to the nominal exposure as published."""
    rows: list[Row] = []
    dropped: list[str] = []
    for model in models:
        channels = shots.channels if model.channel == ALL else (model.channel,)
        points = _nominal(shots, channels)
        signal = [_signal(point, levels, model.channel) for point in points]
        for objective in OBJECTIVES:
            try:
                fit = fit_legacy_imatest(
                    signal,
                    [point.variance_dn2 for point in points],
                    digital_maximum=levels.digital_maximum,
                    objective=objective,
                )
            except (ValueError, ZeroDivisionError):
                continue
            if fit.fixed_pattern_dropped:
                dropped.append(f"{model.channel} ({objective})")
            rows += [
                RowWriter(bursts=shots.bursts).row(
                    name,
                    model.channel,
                    f"legacy-imatest-{objective}",
                    measured,
                    source="METHOD 1.5",
                    n=sum(point.n * point.frames for point in points),
                    flags=() if levels.of(model.channel).identified else ("offset-not-identified",),
                )
                for name, measured in (("k_dark", fit.k_dark), ("k_shot", fit.k_shot), ("k_fpn", fit.k_fpn))
                if math.isfinite(measured.value)
            ]
    return Section(rows=tuple(rows), findings=_dropped(dropped))


def published_level_finding(evidence: Sequence[BlackEvidence]) -> tuple[Finding, ...]:
    """Say that the published optimizer's level is used, with the ratio that it aims at."""
    one = evidence[-1]
    message = (
        f"the black level is that of the published optimizer ({one.legacy.value:.2f} DN), which makes the darkest "
        f"patch one part in {one.ratio:g} of the lightest, an arbitrary ratio: it takes all stray light for black "
        "level, and nothing identifies it"
    )
    return (Finding(code="legacy-black-level", severity=Severity.WARNING, message=message),)


def _nominal(shots: Shots, channels: Sequence[str]) -> list[PatchPoint]:
    return [
        point
        for scene in shots.scenes
        for channel in channels
        for point in scene.brightest.of(channel)
        if point.admitted
    ]


def _signal(point: PatchPoint, levels: ChartLevels, channel: str) -> float:
    name = channel if channel != ALL or levels.alike else point.channel
    return point.mean_dn - levels.of(name).level.value


def _dropped(names: Sequence[str]) -> tuple[Finding, ...]:
    if not names:
        return ()
    message = (
        f"the published fit came out with a negative k_fpn for {', '.join(names)} and was repeated without it, as "
        "published"
    )
    return (Finding(code="legacy-fixed-pattern-dropped", severity=Severity.INFO, message=message),)
