"""Everything that shots of charts at one ISO tell: the one function that runs the others in their order."""

from collections.abc import Mapping
from dataclasses import dataclass, field

from fullwell.fit.black_level import Evidence
from fullwell.frames.series import Study
from fullwell.units import Measured
from fullwell.workflow.measure.chart.advice import advice, too_few_patches, without_signal
from fullwell.workflow.measure.chart.camera import measure_camera
from fullwell.workflow.measure.chart.curves import chart_curves
from fullwell.workflow.measure.chart.evidence import gather_evidence
from fullwell.workflow.measure.chart.framings import measure_framings
from fullwell.workflow.measure.chart.full_patches import without_full
from fullwell.workflow.measure.chart.levels import ChartLevels, chart_maximum, decide_levels, measure_whites
from fullwell.workflow.measure.chart.line_noise import line_noise
from fullwell.workflow.measure.chart.noise_model import ChartModel, fit_all, fit_channel, tabulate
from fullwell.workflow.measure.chart.noise_rows import noise_rows
from fullwell.workflow.measure.chart.published import published_coefficients, published_level_finding
from fullwell.workflow.measure.chart.ranges import measure_ranges
from fullwell.workflow.measure.chart.ratios import measure_channel_ratios
from fullwell.workflow.measure.chart.shots import Shots
from fullwell.workflow.measure.levels import declared_black
from fullwell.workflow.measure.section import Section, joined


@dataclass(frozen=True, slots=True, kw_only=True)
class BlackChoice:
    """What the user says about the black level beside a number.

    Parameters
    ----------
    legacy
        Whether the published optimizer is to set it.
    ratio
        What that aims at; None: as published.
    others
        Evidence from other frames of a study, by channel.

    """

    legacy: bool = False
    ratio: float | None = None
    others: Mapping[str, Evidence] = field(default_factory=dict[str, Evidence])


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ChartMeasurement:
    """What the shots at one ISO came to."""

    section: Section
    shots: Shots
    levels: ChartLevels
    models: tuple[ChartModel, ...]


def measure_shots(
    study: Study, shots: Shots, *, black: BlackChoice, dark_current: Mapping[str, Measured] | None = None
) -> ChartMeasurement:
    """Measure the shots of charts at one ISO.

    Parameters
    ----------
    study
        For declared levels and camera facts.
    shots
        At least one scene.
    black
        What the user says about the black level.
    dark_current
        What dark frames of a study tell of it, by channel [DN/s].

    """
    shots = without_full(shots)
    whites = measure_whites(study, shots)
    maximum = chart_maximum(whites)
    points = [point for _, exposure in shots.exposures for point in exposure.points]
    declared = [level for index in range(len(shots.channels)) if (level := declared_black(study, index)) is not None]
    guess = sum(declared) / len(declared) if declared else min(point.mean_dn for point in points)
    lines = line_noise(points)
    table = tabulate(shots, [guess] * len(shots.channels), lines=lines)
    first = [fit_channel(table, shots, channel) for channel in shots.channels]
    evidence, unlike = gather_evidence(
        study,
        shots,
        first,
        lines=lines,
        guess_dn=guess,
        range_dn=maximum - guess,
        ratio=black.ratio,
        others=black.others,
    )
    levels_section, levels = decide_levels(study, shots, whites, evidence, first, guess_dn=guess, legacy=black.legacy)
    own = tabulate(shots, levels.own_offsets_dn, lines=lines)
    models = [model for channel in shots.channels if (model := fit_channel(own, shots, channel)) is not None]
    together = fit_all(tabulate(shots, levels.shared_offsets_dn, lines=lines), shots)
    shared = None
    if together is not None:
        models.append(together[0])
        shared = together[1]
    ranges_section, ranges = measure_ranges(shots, levels, models)
    published = published_level_finding(evidence) if black.legacy else ()
    sections = (
        Section(findings=(*without_signal(shots), *too_few_patches(shots), *unlike, *published)),
        levels_section,
        noise_rows(shots, levels, models, shared),
        ranges_section,
        measure_camera(shots, levels, models, ranges, lines=lines, dark_current=dark_current or {}),
        measure_channel_ratios(shots, levels),
        published_coefficients(shots, levels, models),
        measure_framings(shots, levels),
        Section(findings=advice(study, shots, levels), curves=chart_curves(shots, levels, models, ranges, evidence)),
    )
    return ChartMeasurement(section=joined(sections), shots=shots, levels=levels, models=tuple(models))
