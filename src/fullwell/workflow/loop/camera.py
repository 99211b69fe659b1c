"""One turn of the loop: a camera is simulated as raw files, and measured through the front door."""

import time
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from fullwell.frames.selection import Selection
from fullwell.frames.series import Camera
from fullwell.simulate.config import SimulationConfig
from fullwell.simulate.truth import true_values
from fullwell.workflow.characterize import measure
from fullwell.workflow.executor import Progress
from fullwell.workflow.loop.comparison import Comparison, compared
from fullwell.workflow.options import Options
from fullwell.workflow.simulation.simulate import simulate_config
from fullwell.workflow.spanning import Measurement

STUDY: Final = "study"
"""Folder of the simulated frames."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Turn:
    """What one simulated camera came to.

    Parameters
    ----------
    seed
        The camera's: its fixed patterns and all of its noise.
    frames
        Raw files written.
    compared
        Every measured figure whose truth is known, in the order of the results.
    measurement
        Everything the measurement found.
    simulated_s
        How long writing took [s].

    """

    seed: int
    frames: int
    compared: tuple[Comparison, ...]
    measurement: Measurement
    simulated_s: float


def turn(
    config: SimulationConfig, frames: Path, *, options: Options, progress: Progress | None, out: Path | None = None
) -> Turn:
    """Simulate a camera and measure it.

    Parameters
    ----------
    config
        What is simulated.
    frames
        Folder for the raw files; missing or empty.
    options
        Of the measurement.
    progress
        Told of every frame, once while they are written and once while they are measured.
    out
        Where maps and tables are written; None writes neither, and takes no pictures.

    """
    began = time.monotonic()
    simulated = simulate_config(config, frames, workers=options.workers, progress=progress)
    simulated_s = time.monotonic() - began
    measurement = measure(frames, options=options, progress=progress, folder=out, beside=frames.parent)
    return Turn(
        seed=config.seed,
        frames=len(simulated.frames),
        compared=compared(measurement.results.rows, true_values(config)),
        measurement=measurement,
        simulated_s=simulated_s,
    )


def options_for(config: SimulationConfig, *, workers: int) -> Options:
    """Return how a simulated camera is measured: told the facts that its raw files do not carry."""
    return Options(selection=Selection(camera=camera_of(config)), workers=workers)


def camera_of(config: SimulationConfig) -> Camera:
    """Return the facts about a simulated camera that its raw files do not carry."""
    return Camera(
        pixel_pitch_um=config.sensor.pixel_pitch_um,
        voltage_swing_v=config.voltage_swing_v,
        base_iso=config.sensor.base_iso,
        focal_length_mm=config.lens.focal_length_mm,
    )
