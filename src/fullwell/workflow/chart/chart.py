"""The verb for charts: shots of a chart become a noise model, from one image or from many."""

import time
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field, replace
from itertools import groupby
from pathlib import Path

from fullwell.errors import UsageError
from fullwell.figures.matching import SAME_TEMPERATURE_C
from fullwell.figures.results import Results, Row
from fullwell.files import replaced_folder
from fullwell.findings import Finding, worst_first
from fullwell.fit.black_level import Evidence
from fullwell.fit.noise_coefficients import DIGITAL_MAXIMUM_IS
from fullwell.frames.images import load_images
from fullwell.frames.series import Frame, Kind, Series, Study
from fullwell.glossary import RECOMMENDED
from fullwell.raw.cfa import ALL, cell
from fullwell.report.pictures import ChartPicture, Pictures
from fullwell.report.write import check_target, write_files
from fullwell.units import DN_PER_SECOND, Measured
from fullwell.workflow.chart.patches import WhereAbouts, located_finding, place, place_unasked
from fullwell.workflow.chart.pictures import chart_pictures, rendered_points
from fullwell.workflow.chart.reading import ChartReading, Placed, read_shots
from fullwell.workflow.description import describe
from fullwell.workflow.executor import Progress
from fullwell.workflow.measure.bursts import IsoBursts
from fullwell.workflow.measure.chart.chart import BlackChoice, ChartMeasurement, measure_shots
from fullwell.workflow.measure.levels import DARK_FRAMES
from fullwell.workflow.measure.section import Section, joined
from fullwell.workflow.options import Options
from fullwell.workflow.run import run_facts

IN_A_STUDY = "chart"
"""Region of the rows of a chart in a study whose other frames tell the same figures."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ChartOptions:
    """What to measure in shots of charts, and how.

    Parameters
    ----------
    where
        Where the patches are.
    separate
        Whether the images are different shots rather than frames and exposures of one still scene.
    black
        Whether the published optimizer sets the black level.
    rendered
        A developed picture of the same scene, JPEG or PNG, to compare with; None for none.

    """

    where: WhereAbouts
    separate: bool = False
    rendered: Path | None = None
    black: BlackChoice = field(default_factory=BlackChoice)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ChartOutcome:
    """What shots of charts came to, and what the report shows of them."""

    section: Section
    readings: tuple[ChartReading, ...]
    measurements: tuple[ChartMeasurement, ...]

    def pictures(self, study: Study) -> tuple[ChartPicture, ...]:
        """Return the charts with their patches, for the report."""
        return tuple(one for measurement in self.measurements for one in chart_pictures(study, measurement))


def chart(
    images: Sequence[Path], out: Path, *, options: Options, asked: ChartOptions, progress: Progress | None = None
) -> Results:
    """Measure shots of a chart and write what was found into a folder.

    Parameters
    ----------
    images
        Raw files.
    out
        Folder to write; replaced only if it is empty or holds results of ours.
    options
        Facts that outrank the files' own, and workers.
    asked
        Where the patches are, and what the images have in common.
    progress
        Told of every frame; None for silence.

    Returns
    -------
    Results
        What was written.

    Raises
    ------
    UsageError
        An image, a patch or an option is not fit for use, or ``out`` must not be replaced.

    """
    check_target(out)
    if asked.rendered is not None and options.selection.crop is not None:
        raise UsageError("--rendered shows the whole frame: leave --crop out, or --rendered.")
    started = time.monotonic()
    study = load_images(images, options.selection, kind=Kind.CHART)
    _refuse_to_replace(study, out)
    outcome, findings = measure_images(study, options=options, asked=asked, progress=progress)
    pictures = Pictures(charts=outcome.pictures(study))
    if asked.rendered is not None:
        points, said = rendered_points(asked.rendered, outcome.measurements[0].shots)
        pictures, findings = replace(pictures, rendered=(points,)), (*findings, *said)
    results = Results(
        study=_describe(study, options, asked, outcome),
        rows=outcome.section.rows,
        findings=worst_first((*study.findings, *findings, *outcome.section.findings)),
        curves=outcome.section.curves,
        run=run_facts(study=study.root, out=out, options=options, started=started),
    )
    with replaced_folder(out) as folder:
        write_files(results, folder, pictures=pictures)
    return results


def measure_images(
    study: Study, *, options: Options, asked: ChartOptions, progress: Progress | None = None
) -> tuple[ChartOutcome, tuple[Finding, ...]]:
    """Measure images that all belong together.

    Raises
    ------
    UsageError
        Where their ISOs differ, their patches do not fit, or none can be read.

    """
    if len(study.isos) > 1:
        named = ", ".join("unknown" if iso is None else f"{iso:g}" for iso in study.isos)
        raise UsageError(
            f"The images have different ISOs ({named}): one noise model belongs to one ISO. Choose with --iso, or "
            "measure them one after the other."
        )
    frames = [(series, frame) for series in study.series for frame in series.frames]
    scenes = [[one] for one in sorted(frames, key=lambda one: one[1].name)] if asked.separate else [frames]
    placed, findings = place(study, scenes, asked.where, crop=options.selection.crop)
    reading = _read(study, placed, options=options, progress=progress)
    if not reading.shots.scenes:
        said = reading.excluded[0].reason if reading.excluded else "they cannot be read"
        raise UsageError(f"None of the images can be measured: {said.rstrip('.')}.")
    measurement = measure_shots(study, reading.shots, black=asked.black)
    outcome = ChartOutcome(section=measurement.section, readings=(reading,), measurements=(measurement,))
    return outcome, (*located_finding(placed), *findings, *reading.findings)


def measure_chart_folders(
    study: Study,
    rows: Sequence[Row],
    *,
    options: Options,
    progress: Progress | None = None,
) -> ChartOutcome:
    """Measure the charts of a study: every folder of them is one still scene, all of an ISO go into one table.

    Parameters
    ----------
    study
        Its series of kind chart are measured.
    rows
        What its other frames told. The black level that dark frames tell counts as evidence, and their dark current is
        taken off stray light; figures that stand there already are given the region ``chart`` here, and none of those
        is recommended.
    options
        Workers.
    progress
        Told of every frame; None for silence.

    Returns
    -------
    ChartOutcome
        Empty where the study has no charts; findings stand in its section.

    """
    sections: list[Section] = []
    readings: list[ChartReading] = []
    measurements: list[ChartMeasurement] = []
    for iso in study.isos:
        frames = [(series, frame) for series in study.select(Kind.CHART, iso=iso) for frame in series.frames]
        if not frames:
            continue
        placed, findings = place_unasked(study, _by_folder(frames), crop=options.selection.crop)
        sections.append(Section(findings=(*located_finding(placed), *findings)))
        if not placed:
            continue
        reading = _read(study, placed, options=options, progress=progress)
        readings.append(reading)
        sections.append(Section(findings=reading.findings))
        if reading.shots.scenes:
            measurement = measure_shots(
                study,
                reading.shots,
                black=BlackChoice(others=_dark_evidence(rows, iso)),
                dark_current=_dark_current(rows, reading.shots.bursts),
            )
            measurements.append(measurement)
            sections.append(_beside(measurement.section, rows))
    return ChartOutcome(section=joined(sections), readings=tuple(readings), measurements=tuple(measurements))


def _read(study: Study, placed: Sequence[Placed], *, options: Options, progress: Progress | None) -> ChartReading:
    whites = None if study.white_level is None else study.white_level.values
    sites = cell(study.cfa) ** 2
    if whites is not None and len(whites) < sites:
        whites = whites[:1] * sites
    return read_shots(
        study,
        placed,
        whites_dn=whites,
        masked=options.selection.crop is None,
        workers=options.workers,
        progress=progress,
    )


def _by_folder(frames: Sequence[tuple[Series, Frame]]) -> list[list[tuple[Series, Frame]]]:
    def folder(one: tuple[Series, Frame]) -> str:
        return one[1].name.rpartition("/")[0]

    return [list(group) for _, group in groupby(sorted(frames, key=lambda one: (folder(one), one[1].name)), key=folder)]


def _dark_evidence(rows: Sequence[Row], iso: float | None) -> Mapping[str, Evidence]:
    """Return what dark frames tell of the black level at one ISO, by channel; of ``all`` where they tell it of each."""
    own = [row for row in rows if row.quantity == "black_level" and row.iso == iso and row.region is None]
    own = [row for row in own if row.exposure_s is None and row.measured.std_error]
    told = {row.channel: row for row in own if row.method == DARK_FRAMES}
    shared = [row for row in own if row.channel == ALL and not {"offset-not-identified", "user"} & set(row.flags)]
    if told and shared:
        told[ALL] = shared[0]
    return {channel: Evidence(method=DARK_FRAMES, measured=row.measured) for channel, row in told.items()}


def _dark_current(rows: Sequence[Row], shots: IsoBursts) -> Mapping[str, Measured]:
    """Return the dark current at the ISO of some shots, by channel, unless it was warmer or colder [DN/s]."""
    return {
        row.channel: row.measured
        for row in rows
        if (row.quantity, row.measured.unit, row.iso) == ("dark_current", DN_PER_SECOND, shots.iso)
        and RECOMMENDED in row.flags
        and (
            None in {row.temperature_c, shots.temperature_c}
            or abs((row.temperature_c or 0.0) - (shots.temperature_c or 0.0)) <= SAME_TEMPERATURE_C
        )
    }


def _beside(section: Section, rows: Sequence[Row]) -> Section:
    """Give figures that other frames have told already a region of their own, and no recommendation."""
    taken = {_key(row) for row in rows if RECOMMENDED in row.flags}
    marked = tuple(
        replace(
            row,
            region=IN_A_STUDY,
            flags=tuple(flag for flag in row.flags if flag != RECOMMENDED),
        )
        if _key(row) in taken and row.region is None
        else row
        for row in section.rows
    )
    return replace(section, rows=marked)


def _key(row: Row) -> tuple[object, ...]:
    return (row.quantity, row.channel, row.measured.unit, row.iso, row.snr_threshold)


def _refuse_to_replace(study: Study, out: Path) -> None:
    target = out.resolve()
    for series in study.series:
        for frame in series.frames:
            if target in frame.header.path.resolve().parents:
                raise UsageError(f"{out} holds {frame.name}, and results would replace it; name another folder with -o")


def _describe(study: Study, options: Options, asked: ChartOptions, outcome: ChartOutcome) -> Mapping[str, object]:
    return describe(
        study,
        settings=_settings(options, asked, outcome),
        hashes={name: digest for reading in outcome.readings for name, digest in reading.hashes.items()},
        excluded=[one for reading in outcome.readings for one in reading.excluded],
        patches=[
            {"scene": scene.name, **asdict(patch)}
            for measurement in outcome.measurements
            for scene in measurement.shots.scenes
            for patch in scene.patches
        ],
    )


def _settings(options: Options, asked: ChartOptions, outcome: ChartOutcome) -> Mapping[str, object]:
    selection = options.selection
    maxima = [measurement.levels.digital_maximum for measurement in outcome.measurements]
    return {
        "chart": asked.where.chart,
        "patches": [path.name for path in asked.where.patches],
        "corners": None if asked.where.corners is None else [list(corner) for corner in asked.where.corners],
        "separate": asked.separate,
        "black_method": "legacy-offset-ratio" if asked.black.legacy else "evidence",
        "black_ratio": asked.black.ratio,
        "iso": list(selection.isos),
        "cfa": selection.cfa,
        "black_level": None if selection.black_level is None else list(selection.black_level),
        "white_level": selection.white_level,
        "crop": None if selection.crop is None else list(selection.crop),
        "digital_maximum_dn": maxima[0] if maxima else None,
        "digital_maximum_is": DIGITAL_MAXIMUM_IS,
    }
