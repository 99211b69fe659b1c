"""Noise models out of files: the results of a measurement, or the NoiseProfile of a raw file."""

import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Final, cast

from fullwell.errors import RawFileError, UsageError
from fullwell.figures.noise_model import (
    DARK_CURRENT_DN,
    DSNU_DN2,
    K_DARK,
    K_FPN,
    K_SHOT,
    PRNU2,
    READ_DN2,
    SATURATION_DN,
    SYSTEM_GAIN,
    Conventions,
    GivenModel,
    Name,
)
from fullwell.figures.propagation import Ingredient
from fullwell.figures.results import Row
from fullwell.glossary.flags import RECOMMENDED
from fullwell.report.document import SCHEMA
from fullwell.report.write import DOCUMENT
from fullwell.units import ONE, PERCENT, Measured
from fullwell.workflow.model_figures import models_of_profile

_SHOT: Final = (K_SHOT, SYSTEM_GAIN)
_FIT: Final = (K_DARK, K_SHOT, K_FPN)
_BESIDE: Final = (READ_DN2, DSNU_DN2, DARK_CURRENT_DN, SATURATION_DN)
_PRNU_PERCENT2: Final[Name] = ("prnu_variance", f"{PERCENT}^2")
_DIRECT: Final = ("k_dark", "k_shot", "k_fpn", "system_gain", "read_noise", "dsnu", "prnu", "dark_current")
"""Quantities that are taken as they were measured, in every unit that the results have them in."""

_Place = tuple[str, float | None]


def models_of_file(path: Path) -> tuple[GivenModel, ...]:
    """Return the noise models of results.json, of a folder with one, or of a raw file's NoiseProfile.

    Raises
    ------
    UsageError
        Where the file is none of them, or holds no noise model.

    """
    if not path.exists():
        raise UsageError(f"{path} does not exist.")
    if path.is_dir():
        if not (path / DOCUMENT).is_file():
            raise UsageError(f"{path} holds no {DOCUMENT}; name the folder that `fullwell characterize` wrote.")
        path = path / DOCUMENT
    return _models_of_results(path) if path.suffix.lower() == ".json" else _models_of_raw(path)


def _models_of_raw(path: Path) -> tuple[GivenModel, ...]:
    from fullwell.raw.open import read_header  # noqa: PLC0415 - results need no decoders

    try:
        header = read_header(path)
    except RawFileError as error:
        raise UsageError(f"{path}: {error.message}. Give results.json, or a DNG with a NoiseProfile.") from error
    if not header.noise_profile:
        raise UsageError(f"{path} has no NoiseProfile; measure the camera with `fullwell characterize`.")
    if header.white_level is None or header.black_level is None:
        raise UsageError(f"{path} does not say its white and black level; give --noise-profile, --white and --black.")
    white = max(header.white_level.values)
    conventions = Conventions(
        digital_maximum=white,
        white_level=white,
        black_level=sum(header.black_level.values) / len(header.black_level.values),
    )
    return models_of_profile(header.noise_profile, conventions, iso=header.iso)


def _models_of_results(path: Path) -> tuple[GivenModel, ...]:
    rows = _recommended(path)
    places = {(row.channel, row.iso): None for row in rows if row.quantity in {name for name, _unit in _SHOT}}
    models = [model for place in places if (model := _model(rows, place)) is not None]
    if not models:
        raise UsageError(f"{path} holds no noise model: it takes flats of several exposures, or a chart, to fit one.")
    return tuple(models)


def _recommended(path: Path) -> list[Row]:
    """Return the recommended rows of the whole plane."""
    try:
        rows = rows_of(json.loads(path.read_text(encoding="utf-8")))
    except (OSError, ValueError) as error:
        raise UsageError(f"{path} is no results document of Fullwell's ({SCHEMA}).") from error
    return [row for row in rows if row.region is None and row.exposure_s is None]


def rows_of(document: object) -> list[Row]:
    """Return the rows of a results document that have a value.

    Parameters
    ----------
    document
        ``results.json``, as JSON has it.

    Raises
    ------
    ValueError
        Where it is something else.

    """
    if not isinstance(document, dict) or cast("Mapping[str, object]", document).get("schema") != SCHEMA:
        raise ValueError(f"no results document of Fullwell's ({SCHEMA})")
    try:
        records = cast("Sequence[Mapping[str, object]]", cast("Mapping[str, object]", document)["results"])
        return [_row(record) for record in records if record["value"] is not None]
    except (KeyError, TypeError) as error:
        raise ValueError(f"no results document of Fullwell's ({SCHEMA})") from error


def _row(record: Mapping[str, object]) -> Row:
    low, high = _number(record["ci95_low"]), _number(record["ci95_high"])
    return Row(
        quantity=str(record["quantity"]),
        channel=str(record["channel"]),
        method=str(record["method"]),
        measured=Measured(
            value=float(cast("float", record["value"])),
            unit=str(record["unit"]),
            std_error=_number(record["std_error"]),
            dof=_number(record["dof"]),
            ci95=None if low is None or high is None else (low, high),
        ),
        n=cast("int | None", record["n"]),
        iso=_number(record["iso"]),
        exposure_s=_number(record["exposure_s"]),
        temperature_c=_number(record["temperature_c"]),
        region=cast("str | None", record["region"]),
        snr_threshold=_number(record["snr_threshold"]),
        flags=tuple(str(flag) for flag in cast("Sequence[object]", record["flags"])),
        source=str(record["source"]),
    )


def _number(value: object) -> float | None:
    return None if value is None else float(cast("float", value))


def _model(rows: Sequence[Row], place: _Place) -> GivenModel | None:
    """Return the model of one channel at one ISO; None where it cannot be put together."""
    here = {
        (row.quantity, row.measured.unit): row
        for row in reversed(rows)
        if (row.channel, row.iso) == place and RECOMMENDED in row.flags
    }
    white = _level(rows, place, "white_level")
    given = _given(here)
    if white is None or given is None or any(given[name].measured.value <= 0.0 for name in _SHOT if name in given):
        return None
    return GivenModel(
        given=given,
        conventions=Conventions(
            digital_maximum=white, white_level=white, black_level=_level(rows, place, "black_level")
        ),
        channel=place[0],
        iso=place[1],
        measured=tuple(row for name, row in here.items() if _is_direct(name)),
    )


def _is_direct(name: Name) -> bool:
    return name[0].removesuffix("_variance") in {*_DIRECT, SATURATION_DN[0]}


def _given(here: Mapping[Name, Row]) -> dict[Name, Ingredient] | None:
    """Return what the model is put together from: the k's, or else system gain and read noise."""
    given = {name: Ingredient(measured=here[name].measured, fit="noise model") for name in _FIT if name in here}
    if K_DARK not in given or K_SHOT not in given:
        if SYSTEM_GAIN not in here or READ_DN2 not in here:
            return None
        given = {SYSTEM_GAIN: Ingredient(measured=here[SYSTEM_GAIN].measured)}
    given |= {name: Ingredient(measured=here[name].measured) for name in _BESIDE if name in here}
    if _PRNU_PERCENT2 in here:
        given[PRNU2] = Ingredient(measured=here[_PRNU_PERCENT2].measured.scaled(1e-4, ONE))
    return given


def _level(rows: Sequence[Row], place: _Place, quantity: str) -> float | None:
    """Return a level of a channel; for all channels together their own, or the one that all of them share."""
    channel, iso = place
    known = {
        row.channel: row.measured.value
        for row in rows
        if row.quantity == quantity and row.iso in {iso, None} and RECOMMENDED in row.flags
    }
    if channel in known:
        return known[channel]
    return next(iter(known.values())) if channel == "all" and len(set(known.values())) == 1 else None
