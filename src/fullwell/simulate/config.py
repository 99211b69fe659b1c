"""A simulation config: TOML at the edge, frozen parameters inside.

A bad config is one sentence that names the key, its value and what is allowed.
"""

import tomllib
from collections.abc import Mapping
from dataclasses import dataclass, replace
from importlib import resources
from pathlib import Path
from typing import Final

import numpy as np
from pydantic import ValidationError

from fullwell.errors import UsageError, why
from fullwell.model.sensor import SensorParameters
from fullwell.simulate.chart import Painting, painted
from fullwell.simulate.explanation import explained
from fullwell.simulate.geometry import Margins
from fullwell.simulate.lens import Lens, lens_of
from fullwell.simulate.pictures import SUFFIXES, FloatArray, read_light
from fullwell.simulate.requirements import require_consistent
from fullwell.simulate.sensors import base_sensor, sensor_at
from fullwell.simulate.tables import ConfigTable, OutputTable, StudyTable

CAMERAS: Final = {
    "pixel-4a": "pixel_4a.toml",
    "sony-a6000": "sony_a6000.toml",
    "sony-emva": "sony_emva.toml",
    "imx541": "imx541.toml",
}
"""Configs that come with Fullwell, by what the command line calls them."""


@dataclass(frozen=True, slots=True, kw_only=True)
class SimulationConfig:
    """What is simulated: a camera, a lens, a study and the files it is written as.

    Parameters
    ----------
    table
        The config as its file has it.
    folder
        What paths in it are relative to.

    """

    table: ConfigTable
    folder: Path = Path()

    @property
    def seed(self) -> int:
        """Key of every random number."""
        return self.table.seed

    @property
    def name(self) -> str:
        """Name of the camera."""
        return self.table.camera.name

    @property
    def sensor(self) -> SensorParameters:
        """Parameters at the base ISO."""
        return base_sensor(self.table.camera)

    def sensor_at(self, iso: float) -> SensorParameters:
        """Return the parameters at an ISO: those of the base ISO but for what ``[[camera.at_iso]]`` says."""
        return sensor_at(self.table.camera, iso)

    @property
    def lens(self) -> Lens:
        """What is in front of the sensor."""
        return lens_of(self.table.lens, self.table.camera, folder=self.folder)

    @property
    def chart(self) -> Painting | None:
        """What frames of a chart show; None where the study has none."""
        charted = self.study.chart or any(series.kind == "chart" for series in self.study.series)
        return painted(self.table.chart, self.table.camera, folder=self.folder) if charted else None

    @property
    def margins(self) -> Margins:
        """Optical-black pixels."""
        black = self.output.optical_black
        return Margins(left=black.left, top=black.top, right=black.right, bottom=black.bottom)

    @property
    def pictures(self) -> Mapping[str, FloatArray]:
        """Light of every scene that is a picture, by the path the config has."""
        study = self.study
        named = [*(study.scene.subjects if study.scene else ()), *(one.subject for one in study.series if one.subject)]
        return {name: read_light(self.folder / name) for name in named if name.lower().endswith(SUFFIXES)}

    @property
    def colour_matrix(self) -> FloatArray:
        """Red, green and blue of the camera from those of the light, shape (3, 3) [1]."""
        stated = self.table.camera.colour_matrix
        return np.eye(3) if stated is None else np.array(stated, dtype=np.float64)

    @property
    def voltage_swing_v(self) -> float | None:
        """Voltage at the white level, None where nobody gave it [V]."""
        return self.table.camera.voltage_swing_v

    @property
    def study(self) -> StudyTable:
        """What is taken."""
        return self.table.study

    @property
    def isos(self) -> tuple[int, ...]:
        """Every ISO that frames are taken at, in the order of the config."""
        study = self.study
        listed = study.isos if study.flat or study.dark or study.bias or study.chart or study.scene else []
        return tuple(dict.fromkeys([*listed, *(series.iso for series in study.series)]))

    @property
    def output(self) -> OutputTable:
        """What files are written."""
        return self.table.output

    def with_seed(self, seed: int) -> "SimulationConfig":
        """Return another camera of the same make."""
        return replace(self, table=self.table.model_copy(update={"seed": seed}))

    def halved(self) -> "SimulationConfig":
        """Return the same camera seen through a quarter of the pixels, each twice as wide: the same field of view."""
        camera = self.table.camera
        smaller = camera.model_copy(
            update={
                "width": camera.width // 4 * 2,
                "height": camera.height // 4 * 2,
                "pixel_pitch_um": 2.0 * camera.pixel_pitch_um,
            }
        )
        return replace(self, table=self.table.model_copy(update={"camera": smaller}))


def read_config(path: Path) -> SimulationConfig:
    """Read a config file.

    Raises
    ------
    UsageError
        Where the file cannot be read, or says something that is not allowed.

    """
    return config_from(config_tables(path), name=str(path), folder=path.parent)


def config_tables(path: Path) -> Mapping[str, object]:
    """Return the tables of a TOML file.

    Raises
    ------
    UsageError
        Where it cannot be read, or is not TOML.

    """
    try:
        return tomllib.loads(path.read_text(encoding="utf-8-sig"))
    except (OSError, UnicodeDecodeError) as error:
        raise UsageError(f"The config {path} cannot be read: {why(error)}.") from error
    except tomllib.TOMLDecodeError as error:
        raise UsageError(f"{path} is not TOML: {error}.") from error


def shipped_text(camera: str) -> str:
    """Return the text of a config that comes with Fullwell.

    Raises
    ------
    UsageError
        Where there is no such camera.

    """
    if camera not in CAMERAS:
        raise UsageError(f'There is no camera "{camera}"; Fullwell comes with {", ".join(CAMERAS)}.')
    return (resources.files("fullwell.simulate") / "cameras" / CAMERAS[camera]).read_text(encoding="utf-8")


def shipped_summary(camera: str) -> str:
    """Return the first sentence of a shipped config's own description."""
    comment = " ".join(line.removeprefix("#").strip() for line in shipped_text(camera).split("\nseed")[0].splitlines())
    return comment.split(": ")[0].split(", as ")[0].rstrip(".") + "."


def shipped_config(camera: str) -> SimulationConfig:
    """Return a config that comes with Fullwell, as `shipped_text` has it."""
    return parse_config(shipped_text(camera), name=CAMERAS.get(camera, camera), folder=Path())


def parse_config(text: str, *, name: str, folder: Path) -> SimulationConfig:
    """Read a config from its text.

    Parameters
    ----------
    text
        TOML.
    name
        What to call the config in a sentence about it.
    folder
        What paths in it are relative to.

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
    require_consistent(table, name)
    return SimulationConfig(table=table, folder=folder)
