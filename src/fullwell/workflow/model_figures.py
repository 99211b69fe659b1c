"""Figures that somebody states become a noise model; what does not fit together is said in a sentence."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, fields
from typing import Final

from fullwell.errors import UsageError
from fullwell.figures.noise_model import (
    DARK_CURRENT_E,
    DSNU_DN2,
    DSNU_E2,
    K_DARK,
    K_FPN,
    K_SHOT,
    PRNU2,
    PROFILE_OFFSET,
    PROFILE_SCALE,
    READ_DN2,
    READ_E2,
    SATURATION_DN,
    SATURATION_E,
    SYSTEM_GAIN,
    Conventions,
    GivenModel,
    Name,
)
from fullwell.figures.propagation import Ingredient
from fullwell.units import Measured

_PERCENT: Final = 100.0
_COLOURS: Final = {1: ("all",), 3: ("R", "G", "B")}
"""Planes of a NoiseProfile by their number (DNG)."""

_POSITIVE: Final = (
    "digital_maximum",
    "white",
    "step",
    "k_shot",
    "system_gain",
    "saturation_capacity",
    "saturation_dn",
)


@dataclass(frozen=True, slots=True, kw_only=True)
class StatedFigures:
    """A noise model as somebody states it; None where nothing is stated.

    Parameters
    ----------
    k_dark, k_shot, k_fpn
        Of sigma^2 = k_dark^2 + k_shot^2 V + k_fpn^2 V^2 [1].
    system_gain
        K [DN/e-].
    read_noise, read_noise_dn
        Temporal noise in the dark without rounding, EMVA 1288's sigma_d at short exposure [e-], [DN].
    dsnu, dsnu_dn
        [e-], [DN].
    prnu
        [%].
    dark_current
        [e-/s].
    exposure_s
        Exposure of the frames whose noise in the dark is meant [s].
    saturation_capacity, saturation_dn
        [e-], and above the black level [DN].
    noise_profile
        (S, O) of every plane [1].
    digital_maximum, white, black, step
        As in `Conventions` [DN].

    """

    k_dark: float | None = None
    k_shot: float | None = None
    k_fpn: float | None = None
    system_gain: float | None = None
    read_noise: float | None = None
    read_noise_dn: float | None = None
    dsnu: float | None = None
    dsnu_dn: float | None = None
    prnu: float | None = None
    dark_current: float | None = None
    exposure_s: float | None = None
    saturation_capacity: float | None = None
    saturation_dn: float | None = None
    noise_profile: tuple[tuple[float, float], ...] = ()
    digital_maximum: float | None = None
    white: float | None = None
    black: float | None = None
    step: float | None = None

    def stated(self) -> dict[str, float]:
        """Return the numbers that are stated, by name."""
        every = {field.name: getattr(self, field.name) for field in fields(self) if field.name != "noise_profile"}
        return {name: float(value) for name, value in every.items() if value is not None}


def models_of_figures(figures: StatedFigures) -> tuple[GivenModel, ...]:
    """Return the noise model that figures state, one a plane of a NoiseProfile.

    Raises
    ------
    UsageError
        Where a figure is impossible, is missing, or contradicts another.

    """
    _check_values(figures)
    model = {} if figures.noise_profile else _model(figures)
    more = _more(figures)
    conventions = _conventions(figures)
    if figures.noise_profile:
        return models_of_profile(figures.noise_profile, conventions, more=more)
    return (GivenModel(given=_exact({**model, **more}), conventions=conventions),)


def models_of_profile(
    pairs: tuple[tuple[float, float], ...],
    conventions: Conventions,
    *,
    more: Mapping[Name, float] | None = None,
    iso: float | None = None,
) -> tuple[GivenModel, ...]:
    """Return the noise models of a NoiseProfile.

    Raises
    ------
    UsageError
        Where S is not above 0 or O is below 0.

    """
    channels = _COLOURS.get(len(pairs), tuple(f"plane {number}" for number in range(1, len(pairs) + 1)))
    for scale, offset in pairs:
        if not (math.isfinite(scale) and math.isfinite(offset) and scale > 0.0 and offset >= 0.0):
            raise UsageError(f"NoiseProfile {scale:g},{offset:g}: S is above 0 and O at least 0.")
    return tuple(
        GivenModel(
            given=_exact({PROFILE_SCALE: scale, PROFILE_OFFSET: offset, **(more or {})}),
            conventions=conventions,
            channel=channel,
            iso=iso,
        )
        for channel, (scale, offset) in zip(channels, pairs, strict=True)
    )


def option(name: str) -> str:
    """Return how the command line calls a figure."""
    return "--" + name.removesuffix("_s").replace("_", "-")


def _check_values(figures: StatedFigures) -> None:
    for name, value in figures.stated().items():
        least = "above 0" if name in _POSITIVE else "at least 0"
        if not math.isfinite(value) or value < 0.0 or (value == 0.0 and name in _POSITIVE):
            raise UsageError(f"{option(name)} {value:g}: give a number {least}.")
    for one, other in (("read_noise", "read_noise_dn"), ("dsnu", "dsnu_dn"), ("saturation_capacity", "saturation_dn")):
        if getattr(figures, one) is not None and getattr(figures, other) is not None:
            raise UsageError(f"{option(one)} and {option(other)} are one figure in two units; give one of them.")
    if figures.white is not None and figures.black is not None and figures.black >= figures.white:
        raise UsageError(f"--black {figures.black:g}: give a level below the white level, {figures.white:g} DN.")


def _conventions(figures: StatedFigures) -> Conventions:
    digital_maximum = figures.digital_maximum or figures.white
    if digital_maximum is None and figures.noise_profile:
        raise UsageError("--noise-profile needs --white and --black: it is relative to white less black level.")
    if digital_maximum is None:
        raise UsageError("--digital-maximum is missing: the number of DN that V = 1 stands for, for example 16383.")
    white = figures.white
    if white is None and figures.black is not None:
        white = digital_maximum
        if figures.black >= white:
            raise UsageError(f"--black {figures.black:g}: give a level below the white level, {white:g} DN.")
    return Conventions(
        digital_maximum=digital_maximum,
        white_level=white,
        black_level=figures.black,
        step=1.0 if figures.step is None else figures.step,
        exposure_s=figures.exposure_s or 0.0,
    )


def _model(figures: StatedFigures) -> dict[Name, float]:
    """Return k's, or system gain and read noise, whichever is stated.

    Raises
    ------
    UsageError
        Where both are, neither is, or half of one.

    """
    by_k = [name for name in ("k_dark", "k_shot", "k_fpn") if getattr(figures, name) is not None]
    by_figures = [
        name for name in ("system_gain", "read_noise", "read_noise_dn", "prnu") if getattr(figures, name) is not None
    ]
    if by_k and by_figures:
        raise UsageError(f"{option(by_k[0])} and {option(by_figures[0])} are two ways to state a model; give one.")
    if figures.k_dark is not None and figures.k_shot is not None:
        squares = {K_DARK: figures.k_dark, K_SHOT: figures.k_shot, K_FPN: figures.k_fpn}
        return {name: value**2 for name, value in squares.items() if value is not None}
    if by_k:
        raise UsageError("k's make a model with --k-dark and --k-shot; --k-fpn is optional.")
    read_noise = {READ_E2: figures.read_noise, READ_DN2: figures.read_noise_dn}
    squared = {name: value**2 for name, value in read_noise.items() if value is not None}
    if figures.system_gain is None or not squared:
        raise UsageError(
            "no noise model is stated: give a results.json, --k-dark and --k-shot, --system-gain and --read-noise, "
            "or --noise-profile."
        )
    return {SYSTEM_GAIN: figures.system_gain, **squared}


def _more(figures: StatedFigures) -> dict[Name, float]:
    """Return what is stated beside the model itself."""
    if figures.noise_profile and (
        beside := [
            name
            for name in ("k_dark", "k_shot", "k_fpn", "system_gain", "read_noise", "read_noise_dn")
            if getattr(figures, name) is not None
        ]
    ):
        raise UsageError(f"--noise-profile and {option(beside[0])} are two ways to state a model; give one.")
    more = {
        DSNU_E2: _squared(figures.dsnu),
        DSNU_DN2: _squared(figures.dsnu_dn),
        PRNU2: None if figures.prnu is None else (figures.prnu / _PERCENT) ** 2,
        DARK_CURRENT_E: figures.dark_current,
        SATURATION_E: figures.saturation_capacity,
        SATURATION_DN: figures.saturation_dn,
    }
    return {name: value for name, value in more.items() if value is not None}


def _squared(value: float | None) -> float | None:
    return None if value is None else value**2


def _exact(values: Mapping[Name, float]) -> dict[Name, Ingredient]:
    return {name: Ingredient(measured=Measured.exact(value, name[1])) for name, value in values.items()}
