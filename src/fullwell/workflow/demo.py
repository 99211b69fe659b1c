"""The demo: the Pixel study with a known truth, simulated as raw files and measured through the front door."""

import json
import time
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from importlib import resources
from pathlib import Path
from typing import Final

from fullwell.figures.results import Results, Row
from fullwell.files import replaced_folder
from fullwell.findings import Finding
from fullwell.frames.selection import Selection
from fullwell.frames.series import Camera
from fullwell.glossary import RECOMMENDED
from fullwell.report.write import check_target, write_files
from fullwell.simulate.config import SimulationConfig, parse_config
from fullwell.simulate.truth import TrueValue, true_values
from fullwell.units import Measured
from fullwell.workflow.characterize import measure
from fullwell.workflow.executor import Progress
from fullwell.workflow.options import Options
from fullwell.workflow.run import run_facts
from fullwell.workflow.simulate import simulate_config

STUDY: Final = "study"
COMPARISON: Final = "demo.json"
SCHEMA: Final = "fullwell-demo/1"

_NO_ESTIMATE: Final = frozenset({"lower-bound", "upper-limit"})
_SMALLEST: Final = 1e-300


@dataclass(frozen=True, slots=True, kw_only=True)
class DemoRow:
    """One figure beside its truth.

    Parameters
    ----------
    quantity, channel, iso, method, flags
        As in the result row; ``snr_threshold`` likewise.
    recommended
        Whether the row is the one to use; legacy figures never are.
    truth
        The true value, in the unit of ``measured``.
    measured
        Value, standard error, degrees of freedom, interval.
    pull
        Error in standard errors, put on the scale of a normal number where the degrees of freedom are few: 95 % of
        them lie within -1.96 and 1.96. None where the row claims no standard error, or is a bound.

    """

    quantity: str
    channel: str
    iso: float | None
    method: str
    flags: tuple[str, ...]
    recommended: bool
    truth: float
    measured: Measured
    pull: float | None
    snr_threshold: float | None = None


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
    rows: tuple[DemoRow, ...]
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
        return tuple(row.pull for row in self.rows if row.recommended and row.pull is not None)


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
    file = resources.files("fullwell.simulate") / "cameras" / "pixel_4a.toml"
    return parse_config(file.read_text(encoding="utf-8"), name=file.name, folder=Path())


def compared(rows: Iterable[Row], truth: Iterable[TrueValue]) -> tuple[DemoRow, ...]:
    """Return every row whose truth is known beside that truth.

    Parameters
    ----------
    rows
        Measured figures; those of a region are left out.
    truth
        True values.

    """
    known = {(one.quantity, one.channel, one.unit, one.iso, one.snr_threshold): one.value for one in truth}
    found: list[DemoRow] = []
    for row in rows:
        value = known.get((row.quantity, row.channel, row.measured.unit, row.iso, row.snr_threshold))
        if value is None or row.region is not None:
            continue
        found.append(
            DemoRow(
                quantity=row.quantity,
                channel=row.channel,
                iso=row.iso,
                method=row.method,
                flags=row.flags,
                recommended=RECOMMENDED in row.flags,
                truth=value,
                measured=row.measured,
                pull=None if _NO_ESTIMATE.intersection(row.flags) else pull(row.measured, value),
                snr_threshold=row.snr_threshold,
            )
        )
    return tuple(found)


def pull(measured: Measured, truth: float) -> float | None:
    """Return the error in standard errors on the scale of a normal number; None without a standard error.

    Student's t with the measurement's degrees of freedom is mapped to the normal number of the same probability, so
    that figures with few and with many degrees of freedom can be judged alike.

    Examples
    --------
    >>> round(pull(Measured.student(12.706, 1.0, 1, "DN"), 0.0) or 0.0, 2)
    1.96

    """
    if not measured.std_error:
        return None
    t = (measured.value - truth) / measured.std_error
    if measured.dof is None:
        return t
    from scipy.special import ndtri, stdtr  # noqa: PLC0415 - loads when used

    away = -float(ndtri(max(float(stdtr(measured.dof, -abs(t))), _SMALLEST)))
    return away if t > 0.0 else -away


def _comparison(outcome: DemoOutcome) -> Mapping[str, object]:
    return {
        "schema": SCHEMA,
        "frames": outcome.frames,
        "simulated_s": round(outcome.simulated_s, 3),
        "characterized_s": round(outcome.characterized_s, 3),
        "rows": [
            {
                "quantity": row.quantity,
                "channel": row.channel,
                "iso": row.iso,
                "snr_threshold": row.snr_threshold,
                "method": row.method,
                "recommended": row.recommended,
                "flags": list(row.flags),
                "unit": row.measured.unit,
                "truth": row.truth,
                "value": row.measured.value,
                "std_error": row.measured.std_error,
                "dof": row.measured.dof,
                "pull": row.pull,
            }
            for row in outcome.rows
        ],
    }
