"""Simulated mosaics as raw files: DNG with its tags, or TIFF and headerless files with a JSON sidecar."""

import sys
from pathlib import Path
from typing import Final

import numpy as np
from numpy.typing import NDArray

from fullwell.frames.sidecar_writing import sidecar_path, sidecar_text
from fullwell.model.conversions import noise_profile_offset, noise_profile_scale
from fullwell.raw.cfa import MONO, channels
from fullwell.raw.image import D65, ColourMatrix
from fullwell.raw.write import XYZ_TO_SRGB, DngExtras, write_dng
from fullwell.simulate.adc import companding_table
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
        Codes, shape of the stored mosaic, uint16 [DN].
    config
        Camera and format.
    taken
        How it was taken.

    Returns
    -------
    Path
        The file.

    """
    path = folder / f"{name}{suffix(config)}"
    path.parent.mkdir(parents=True, exist_ok=True)
    sensor, output = config.sensor_at(taken.iso), config.output
    if output.format == "dng":
        write_dng(
            path,
            mosaic,
            cfa=sensor.cfa,
            black_level=sensor.black_level,
            white_level=sensor.white_level,
            bit_depth=output.companding_bits or sensor.bit_depth,
            iso=taken.iso,
            exposure_s=taken.exposure_s,
            compression=output.compression,
            model=config.name,
            extras=_extras(config, taken),
        )
        return path
    if output.format == "tiff":
        _write_tiff(path, mosaic)
    else:
        path.write_bytes(mosaic.astype("<u2").tobytes())
    sidecar_path(path).write_text(_sidecar(config, taken), encoding="utf-8")
    return path


def neutral(config: SimulationConfig) -> tuple[float, float, float]:
    """Return what white light comes to in the camera's R, G and B, the largest 1; all 1 without colours [1]."""
    sensor = config.sensor
    if sensor.cfa == MONO:
        return (1.0, 1.0, 1.0)
    response = dict(zip(channels(sensor.cfa), sensor.response, strict=True))
    red, green, blue = np.maximum(config.colour_matrix.sum(axis=1), 0.0).tolist()
    white = (red * response["R"], green * 0.5 * (response["G1"] + response["G2"]), blue * response["B"])
    most = max(white)
    return (white[0] / most, white[1] / most, white[2] / most) if min(white) > 0.0 else (1.0, 1.0, 1.0)


def noise_profile(config: SimulationConfig, taken: Exposure) -> tuple[tuple[float, float], ...]:
    """Return S and O of the tag NoiseProfile: the temporal noise of the pixel, rounding included (DNG)."""
    sensor = config.sensor_at(taken.iso)
    system_gain = sensor.system_gain_at(taken.iso)
    signal_range = sensor.white_level - sum(sensor.black_level) / len(sensor.black_level)
    unlit = (sensor.dark_noise_at(taken.iso, taken.exposure_s, taken.temperature_c) * system_gain) ** 2 + 1.0 / 12.0
    pair = (
        noise_profile_scale(system_gain, signal_range=signal_range),
        noise_profile_offset(unlit, signal_range=signal_range),
    )
    return (pair,)


def _extras(config: SimulationConfig, taken: Exposure) -> DngExtras:
    sensor, margins, bits = config.sensor, config.margins, config.output.companding_bits
    to_camera = (config.colour_matrix @ np.reshape(XYZ_TO_SRGB, (3, 3))).ravel().tolist()
    return DngExtras(
        active_area=None if margins.none else margins.active(sensor),
        masked_areas=() if margins.none else margins.masked(sensor),
        noise_profile=noise_profile(config, taken) if config.output.noise_profile else (),
        linearization_table=() if bits is None else tuple(companding_table(sensor, bits).tolist()),
        temperature_c=taken.temperature_c,
        colour_matrix=None if config.table.camera.colour_matrix is None else ColourMatrix(tuple(to_camera), D65),
        as_shot_neutral=neutral(config),
    )


def _write_tiff(path: Path, mosaic: NDArray[np.uint16]) -> None:
    import tifffile  # noqa: PLC0415 - loads when used

    tifffile.imwrite(path, mosaic, photometric="minisblack", byteorder="<" if sys.byteorder == "little" else ">")


def _sidecar(config: SimulationConfig, taken: Exposure) -> str:
    sensor = config.sensor_at(taken.iso)
    return sidecar_text(
        cfa=sensor.cfa,
        bit_depth=sensor.bit_depth,
        width=sensor.width,
        height=sensor.height,
        black_level=sensor.black_level,
        white_level=(sensor.white_level,),
        iso=taken.iso,
        exposure_s=taken.exposure_s,
        temperature_c=taken.temperature_c,
    )
