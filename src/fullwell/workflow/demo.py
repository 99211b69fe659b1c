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
from fullwell.frames.selection import Selection
from fullwell.frames.series import Camera
from fullwell.report.write import check_target, write_files
from fullwell.simulate.config import SimulationConfig, shipped_config
from fullwell.simulate.truth import true_values
from fullwell.workflow.characterize import measure
from fullwell.workflow.executor import Progress
from fullwell.workflow.loop.comparison import Comparison, compared, pulls_of
from fullwell.workflow.options import Options
from fullwell.workflow.run import run_facts
from fullwell.workflow.simulate import simulate_config

STUDY: Final = "study"
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
    options = Options(selection=Selection(camera=camera_of(config)), workers=workers)
    with replaced_folder(out) as folder:
        began = time.monotonic()
        simulated = simulate_config(config, folder / STUDY, workers=workers, progress=progress)
        between = time.monotonic()
        measurement = measure(folder / STUDY, options=options, progress=progress, folder=folder)
        run = run_facts(study=out / STUDY, out=out, options=options, started=between)
        results = replace(measurement.results, run=run)
        write_files(results, folder, pictures=measurement.pictures)
        outcome = DemoOutcome(
            out=out,
            frames=len(simulated.frames),
            rows=compared(results.rows, true_values(config)),
            results=results,
            simulated_s=between - began,
            characterized_s=time.monotonic() - between,
        )
        comparison = json.dumps(_comparison(outcome), indent=1) + "\n"
        (folder / COMPARISON).write_text(comparison, encoding="utf-8", newline="\n")
    return outcome


def camera_of(config: SimulationConfig) -> Camera:
    """Return the facts about a simulated camera that its raw files do not carry."""
    return Camera(
        pixel_pitch_um=config.sensor.pixel_pitch_um,
        voltage_swing_v=config.voltage_swing_v,
        base_iso=config.sensor.base_iso,
        focal_length_mm=config.lens.focal_length_mm,
    )


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
