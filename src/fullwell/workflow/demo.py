"""The demo: the Pixel study with a known truth, simulated as raw files and measured through the front door."""

import json
import time
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Final

from fullwell.figures.results import Results
from fullwell.files import replaced_folder
from fullwell.findings import Finding
from fullwell.report.write import check_target, write_files
from fullwell.simulate.config import SimulationConfig, shipped_config
from fullwell.workflow.executor import Progress
from fullwell.workflow.loop.camera import STUDY, options_for, turn
from fullwell.workflow.loop.comparison import Comparison, pulls_of
from fullwell.workflow.run import run_facts

COMPARISON: Final = "demo.json"
SCHEMA: Final = "fullwell-demo/1"


@dataclass(frozen=True, slots=True, kw_only=True)
class DemoOutcome:
    """What the demo found.

    Parameters
    ----------
    out
        Folder with the report, the comparison and the simulated study.
    frames
        Raw files written.
    rows
        Every measured figure whose truth is known, in the order of the results.
    results
        Everything the measurement found.
    simulated_s, characterized_s
        How long writing and measuring took [s].

    """

    out: Path
    frames: int
    rows: tuple[Comparison, ...]
    results: Results
    simulated_s: float
    characterized_s: float

    @property
    def findings(self) -> tuple[Finding, ...]:
        """What is to be said about the data."""
        return self.results.findings

    @property
    def pulls(self) -> tuple[float, ...]:
        """Pulls of the recommended rows."""
        return pulls_of(self.rows)


def run_demo(out: Path, *, full: bool = False, workers: int, progress: Progress | None = None) -> DemoOutcome:
    """Simulate the Pixel study, measure it, and lay truth and measurement side by side.

    Parameters
    ----------
    out
        Folder for results, report, ``demo.json`` and the simulated ``study``; a missing or empty one, or one that
        holds results of ours, which is replaced.
    full
        The real size; by default a quarter of the pixels, with the same field of view.
    workers
        Threads; no figure depends on their number.
    progress
        Told of every frame, once while they are written and once while they are measured.

    Raises
    ------
    UsageError
        Where ``out`` must not be replaced.

    """
    check_target(out)
    config = pixel_study() if full else pixel_study().halved()
    options = options_for(config, workers=workers)
    with replaced_folder(out) as folder:
        began = time.monotonic()
        found = turn(config, folder / STUDY, options=options, progress=progress, out=folder)
        between = began + found.simulated_s
        run = run_facts(study=out / STUDY, out=out, options=options, started=between)
        results = replace(found.measurement.results, run=run)
        write_files(results, folder, pictures=found.measurement.pictures)
        outcome = DemoOutcome(
            out=out,
            frames=found.frames,
            rows=found.compared,
            results=results,
            simulated_s=found.simulated_s,
            characterized_s=time.monotonic() - between,
        )
        comparison = json.dumps(_comparison(outcome), indent=1) + "\n"
        (folder / COMPARISON).write_text(comparison, encoding="utf-8", newline="\n")
    return outcome


def pixel_study() -> SimulationConfig:
    """Return the published study of the Pixel 4a as a config (RESULTS 6)."""
    return shipped_config("pixel-4a")


def _comparison(outcome: DemoOutcome) -> Mapping[str, object]:
    return {
        "schema": SCHEMA,
        "frames": outcome.frames,
        "simulated_s": round(outcome.simulated_s, 3),
        "characterized_s": round(outcome.characterized_s, 3),
        "rows": [
            {
                "quantity": one.row.quantity,
                "channel": one.row.channel,
                "iso": one.row.iso,
                "snr_threshold": one.row.snr_threshold,
                "method": one.row.method,
                "recommended": one.recommended,
                "flags": list(one.row.flags),
                "unit": one.row.measured.unit,
                "truth": one.truth,
                "value": one.row.measured.value,
                "std_error": one.row.measured.std_error,
                "dof": one.row.measured.dof,
                "pull": one.pull,
            }
            for one in outcome.rows
        ],
    }
