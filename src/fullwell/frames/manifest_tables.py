"""What ``study.toml``, camera files and the sidecar of a descriptor may hold, checked; every wrong key is named."""

import json
import tomllib
from collections.abc import Sequence
from datetime import date as date_type
from pathlib import Path
from typing import Annotated, Literal, TypeVar

from pydantic import BaseModel, ConfigDict, Discriminator, Field, Tag, ValidationError

from fullwell.errors import UsageError
from fullwell.frames.campaign import Campaign
from fullwell.frames.series import HIGHEST_CODE, Camera, Light

_Positive = Annotated[float, Field(gt=0.0, allow_inf_nan=False)]
_NotNegative = Annotated[float, Field(ge=0.0, allow_inf_nan=False)]
_Number = Annotated[float, Field(allow_inf_nan=False)]
_Level = Annotated[float, Field(ge=0.0, le=HIGHEST_CODE)]
_Levels = Annotated[list[_Level], Field(min_length=1, max_length=4)]
_Table = TypeVar("_Table", bound=BaseModel)


def _form(value: object) -> str:
    return "sites" if isinstance(value, list) else "level"


_Black = Annotated[Annotated[_Level, Tag("level")] | Annotated[_Levels, Tag("sites")], Discriminator(_form)]


class _Strict(BaseModel):
    model_config = ConfigDict(extra="forbid", strict=True)


class CameraTable(_Strict):
    """``[camera]``."""

    name: str | None = None
    bit_depth: Annotated[int, Field(ge=1, le=16)] | None = None
    cfa: Literal["RGGB", "GRBG", "GBRG", "BGGR", "mono"] | None = None
    black_level: _Black | None = None
    white_level: Annotated[float, Field(ge=1.0, le=HIGHEST_CODE)] | None = None
    pixel_pitch_um: _Positive | None = None
    pixel_area_um2: _Positive | None = None
    voltage_swing_v: _Positive | None = None
    base_iso: _Positive | None = None
    focal_length_mm: _Positive | None = None

    @property
    def camera(self) -> Camera:
        """Return the facts."""
        levels = self.black_level
        facts = self.model_dump(exclude={"black_level"})
        black = None if levels is None else tuple(levels) if isinstance(levels, list) else (levels,)
        return Camera(**facts, black_level=black)


class LightTable(_Strict):
    """``[light]``."""

    wavelength_nm: _Positive | None = None
    fwhm_nm: _Positive | None = None
    irradiance_uw_cm2: _NotNegative | None = None
    nonuniformity_percent: _NotNegative | None = None
    calibration_error_percent: _NotNegative | None = None
    control: Literal["time", "light", "pulse"] | None = None
    nominal: bool = False

    @property
    def light(self) -> Light:
        """Return the facts."""
        return Light(**self.model_dump())


class EmvaTable(_Strict):
    """``[emva]``."""

    vendor: str | None = None
    model: str | None = None
    serial_number: str | None = None
    company: str | None = None
    date: str | date_type | None = None
    data_type: Literal["single", "typical", "guaranteed", "guaranteed over lifetime"] | None = None
    data_type_definition: str | None = None
    sensor_type: Literal["CMOS", "CCD"] | None = None
    sensor_diagonal_mm: _Positive | None = None
    lens_category: str | None = None
    readout_type: str | None = None
    transfer_type: str | None = None
    shutter_type: str | None = None
    overlap_capabilities: str | None = None
    maximum_readout_rate: str | None = None
    dark_current_compensation: str | None = None
    interface: str | None = None
    equipment: str | None = None
    light_source: str | None = None
    f_number: _Positive | None = None
    irradiance_measurement_error_percent: _NotNegative | None = None
    temperature_control: str | None = None
    frame_rate_hz: _Positive | None = None
    data_transfer_mode: str | None = None
    gain_setting: str | None = None
    environment_temperature_c: _Number | None = None
    body_temperature_c: _Number | None = None
    optional_parts: str | None = None

    @property
    def campaign(self) -> Campaign:
        """Return the statements."""
        when = self.date.isoformat() if isinstance(self.date, date_type) else self.date
        return Campaign(**self.model_dump(exclude={"date"}), date=when)


class SeriesTable(_Strict):
    """``[[series]]``."""

    kind: Literal["flat", "dark", "bias", "chart", "scene"]
    files: Annotated[list[str], Field(min_length=1)]
    exposure_s: _Positive | None = None
    iso: _Positive | None = None
    photons: _NotNegative | None = None
    irradiance_uw_cm2: _NotNegative | None = None
    pulse_s: _Positive | None = None
    stack: bool | None = None
    temperature_c: _Number | None = None


class ManifestTables(_Strict):
    """``study.toml``."""

    camera: CameraTable = CameraTable()
    light: LightTable = LightTable()
    emva: EmvaTable = EmvaTable()
    headerless: dict[str, int | str] | None = None
    series: Annotated[list[SeriesTable], Field(min_length=1)]


class CameraFile(BaseModel):
    """A TOML file of which the ``[camera]`` table matters."""

    model_config = ConfigDict(extra="ignore", strict=True)

    camera: CameraTable


class DescriptorFacts(BaseModel):
    """The JSON file beside a descriptor: what the descriptor has no place for."""

    model_config = ConfigDict(extra="ignore", strict=True)

    camera: CameraTable = CameraTable()
    light: LightTable = LightTable()
    emva: EmvaTable = EmvaTable()
    iso: _Positive | None = None
    temperature_c: _Number | None = None


def validated(model: type[_Table], path: Path) -> _Table:
    """Return what a TOML or JSON file holds.

    Raises
    ------
    UsageError
        Where it cannot be read, or says something that is not allowed: each such key with its value and what is.

    """
    form = "JSON" if path.suffix.lower() == ".json" else "TOML"
    try:
        text = path.read_text(encoding="utf-8-sig")
        document = json.loads(text) if form == "JSON" else tomllib.loads(text)
    except OSError as error:
        raise UsageError(f"Cannot read {path}: {error.strerror}.") from error
    except ValueError as error:
        raise UsageError(f"{path} is not valid {form}: {error}.") from error
    try:
        return model.model_validate(document)
    except ValidationError as error:
        sentences = [_sentence(one["loc"], one["msg"], one["input"], one["type"]) for one in error.errors()]
        unique = list(dict.fromkeys(sentences))
        raise UsageError(f"{path}: " + " ".join(unique)) from error


def _sentence(loc: Sequence[int | str], message: str, value: object, reason: str) -> str:
    """Say what is wrong with one key; lists are counted from 1, as people do."""
    key = ""
    for part in loc:
        if isinstance(part, int):
            key += f"[{part + 1}]"
        elif part not in {"level", "sites"}:
            key += f".{part}" if key else part
    if reason == "missing":
        return f"{key} is missing."
    if reason == "extra_forbidden":
        return f"{key} is not a key of the manifest; {_allowed_keys(loc)}."
    wish = message.removeprefix("Input ").removeprefix("List ").partition(" after validation")[0]
    wish = wish.replace("a valid integer", "an integer").replace("a valid ", "a ")
    return f"{key} = {toml_value(value)} is not allowed: it {wish}."


def _allowed_keys(loc: Sequence[int | str]) -> str:
    if loc[0] == "camera" and len(loc) > 1:
        return "[camera] knows " + ", ".join(CameraTable.model_fields)
    if loc[0] == "light" and len(loc) > 1:
        return "[light] knows " + ", ".join(LightTable.model_fields)
    if loc[0] == "emva" and len(loc) > 1:
        return "[emva] knows " + ", ".join(EmvaTable.model_fields)
    if loc[0] == "series" and len(loc) > 2:
        return "[[series]] knows " + ", ".join(SeriesTable.model_fields)
    return "it knows the tables [camera], [light], [emva], [headerless] and [[series]]"


def toml_value(value: object) -> str:
    """Write a value as TOML does, for messages."""
    if isinstance(value, str):
        return f'"{value}"'
    if isinstance(value, bool):
        return str(value).lower()
    return str(value)
