"""The main verb: a folder of raw frames becomes a characterized sensor."""

import tempfile
import time
from collections.abc import Mapping
from dataclasses import asdict, dataclass, replace
from pathlib import Path

from fullwell.errors import UsageError
from fullwell.figures.results import Results
from fullwell.files import replaced_folder
from fullwell.findings import Finding
from fullwell.frames.series import Exclusion, Kind, Series, Study
from fullwell.frames.study import load_study
from fullwell.raw.cfa import cell
from fullwell.raw.image import Levels
from fullwell.report.pictures import Pictures, ResponsePicture
from fullwell.report.write import check_target, write_files
from fullwell.workflow.bit_depth import bit_depth_findings
from fullwell.workflow.duplicates import reduce_without_copies
from fullwell.workflow.executor import Progress
from fullwell.workflow.iso_maps import write_iso_maps
from fullwell.workflow.measure.against_iso import measure_against_iso
from fullwell.workflow.measure.bursts import IsoBursts, group_by_iso
from fullwell.workflow.measure.iso import IsoMeasurement, measure_iso
from fullwell.workflow.measure.iso_constancy import IsoPattern, measure_iso_constancy
from fullwell.workflow.measure.pattern_maps import IsoMaps
from fullwell.workflow.measure.section import Section, joined, over_isos
from fullwell.workflow.measure.shading_differences import measure_shading_differences
from fullwell.workflow.options import Options
from fullwell.workflow.pattern_pictures import difference_pictures, response_pictures, shading_pictures
from fullwell.workflow.pictures import take_pictures
from fullwell.workflow.published.study import measure_published_study
from fullwell.workflow.reduce import Reduction
from fullwell.workflow.run import run_facts

LARGEST_TILE = 64
SMALLEST_TILE = 8
MEASURED_KINDS = (Kind.FLAT, Kind.DARK, Kind.BIAS)


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
        A study folder or a manifest.
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
    with replaced_folder(out) as folder:
        measurement = measure(path, options=options, progress=progress, folder=folder)
        run = run_facts(study=path, out=out, options=options, started=started)
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
    """Measure a study.

    Parameters
    ----------
    path, options, progress
        As `characterize`.
    folder
        Where ``maps/`` and ``tables/`` are written; None writes neither, and takes no pictures.

    """
    study = load_study(path, options.selection)
    measured = replace(study, series=tuple(one for one in study.series if one.kind in MEASURED_KINDS))
    if not measured.series:
        raise UsageError(
            f"{path} holds no flat, dark or bias frames to measure; name the folders flat, dark and bias, or write a "
            "study.toml with `fullwell index`"
        )
    tile = options.tile or default_tile(study)
    beside = None if folder is None else folder.parent
    with tempfile.TemporaryDirectory(prefix="sums-", dir=beside, ignore_cleanup_errors=True) as scratch:
        reduction = reduce_without_copies(
            measured,
            workers=options.workers,
            tile=tile,
            progress=progress,
            keep=MEASURED_KINDS,
            scratch=Path(scratch),
        )
        return _measured(study, measured, reduction, options=options, tile=tile, folder=folder, progress=progress)


def _measured(
    study: Study,
    measured: Study,
    reduction: Reduction,
    *,
    options: Options,
    tile: int,
    folder: Path | None,
    progress: Progress | None,
) -> Measurement:
    """Measure one ISO after the other, letting go of its maps; then what spans them."""
    groups = group_by_iso(measured, reduction.statistics, reduction.sums)
    isos: list[IsoMeasurement] = []
    responses: list[ResponsePicture] = []
    for group in groups:
        one = measure_iso(study, group, workers=options.workers)
        if folder is not None:
            write_iso_maps(study, one, folder / "maps")
            responses += response_pictures(study, one)
        isos.append(replace(one, maps=IsoMaps(channels=(), mosaics={})))
    rows = [row for one in isos for row in one.section.rows]
    shadings = [shading for one in isos for shading in one.shadings]
    differences_section, differences = measure_shading_differences(shadings, workers=options.workers)
    published = measure_published_study(study, isos, options=options, folder=folder, progress=progress)
    across = joined(
        (
            measure_against_iso(study, groups, rows),
            measure_iso_constancy([IsoPattern(bursts=one.bursts, channels=one.patterns) for one in isos], rows),
            differences_section,
            published.section,
        )
    )
    findings = (*over_isos((one.bursts, one.section) for one in isos), *across.findings)
    section = replace(joined((*(one.section for one in isos), across)), findings=findings)
    pictures = Pictures()
    if folder is not None:
        pictures = replace(
            take_pictures(groups),
            shading=tuple(one for iso in isos for one in shading_pictures(iso.shadings, published.surfaces)),
            shading_differences=difference_pictures(differences),
            responses=tuple(responses),
        )
    results = _results(study, options, tile, reduction, section)
    return Measurement(results=results, groups=groups, pictures=pictures)


def default_tile(study: Study) -> int:
    """Return the edge of a tile: 64 pixels of a plane, or an eighth of its shorter side where that is less, at least 8.

    A quadratic surface over a tile must follow the shading, or what is left of it counts as fixed pattern.
    """
    shorter = min(study.width, study.height) // cell(study.cfa)
    return max(SMALLEST_TILE, min(LARGEST_TILE, shorter // 8))


def _results(study: Study, options: Options, tile: int, reduction: Reduction, section: Section) -> Results:
    unfit = bit_depth_findings(study, reduction.statistics.values())
    findings = (*study.findings, *reduction.findings, *unfit, *section.findings)
    return Results(
        study=_describe(study, options, tile, reduction),
        rows=section.rows,
        findings=tuple(sorted(findings, key=_finding_order)),
        curves=section.curves,
    )


def _finding_order(finding: Finding) -> tuple[int, str]:
    return (finding.severity.rank, finding.code)


def _describe(study: Study, options: Options, tile: int, reduction: Reduction) -> Mapping[str, object]:
    excluded = sorted((*study.excluded, *reduction.excluded), key=lambda one: one.name)
    gone = {one.name for one in reduction.excluded}
    return {
        "camera": {name: value for name, value in asdict(study.camera).items() if value is not None},
        "width": study.width,
        "height": study.height,
        "cfa": study.cfa,
        "bit_depth": study.bit_depth,
        "black_level": _describe_levels(study.black_level),
        "white_level": _describe_levels(study.white_level),
        "settings": _settings(options, tile),
        "series": [_describe_series(series, gone) for series in study.series],
        "files": [
            _describe_file(series, index, reduction.hashes)
            for series in study.series
            for index in range(len(series.frames))
        ],
        "excluded": [_describe_exclusion(one) for one in excluded],
    }


def _describe_exclusion(exclusion: Exclusion) -> Mapping[str, object]:
    return {"path": exclusion.name, "code": exclusion.code, "reason": exclusion.reason}


def _describe_levels(levels: Levels | None) -> Mapping[str, object] | None:
    return None if levels is None else {"values": list(levels.values), "source": levels.source, "tag": levels.tag}


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
    }


def _describe_series(series: Series, gone: set[str]) -> Mapping[str, object]:
    return {
        "kind": series.kind.value,
        "iso": series.iso,
        "exposure_s": series.exposure_s,
        "temperature_c": series.temperature_c,
        "frames": sum(frame.name not in gone for frame in series.frames),
    }


def _describe_file(series: Series, index: int, hashes: Mapping[str, str]) -> Mapping[str, object]:
    frame = series.frames[index]
    return {
        "path": frame.name,
        "size": frame.size,
        "xxh3_128": hashes.get(frame.name),
        "kind": series.kind.value,
        "iso": series.iso,
        "exposure_s": series.exposure_s,
        "black_level": _describe_levels(frame.header.black_level),
        "white_level": _describe_levels(frame.header.white_level),
    }
