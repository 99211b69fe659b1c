"""The verb: a measured, described or published camera is simulated, measured again, and judged by its truth."""

import json
import shutil
import time
from collections.abc import Mapping
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Final

from fullwell.figures.calibration import Calibration
from fullwell.figures.results import Results
from fullwell.files import replaced_folder
from fullwell.findings import worst_first
from fullwell.report.document import plain
from fullwell.report.write import check_target, write_files
from fullwell.workflow.executor import Progress
from fullwell.workflow.loop.camera import STUDY, Turn, options_for, turn
from fullwell.workflow.loop.comparison import Comparison, Figure, pulls_of
from fullwell.workflow.loop.curves import Record, figure_records, loop_curves, originals_of
from fullwell.workflow.loop.design import Design, design_of
from fullwell.workflow.loop.repeats import repeats_of, run_repeats
from fullwell.workflow.loop.source import Source, source_of
from fullwell.workflow.loop.tally import Tally, shares_of
from fullwell.workflow.loop.verdict import loop_findings
from fullwell.workflow.run import run_facts

DOCUMENT: Final = "loop.json"
SCHEMA: Final = "fullwell-loop/1"
REPEATS: Final = "repeats"
"""Folder of the frames of further cameras, where they are kept."""


@dataclass(frozen=True, slots=True, kw_only=True)
class LoopOptions:
    """What a loop is asked to do.

    Parameters
    ----------
    repeats
        Cameras: the first is reported in full, all are counted.
    full
        Whether frames are as large as the source's.
    keep
        Whether the raw files stay.
    seed
        Of the first camera; None for the source's.
    workers
        Threads for the first camera, processes for the others; no figure depends on their number.

    """

    repeats: int = 1
    full: bool = False
    keep: bool = False
    seed: int | None = None
    workers: int = 1


@dataclass(frozen=True, slots=True, kw_only=True)
class LoopOutcome:
    """What a loop found.

    Parameters
    ----------
    source, design
        Where it started, and what was simulated.
    cameras
        Their number.
    compared
        Every figure of the first camera whose truth is known.
    found
        What all cameras tell of each.
    results
        The first camera's, with the findings and curves of the loop.

    """

    source: Source
    design: Design
    cameras: int
    compared: tuple[Comparison, ...]
    found: Mapping[Figure, Calibration]
    results: Results

    @property
    def pulls(self) -> tuple[float, ...]:
        """Pulls of the first camera's recommended figures."""
        return pulls_of(self.compared)


def loop(what: Path, out: Path, *, options: LoopOptions, progress: Progress | None = None) -> LoopOutcome:
    """Simulate a camera in the design it was measured in, measure it again, and lay both beside the truth.

    Parameters
    ----------
    what
        Where to start, as `source_of` reads it.
    out
        Folder for the results of the first camera, ``loop.json`` and, if kept, the frames; a missing or empty one, or
        one that holds results of ours, which is replaced.
    options
        How many cameras, and how large.
    progress
        Told of every frame of the first camera, then of the cameras' frames as they are measured.

    Raises
    ------
    UsageError
        Where there is nothing to start from, or ``out`` must not be replaced.

    """
    check_target(out)
    started = time.monotonic()
    source = source_of(what)
    if options.seed is not None:
        source = replace(source, config=source.config.with_seed(options.seed))
    design = design_of(source.config, full=options.full)
    with replaced_folder(out) as folder:
        measuring = options_for(design.config, workers=options.workers)
        first = turn(design.config, folder / STUDY, options=measuring, progress=progress, out=folder)
        if not options.keep:
            shutil.rmtree(folder / STUDY)
        tally = _all_cameras(first, design, options, folder, progress)
        run = run_facts(study=out / STUDY, out=out, options=measuring, started=started)
        outcome, records = _outcome(source, design, first, tally)
        outcome = replace(outcome, results=replace(outcome.results, run=run))
        write_files(outcome.results, folder, pictures=first.measurement.pictures)
        text = json.dumps(plain(_document(outcome, records)), indent=1, allow_nan=False) + "\n"
        (folder / DOCUMENT).write_text(text, encoding="utf-8", newline="\n")
    return outcome


def _all_cameras(first: Turn, design: Design, options: LoopOptions, folder: Path, progress: Progress | None) -> Tally:
    """Return what all cameras came to, the first among them."""
    tally = Tally()
    tally.add(shares_of(first.compared))
    repeats = repeats_of(design.config, options.repeats, folder=folder / REPEATS, keep=options.keep)
    if progress is not None and repeats:
        progress.start(len(repeats) * design.frames)

    def done() -> None:
        if progress is not None:
            progress.advance(design.frames)

    for shares in run_repeats(repeats, workers=options.workers, done=done):
        tally.add(shares)
    if not options.keep:
        shutil.rmtree(folder / REPEATS, ignore_errors=True)
    return tally


def _outcome(source: Source, design: Design, first: Turn, tally: Tally) -> tuple[LoopOutcome, list[Record]]:
    found = tally.calibrations()
    records = figure_records(first.compared, originals_of(source), found)
    said = loop_findings(source, design, first.compared, found, cameras=tally.turns)
    measured = first.measurement.results
    curves = (*loop_curves(records, first, tally, source, design.config), *measured.curves)
    outcome = LoopOutcome(
        source=source,
        design=design,
        cameras=tally.turns,
        compared=first.compared,
        found=found,
        results=replace(measured, findings=worst_first((*said, *measured.findings)), curves=curves),
    )
    return outcome, records


def _document(outcome: LoopOutcome, records: list[Record]) -> Mapping[str, object]:
    design, source = outcome.design, outcome.source
    return {
        "schema": SCHEMA,
        "source": source.name,
        "source_is": source.kind,
        "said": source.said,
        "seed": design.config.seed,
        "cameras": outcome.cameras,
        "design": {
            "width": design.size[0],
            "height": design.size[1],
            "original_width": design.original_size[0],
            "original_height": design.original_size[1],
            "frames": design.frames,
        },
        "camera": {"name": design.config.name, **asdict(design.config.sensor)},
        "figures": records,
    }
