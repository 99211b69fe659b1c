"""Simulated mosaics as raw files: DNG with its tags, or TIFF and headerless files with a JSON sidecar."""

import json
import sys
from pathlib import Path
from typing import Final

import numpy as np
from numpy.typing import NDArray

from fullwell.frames.sidecar import PIXEL_FORMATS
from fullwell.raw.write import write_dng
from fullwell.simulate.config import SimulationConfig
from fullwell.simulate.shot import Exposure

_SUFFIXES: Final = {"dng": ".dng", "tiff": ".tiff", "headerless": ".raw"}


def suffix(config: SimulationConfig) -> str:
    """Return the suffix of the frames' files."""
    return _SUFFIXES[config.output.format]


def write_frame(folder: Path, name: str, mosaic: NDArray[np.uint16], config: SimulationConfig, taken: Exposure) -> Path:
    """Write one frame, and its sidecar where the format has no tags.

    Parameters
    ----------
    folder
        The study's folder.
    name
        The frame's path below it, without a suffix.
    mosaic
        Codes, shape (height, width), uint16 [DN].
    config
        Camera and format.
    taken
        ISO and exposure.

    Returns
    -------
    Path
        The file.

    """
    path = folder / f"{name}{suffix(config)}"
    path.parent.mkdir(parents=True, exist_ok=True)
    sensor = config.sensor
    if config.output.format == "dng":
        write_dng(
            path,
            mosaic,
            cfa=sensor.cfa,
            black_level=sensor.black_level,
            white_level=sensor.white_level,
            bit_depth=sensor.bit_depth,
            iso=taken.iso,
            exposure_s=taken.exposure_s,
            compression=config.output.compression,
            model=config.name,
        )
        return path
    if config.output.format == "tiff":
        _write_tiff(path, mosaic)
    else:
        path.write_bytes(mosaic.astype("<u2").tobytes())
    sidecar = json.dumps(_facts(config, taken), indent=1) + "\n"
    path.with_name(f"{path.name.removesuffix(path.suffix)}.json").write_text(sidecar, encoding="utf-8")
    return path


def _write_tiff(path: Path, mosaic: NDArray[np.uint16]) -> None:
    import tifffile  # noqa: PLC0415 - loads when used

    tifffile.imwrite(path, mosaic, photometric="minisblack", byteorder="<" if sys.byteorder == "little" else ">")


def _facts(config: SimulationConfig, taken: Exposure) -> dict[str, object]:
    """Return what a sidecar says, by GenICam names."""
    sensor = config.sensor
    facts: dict[str, object] = {
        "PixelFormat": f"{PIXEL_FORMATS[sensor.cfa]}{sensor.bit_depth}",
        "Width": sensor.width,
        "Height": sensor.height,
        "ExposureTime": taken.exposure_s * 1e6,
        "ISO": taken.iso,
        "WhiteLevel": sensor.white_level,
    }
    if len(set(sensor.black_level)) == 1:
        facts["BlackLevel"] = sensor.black_level[0]
    return facts
