"""Every piece of evidence for the black level of a chart's shots, per channel and for all together (METHOD 2.3)."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from fullwell.findings import Finding, Severity
from fullwell.fit.black_level import Evidence
from fullwell.fit.black_level import declared as declared_level
from fullwell.fit.legacy.chart import PUBLISHED_RATIO, legacy_offset
from fullwell.fit.pooling import mean_sharing_errors, weighted_mean
from fullwell.frames.series import Study
from fullwell.raw.cfa import ALL
from fullwell.units import DN, Measured
from fullwell.workflow.masked import MaskedArea
from fullwell.workflow.measure.chart.bracket import Bracket, solve_brackets
from fullwell.workflow.measure.chart.line_noise import LineNoise
from fullwell.workflow.measure.chart.noise_model import ChartModel
from fullwell.workflow.measure.chart.shots import Shots
from fullwell.workflow.measure.levels import declared_black
from fullwell.workflow.measure.white_level import METADATA, USER

BRACKET = "exposure-bracket"
OPTICAL_BLACK = "optical-black"
LEGACY = "legacy-offset-ratio"
NOISIER = 4.0
"""Standard errors by which the noise of masked pixels must differ from that of the others to be called another."""
NOTABLY = 0.15
"""The same as a share."""


@dataclass(frozen=True, slots=True, kw_only=True)
class BlackEvidence:
    """What is known of the black level of one channel, or of all.

    Parameters
    ----------
    channel
        Its name, or ``all``.
    evidence
        What counts.
    set_aside
        Optical black that is not like the active area.
    brackets
        The brackets behind the evidence of that name.
    legacy
        What the published optimizer makes of it [DN].
    ratio
        The ratio that it aims at.

    """

    channel: str
    evidence: tuple[Evidence, ...]
    set_aside: Evidence | None
    brackets: tuple[Bracket, ...]
    legacy: Measured
    ratio: float


def gather_evidence(
    study: Study,
    shots: Shots,
    models: Sequence[ChartModel | None],
    *,
    lines: LineNoise,
    guess_dn: float,
    range_dn: float,
    ratio: float | None,
    others: Mapping[str, Evidence],
) -> tuple[tuple[BlackEvidence, ...], tuple[Finding, ...]]:
    """Collect the evidence of each channel, and that for the offset they share at the end where there are several.

    Parameters
    ----------
    study
        For declared levels.
    shots
        The scenes.
    models
        Noise model of each channel for signals above ``guess_dn``; None where there is none.
    lines
        Noise of rows and columns, which patches share.
    guess_dn, range_dn
        A first black level; white level less it [DN].
    ratio
        What the published optimizer aims at; None: as published.
    others
        Evidence from other frames of a study by channel: its dark frames.

    """
    masked = {area.channel: area for area in shots.masked}
    found: list[BlackEvidence] = []
    unlike: list[tuple[MaskedArea, float]] = []
    for index, channel in enumerate(shots.channels):
        brackets = solve_brackets(shots, models, [channel], lines=lines, guess_dn=guess_dn, range_dn=range_dn)
        evidence = _from_brackets(brackets)
        evidence += [others[channel]] if channel in others else []
        aside: Evidence | None = None
        if channel in masked:
            area = masked[channel]
            piece = Evidence(method=OPTICAL_BLACK, measured=Measured.normal(area.mean_dn, area.std_error_dn, DN))
            expected = _unlike(area, models[index], guess_dn)
            if expected is None:
                evidence.append(piece)
            else:
                aside = piece
                unlike.append((area, expected))
        evidence += _declared(study, index)
        found.append(_gathered(shots, channel, evidence, brackets=brackets, ratio=ratio, aside=aside))
    if len(found) > 1:
        brackets = solve_brackets(shots, models, shots.channels, lines=lines, guess_dn=guess_dn, range_dn=range_dn)
        evidence = _from_brackets(brackets) + _shared(found)
        evidence += [others[ALL]] if ALL in others else []
        found.append(_gathered(shots, ALL, evidence, brackets=brackets, ratio=ratio))
    return tuple(found), _unlike_findings(unlike, found)


def _from_brackets(brackets: Sequence[Bracket]) -> list[Evidence]:
    if not brackets:
        return []
    pooled = weighted_mean([one.solved.offset for one in brackets]).measured
    return [Evidence(method=BRACKET, measured=pooled)]


def _declared(study: Study, index: int) -> list[Evidence]:
    level = declared_black(study, index)
    if level is None or study.black_level is None:
        return []
    return [declared_level(level, method=USER if study.black_level.source == USER else METADATA)]


def _shared(channels: Sequence[BlackEvidence]) -> list[Evidence]:
    """Return declared levels and optical black of all channels as one: they err together."""
    shared: list[Evidence] = []
    for method in (OPTICAL_BLACK, USER, METADATA):
        own = [piece.measured for one in channels for piece in one.evidence if piece.method == method]
        if len(own) == len(channels):
            shared.append(Evidence(method=method, measured=mean_sharing_errors(own)))
    return shared


def _gathered(
    shots: Shots,
    channel: str,
    evidence: Sequence[Evidence],
    *,
    brackets: tuple[Bracket, ...],
    ratio: float | None,
    aside: Evidence | None = None,
) -> BlackEvidence:
    points = [point for scene in shots.scenes for point in scene.brightest.points if channel in {ALL, point.channel}]
    densities = [np.nan if point.density is None else point.density for point in points]
    spread = np.ptp([density for density in densities if np.isfinite(density)] or [0.0])
    legacy = legacy_offset(
        [point.mean_dn for point in points],
        densities if ratio is None and spread > 0.0 else None,
        ratio=PUBLISHED_RATIO if ratio is None else ratio,
    )
    return BlackEvidence(
        channel=channel,
        evidence=tuple(evidence),
        set_aside=aside,
        brackets=brackets,
        legacy=legacy.offset,
        ratio=legacy.ratio,
    )


def _unlike(area: MaskedArea, model: ChartModel | None, guess_dn: float) -> float | None:
    """Return the variance that the noise model has at the level of the masked pixels where theirs is another [DN^2]."""
    if model is None:
        return None
    powers = (area.mean_dn - guess_dn) ** np.arange(3.0)
    expected = float(powers @ model.coefficients)
    error = math.hypot(float(powers @ model.covariance @ powers) ** 0.5, area.variance_dn2 * (2.0 / area.dof) ** 0.5)
    apart = abs(area.variance_dn2 - expected)
    return expected if apart > max(NOISIER * error, NOTABLY * abs(expected)) else None


def _unlike_findings(unlike: Sequence[tuple[MaskedArea, float]], found: Sequence[BlackEvidence]) -> tuple[Finding, ...]:
    if not unlike:
        return ()
    said = "; ".join(
        f"{area.channel} {area.mean_dn:.2f} DN, variance {area.variance_dn2:.0f} where the noise model has "
        f"{expected:.0f} DN²"
        for area, expected in unlike
    )
    declared = [piece.measured.value for piece in found[-1].evidence if piece.method in {METADATA, USER}]
    apart = np.mean([area.mean_dn for area, _ in unlike]) - declared[0] if declared else None
    beside = "" if apart is None else f", {abs(apart):.1f} DN {'below' if apart < 0 else 'above'} the declared level"
    message = f"the optical black is not like the active area ({said}){beside}: its level and its noise are not used"
    return (Finding(code="optical-black-inconsistent", severity=Severity.WARNING, message=message),)
