"""Simulated frames developed for the eye, beside their raw files."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from fullwell.raw.cfa import cell
from fullwell.render.develop import develop, write_jpeg
from fullwell.simulate.config import SimulationConfig
from fullwell.simulate.files import neutral
from fullwell.simulate.plan import PlannedFrame
from fullwell.simulate.shot import Camera


def previewed(frames: Sequence[PlannedFrame]) -> frozenset[str]:
    """Return the names of the frames that a preview shows: the first of every series, and every scene."""
    first: dict[tuple[object, ...], str] = {}
    for frame in frames:
        taken = frame.exposure
        first.setdefault((frame.kind, taken.iso, taken.exposure_s, taken.subject), frame.name)
    return frozenset(first.values())


def write_preview(
    folder: Path, frame: PlannedFrame, mosaic: NDArray[np.uint16], camera: Camera, config: SimulationConfig
) -> Path:
    """Write a frame as a JPEG: black off, white balanced, demosaicked, in the colours and tones of sRGB.

    Parameters
    ----------
    folder
        The study's folder.
    frame
        What was taken.
    mosaic
        The stored mosaic [DN].
    camera, config
        What took it.

    Returns
    -------
    Path
        The file.

    """
    sensor = camera.sensor_at(frame.exposure.iso)
    linear = mosaic if camera.companding is None else camera.companding[mosaic]
    top, left, bottom, right = camera.margins.active(sensor)
    shown = develop(
        linear[top:bottom, left:right],
        cfa=sensor.cfa,
        black_level=sensor.black_level,
        white_level=(float(sensor.white_level),) * cell(sensor.cfa) ** 2,
        neutral=neutral(config),
        colour_matrix=_to_srgb(config.colour_matrix),
    )
    path = folder / f"{frame.name}.jpg"
    write_jpeg(path, shown)
    return path


def _to_srgb(mixture: NDArray[np.float64]) -> NDArray[np.float64] | None:
    """Return the way back from a camera's balanced colours to those of the light; None where there is none."""
    white = mixture.sum(axis=1, keepdims=True)
    if np.array_equal(mixture, np.eye(3)) or not np.all(white > 0.0) or abs(np.linalg.det(mixture)) < 1e-6:
        return None
    return np.linalg.inv(mixture / white)
