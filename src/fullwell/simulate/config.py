"""A simulation config: TOML at the edge, frozen parameters inside.

A bad config is one sentence that names the key, its value and what is allowed.
"""

import tomllib
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import cast

import numpy as np
from numpy.typing import NDArray
from pydantic import ValidationError

from fullwell.errors import UsageError
from fullwell.model.sensor import SensorParameters
from fullwell.raw.cfa import cell, channels
from fullwell.simulate import optics
from fullwell.simulate.explanation import explained
from fullwell.simulate.scene import SUBJECTS
from fullwell.simulate.tables import ConfigTable, OutputTable, StudyTable


@dataclass(frozen=True, slots=True, kw_only=True)
class Lens:
    """A lens.

    Parameters
    ----------
    shading
        ``none``, ``cos4``, or the path of a map.
    exponents
        Power of the fall-off per CFA site, row-major [1].
    focal_length_mm
        Distance of the exit pupil [mm].
    flare
        Stray light as a fraction of the largest signal [1].

    """

    shading: str
    exponents: tuple[float, ...]
    focal_length_mm: float
    flare: float

    def map_for(self, sensor: SensorParameters) -> NDArray[np.float32]:
        """Return relative illumination times response of each pixel, shape (height, width) [1]."""
        if self.shading == "none":
            return optics.even(sensor)
        if self.shading == "cos4":
            return optics.cos4(sensor, focal_length_mm=self.focal_length_mm, exponents=self.exponents)
        return optics.mapped(sensor, Path(self.shading))


@dataclass(frozen=True, slots=True, kw_only=True)
class SimulationConfig:
    """What is simulated: a camera, a lens, a study and the files it is written as.

    Parameters
    ----------
    seed
        Key of every random number.
    name
        Name of the camera.
    sensor, lens
        Parameters.
    voltage_swing_v
        Voltage at the white level, None where nobody gave it [V].
    study, output
        Tables as the file has them.

    """

    seed: int
    name: str
    sensor: SensorParameters
    lens: Lens
    voltage_swing_v: float | None
    study: StudyTable
    output: OutputTable

    def halved(self) -> "SimulationConfig":
        """Return the same camera seen through a quarter of the pixels, each twice as wide: the same field of view."""
        sensor = self.sensor
        smaller = replace(
            sensor,
            width=sensor.width // 4 * 2,
            height=sensor.height // 4 * 2,
            pixel_pitch_um=2.0 * sensor.pixel_pitch_um,
        )
        return replace(self, sensor=smaller)


def read_config(path: Path) -> SimulationConfig:
    """Read a config file.

    Raises
    ------
    UsageError
        Where the file cannot be read, or says something that is not allowed.

    """
    try:
        text = path.read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as error:
        raise UsageError(f"The config {path} cannot be read: {error}.") from error
    return parse_config(text, name=str(path), folder=path.parent)


def parse_config(text: str, *, name: str, folder: Path) -> SimulationConfig:
    """Read a config from its text.

    Parameters
    ----------
    text
        TOML.
    name
        What to call the config in a sentence about it.
    folder
        What the path of a shading map is relative to.

    Raises
    ------
    UsageError
        Where it says something that is not allowed.

    """
    try:
        document = tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        raise UsageError(f"{name} is not TOML: {error}.") from error
    return config_from(document, name=name, folder=folder)


def config_from(document: Mapping[str, object], *, name: str, folder: Path) -> SimulationConfig:
    """Read a config from its tables, as `parse_config` does from its text."""
    try:
        table = ConfigTable.model_validate(document)
    except ValidationError as error:
        raise UsageError(explained(error, name=name)) from error
    _require_levels(table, name)
    _require_study(table, name)
    camera, lens = table.camera, table.lens
    sites = channels(camera.cfa)
    response = cast("Mapping[str, float]", camera.channel_response.model_dump())
    exponent = cast("Mapping[str, float]", lens.shading_exponent.model_dump())
    shading = lens.shading if lens.shading in {"none", "cos4"} else str(folder / lens.shading)
    return SimulationConfig(
        seed=table.seed,
        name=camera.name,
        sensor=SensorParameters(
            width=camera.width,
            height=camera.height,
            cfa=camera.cfa,
            bit_depth=camera.bit_depth,
            black_level=_black_levels(table),
            white_level=_white_level(table),
            base_iso=float(camera.base_iso),
            system_gain=camera.system_gain,
            full_well=camera.full_well,
            response=tuple(response[channel] for channel in sites),
            read_noise=camera.read_noise,
            read_noise_row=camera.read_noise_row,
            read_noise_column=camera.read_noise_column,
            read_noise_frame=camera.read_noise_frame,
            read_noise_post=camera.read_noise_post,
            dark_current=camera.dark_current,
            dsnu=camera.dsnu,
            prnu=camera.prnu / 100.0,
            pixel_pitch_um=camera.pixel_pitch_um,
        ),
        lens=Lens(
            shading=shading,
            exponents=tuple(exponent[channel] for channel in sites),
            focal_length_mm=lens.focal_length_mm,
            flare=lens.flare,
        ),
        voltage_swing_v=camera.voltage_swing_v,
        study=table.study,
        output=table.output,
    )


def _black_levels(table: ConfigTable) -> tuple[float, ...]:
    black = table.camera.black_level
    sites = cell(table.camera.cfa) ** 2
    return tuple(black) if isinstance(black, list) else (float(black),) * sites


def _white_level(table: ConfigTable) -> int:
    return table.camera.white_level or 2**table.camera.bit_depth - 1


def _require_levels(table: ConfigTable, name: str) -> None:
    camera = table.camera
    most = 2**camera.bit_depth - 1
    white, black = _white_level(table), _black_levels(table)
    if white > most:
        raise UsageError(
            f"{name}: camera.white_level = {white} does not fit {camera.bit_depth} bits; allowed: up to {most} DN."
        )
    if max(black) >= white:
        raise UsageError(
            f"{name}: camera.black_level = {camera.black_level} is not below camera.white_level = {white}; "
            f"allowed: from 0 to below {white} DN."
        )
    if len(black) != cell(camera.cfa) ** 2:
        raise UsageError(
            f"{name}: camera.black_level = {camera.black_level} has {len(black)} numbers; allowed for {camera.cfa}: "
            f"one number, or a list of {cell(camera.cfa) ** 2}."
        )
    for key, size in (("width", camera.width), ("height", camera.height)):
        if size % cell(camera.cfa):
            raise UsageError(f"{name}: camera.{key} = {size} is odd; allowed for {camera.cfa}: even numbers.")


def _require_study(table: ConfigTable, name: str) -> None:
    study, output = table.study, table.output
    if not (study.flat or study.dark or study.bias or study.scene):
        raise UsageError(f"{name}: [study] takes no frames; give it at least one of flat, dark, bias and scene.")
    if study.flat and len(study.flat.exposures_s) != len(study.flat.electrons):
        raise UsageError(
            f"{name}: study.flat.electrons = {study.flat.electrons} has {len(study.flat.electrons)} numbers; "
            f"allowed: one per exposure, {len(study.flat.exposures_s)}."
        )
    if len(set(study.isos)) != len(study.isos):
        raise UsageError(f"{name}: study.isos = {study.isos} names an ISO twice; allowed: each once.")
    for subject in study.scene.subjects if study.scene else ():
        if subject not in SUBJECTS:
            known = ", ".join(sorted(SUBJECTS))
            raise UsageError(f'{name}: study.scene.subjects holds "{subject}"; allowed: {known}.')
    if output.compression != "none" and output.format != "dng":
        raise UsageError(
            f'{name}: output.compression = "{output.compression}" does not go with format "{output.format}"; '
            'allowed: "none".'
        )
