"""Simulated studies for tests: real files with a known truth, small and quick."""

from collections.abc import Mapping
from pathlib import Path
from typing import Final

from fullwell.simulate.config import SimulationConfig, config_from
from fullwell.workflow.simulation.simulate import SimulatedStudy, simulate_config

SMALL_CAMERA: Final[Mapping[str, object]] = {
    "width": 192,
    "height": 128,
    "cfa": "BGGR",
    "bit_depth": 12,
    "black_level": 256,
    "white_level": 4095,
    "base_iso": 100,
    "system_gain": 0.5,
    "full_well": 7000.0,
    "read_noise": 2.5,
    "read_noise_row": 0.3,
    "dark_current": 4.0,
    "dsnu": 1.0,
    "prnu": 0.6,
    "channel_response": {"R": 0.5, "G1": 1.0, "G2": 1.0, "B": 0.6},
}
SMALL_STUDY: Final[Mapping[str, object]] = {
    "isos": [100],
    "flat": {"exposures_s": [0.001, 0.002, 0.004], "electrons": [1000.0, 2000.0, 4000.0], "frames": 3},
    "dark": {"exposures_s": [0.5, 1.0, 2.0], "frames": 3},
    "bias": {"exposures_s": [0.0001], "frames": 5},
}


def simulation(
    *,
    seed: int = 1,
    camera: Mapping[str, object] | None = None,
    lens: Mapping[str, object] | None = None,
    chart: Mapping[str, object] | None = None,
    study: Mapping[str, object] | None = None,
    output: Mapping[str, object] | None = None,
) -> SimulationConfig:
    """Return a config of a small camera and study, some keys changed.

    Parameters
    ----------
    seed
        Key of every random number: another seed is another camera of the same make.
    camera, lens, chart, output
        Keys of the tables of RESULTS 6 to change.
    study
        The study; None is a small one with flats, darks and bias frames at one ISO.

    Raises
    ------
    UsageError
        Where a key or value is not allowed.

    """
    document: dict[str, object] = {
        "seed": seed,
        "camera": {**SMALL_CAMERA, **(camera or {})},
        "lens": dict(lens or {}),
        "chart": dict(chart or {}),
        "study": dict(SMALL_STUDY if study is None else study),
        "output": dict(output or {}),
    }
    return config_from(document, name="test simulation", folder=Path())


def simulated_study(folder: Path, config: SimulationConfig | None = None, *, workers: int = 1) -> SimulatedStudy:
    """Write a simulated study as raw files.

    Parameters
    ----------
    folder
        Folder to write; missing or empty.
    config
        What to simulate; None is `simulation()`.
    workers
        Threads.

    Returns
    -------
    SimulatedStudy
        The folder, its config (and with it the truth: `fullwell.simulate.truth.true_values`) and its frames.

    """
    return simulate_config(simulation() if config is None else config, folder, workers=workers)
