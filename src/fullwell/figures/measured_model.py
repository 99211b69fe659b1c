"""The noise models that the rows of a measurement hold."""

from collections.abc import Mapping, Sequence
from typing import Final

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
from fullwell.units import ONE, PERCENT

_SHOT: Final = (K_SHOT, SYSTEM_GAIN)
_FIT: Final = (K_DARK, K_SHOT, K_FPN)
_BESIDE: Final = (READ_DN2, DSNU_DN2, DARK_CURRENT_DN, SATURATION_DN)
_PRNU_PERCENT2: Final[Name] = ("prnu_variance", f"{PERCENT}^2")
_DIRECT: Final = ("k_dark", "k_shot", "k_fpn", "system_gain", "read_noise", "dsnu", "prnu", "dark_current")
"""Quantities that are taken as they were measured, in every unit that the results have them in."""

_Place = tuple[str, float | None]


def models_of_rows(rows: Sequence[Row]) -> tuple[GivenModel, ...]:
    """Return the noise models that rows of the whole plane hold, one a channel and ISO."""
    places = {(row.channel, row.iso): None for row in rows if row.quantity in {name for name, _unit in _SHOT}}
    return tuple(model for place in places if (model := _model(rows, place)) is not None)


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
            digital_maximum=_level(rows, place, "digital_maximum") or white,
            white_level=white,
            black_level=_level(rows, place, "black_level"),
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
