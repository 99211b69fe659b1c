"""What spans the ISOs of a study is measured once all of them have been, and all is put together."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from fullwell.figures.results import Results, Row
from fullwell.findings import worst_first
from fullwell.frames.series import Kind, Study
from fullwell.report.pictures import Pictures
from fullwell.workflow.bit_depth import bit_depth_findings
from fullwell.workflow.description import describe
from fullwell.workflow.executor import Progress
from fullwell.workflow.iso_measurer import MeasuredIsos
from fullwell.workflow.measure.against_iso import measure_against_iso
from fullwell.workflow.measure.bursts import IsoBursts
from fullwell.workflow.measure.iso_constancy import IsoPattern, measure_iso_constancy
from fullwell.workflow.measure.section import Section, joined, over_isos
from fullwell.workflow.measure.shading_differences import measure_shading_differences
from fullwell.workflow.options import Options
from fullwell.workflow.pattern_pictures import difference_pictures, shading_pictures
from fullwell.workflow.reduce import Reduction

if TYPE_CHECKING:
    from fullwell.workflow.chart.chart import ChartOutcome


@dataclass(frozen=True, slots=True, kw_only=True)
class Measurement:
    """What a study came to, and what its report shows as pictures."""

    results: Results
    groups: tuple[IsoBursts, ...]
    pictures: Pictures


def measure_spanning(
    study: Study, found: MeasuredIsos, *, options: Options, tile: int, drawn: bool, progress: Progress | None
) -> Measurement:
    """Measure what spans the ISOs; ``drawn`` says whether a report will show pictures."""
    isos = [one.measured for one in found.isos]
    groups = tuple(one.bursts for one in found.isos)
    rows = [row for one in isos for row in one.section.rows]
    shadings = [shading for one in isos for shading in one.shadings]
    differences_section, differences = measure_shading_differences(shadings, workers=options.workers)
    charts = _charts(study, rows, options=options, progress=progress)
    published = found.published.finish([one.bursts for one in isos], progress=progress)
    across = joined(
        (
            measure_against_iso(study, groups, rows),
            measure_iso_constancy([IsoPattern(bursts=one.bursts, channels=one.patterns) for one in isos], rows),
            differences_section,
            published.section,
            *(() if charts is None else (charts.section,)),
            *(one.temperatures for one in found.isos),
        )
    )
    findings = (*over_isos((one.bursts, one.section) for one in isos), *across.findings)
    section = replace(joined((*(one.section for one in isos), across)), findings=findings)
    pictures = Pictures()
    if drawn:
        pictures = replace(
            next((one.pictures for one in found.isos if one.pictures.differences), Pictures()),
            shading=tuple(one for iso in isos for one in shading_pictures(iso.shadings, published.surfaces)),
            shading_differences=difference_pictures(differences),
            responses=tuple(one for iso in found.isos for one in iso.responses),
            charts=() if charts is None else charts.pictures(study),
        )
    results = _results(study, found.reduction, charts, section, settings=_settings(options, tile))
    return Measurement(results=results, groups=groups, pictures=pictures)


def _charts(study: Study, rows: Sequence[Row], *, options: Options, progress: Progress | None) -> "ChartOutcome | None":
    """Measure the charts of a study, None where it has none."""
    if not any(one.kind is Kind.CHART for one in study.series):
        return None
    from fullwell.workflow.chart.chart import measure_chart_folders  # noqa: PLC0415 - heavy, and few studies have charts

    return measure_chart_folders(study, rows, options=options, progress=progress)


def _results(
    study: Study,
    reduction: Reduction,
    charts: "ChartOutcome | None",
    section: Section,
    *,
    settings: Mapping[str, object],
) -> Results:
    unfit = bit_depth_findings(study, reduction.statistics.values())
    findings = (*study.findings, *reduction.findings, *unfit, *section.findings)
    hashes, excluded = dict(reduction.hashes), list(reduction.excluded)
    for reading in charts.readings if charts else ():
        hashes |= reading.hashes
        excluded += reading.excluded
    return Results(
        study=describe(study, settings=settings, hashes=hashes, excluded=excluded),
        rows=section.rows,
        findings=worst_first(findings),
        curves=section.curves,
    )


def _settings(options: Options, tile: int) -> Mapping[str, object]:
    selection = options.selection
    return {
        "iso": list(selection.isos),
        "exposure_s": list(selection.exposures_s),
        "only": [kind.value for kind in selection.kinds],
        "cfa": selection.cfa,
        "black_level": None if selection.black_level is None else list(selection.black_level),
        "white_level": selection.white_level,
        "tile": tile,
        "crop": None if selection.crop is None else list(selection.crop),
        "legacy_black": "subtracted" if options.legacy_black_subtracted else "kept",
        "profile": list(options.profiles),
    }
