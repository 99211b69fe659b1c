"""The main verb: a folder of raw frames becomes a characterized sensor."""

import tempfile
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

from fullwell.errors import UsageError
from fullwell.figures.results import Results, Row
from fullwell.files import replaced_folder
from fullwell.findings import worst_first
from fullwell.frames.series import MEASURED_KINDS, Kind, Study
from fullwell.frames.study import load_study
from fullwell.raw.cfa import cell
from fullwell.report.pictures import Pictures
from fullwell.report.write import check_target, write_files
from fullwell.workflow.bit_depth import bit_depth_findings
from fullwell.workflow.cache.opening import opened_cache
from fullwell.workflow.cache.series_cache import SeriesCache
from fullwell.workflow.cluster import connected
from fullwell.workflow.description import describe
from fullwell.workflow.executor import Progress, old_objects_aside, one_algebra_thread, short_turns
from fullwell.workflow.isos import IsoReader, MeasuredIsos
from fullwell.workflow.measure.against_iso import measure_against_iso
from fullwell.workflow.measure.bursts import IsoBursts
from fullwell.workflow.measure.iso_constancy import IsoPattern, measure_iso_constancy
from fullwell.workflow.measure.section import Section, joined, over_isos
from fullwell.workflow.measure.shading_differences import measure_shading_differences
from fullwell.workflow.memory import keep_large_apart
from fullwell.workflow.options import Options
from fullwell.workflow.pattern_pictures import difference_pictures, shading_pictures
from fullwell.workflow.plan import Cluster
from fullwell.workflow.reduce import Reduction
from fullwell.workflow.run import run_facts

if TYPE_CHECKING:
    from fullwell.workflow.chart.chart import ChartOutcome

LARGEST_TILE = 64
SMALLEST_TILE = 8


@dataclass(frozen=True, slots=True, kw_only=True)
class Measurement:
    """What a study came to, and what its report shows as pictures."""

    results: Results
    groups: tuple[IsoBursts, ...]
    pictures: Pictures


def characterize(path: Path, out: Path, *, options: Options, progress: Progress | None = None) -> Results:
    """Measure a study and write what was found into a folder.

    Parameters
    ----------
    path
        A study folder, a manifest or an EMVA 1288 descriptor.
    out
        Folder to write; replaced only if it is empty or holds results of ours.
    options
        What to measure and how.
    progress
        Told of every frame, and again of those read a second time; None for silence.

    Returns
    -------
    Results
        What was written.

    Raises
    ------
    UsageError
        The path holds nothing to measure, an option does not fit it, or ``out`` must not be replaced.

    """
    check_target(out)
    _refuse_to_replace(path, out)
    started = time.monotonic()
    study = _study_to_measure(path, options)
    cache = opened_cache(options, out=out)
    with replaced_folder(out) as folder:
        with connected(options.dask, workers=options.workers) as cluster:
            measurement = _measure(
                study, options=options, progress=progress, folder=folder, cache=cache, cluster=cluster
            )
        if cache is not None:
            cache.sweep()
        run = run_facts(study=path, out=out, options=options, started=started, cache=cache)
        results = replace(measurement.results, run=run)
        write_files(results, folder, pictures=measurement.pictures)
    return results


def _refuse_to_replace(path: Path, out: Path) -> None:
    """Refuse to write results over the study they come from."""
    study, target = path.resolve(), out.resolve()
    if study == target or target in study.parents:
        raise UsageError(f"{out} holds the study {path}, and results would replace it; name another folder with -o")


def measure(
    path: Path, *, options: Options, progress: Progress | None = None, folder: Path | None = None
) -> Measurement:
    """Measure a study in this process.

    Parameters
    ----------
    path, options, progress
        As `characterize`.
    folder
        Where ``maps/`` and ``tables/`` are written; None writes neither, and takes no pictures.

    """
    return _measure(_study_to_measure(path, options), options=options, progress=progress, folder=folder)


def _study_to_measure(path: Path, options: Options) -> Study:
    study = load_study(path, options.selection)
    if not any(one.kind in (*MEASURED_KINDS, Kind.CHART) for one in study.series):
        raise UsageError(
            f"{path} holds no flat, dark, bias or chart frames to measure; name the folders flat, dark, bias and "
            "chart, or write a study.toml with `fullwell index`"
        )
    return study


def _measure(
    study: Study,
    *,
    options: Options,
    progress: Progress | None,
    folder: Path | None,
    cache: SeriesCache | None = None,
    cluster: Cluster | None = None,
) -> Measurement:
    """Measure a study, finished series from a cache where there is one, frames read by a cluster where there is one."""
    measured = replace(study, series=tuple(one for one in study.series if one.kind in MEASURED_KINDS))
    tile = options.tile or default_tile(study)
    beside = None if folder is None else folder.parent
    keep_large_apart()
    with (
        tempfile.TemporaryDirectory(prefix="sums-", dir=beside, ignore_cleanup_errors=True) as scratch,
        one_algebra_thread(),
        short_turns(),
        old_objects_aside(),
    ):
        reader = IsoReader(
            study=study,
            options=options,
            tile=tile,
            folder=folder,
            scratch=Path(scratch),
            progress=progress,
            cache=cache,
            cluster=cluster,
        )
        return _spanned(study, reader.measure(measured), options=options, tile=tile, folder=folder, progress=progress)


def _spanned(
    study: Study, found: MeasuredIsos, *, options: Options, tile: int, folder: Path | None, progress: Progress | None
) -> Measurement:
    """Measure what spans the ISOs."""
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
    if folder is not None:
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


def default_tile(study: Study) -> int:
    """Return the edge of a tile: 64 pixels of a plane, or an eighth of its shorter side where that is less, at least 8.

    A quadratic surface over a tile must follow the shading, or what is left of it counts as fixed pattern.
    """
    shorter = min(study.width, study.height) // cell(study.cfa)
    return max(SMALLEST_TILE, min(LARGEST_TILE, shorter // 8))


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
