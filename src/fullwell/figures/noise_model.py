"""A noise model however it was described: what was given, by which conventions, and what follows in DN.

`NativeModel` is what all descriptions have in common, sigma^2 = A + B S + C S^2 of one frame in DN, with its noise in
the dark taken apart as far as what was given allows. `native_model` goes there from k's, from figures in DN, electrons
or by EMVA 1288, and from the tag NoiseProfile.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final, TypeAlias

from fullwell.figures.propagation import Ingredient
from fullwell.figures.results import Row
from fullwell.model import conversions
from fullwell.units import DN, DN2, DN_PER_ELECTRON, DN_PER_SECOND, ELECTRON, ELECTRON2, ELECTRON_PER_SECOND, ONE

Name: TypeAlias = tuple[str, str]
"""Quantity and unit, as in a result row."""

K_DARK: Final[Name] = ("k_dark_variance", ONE)
K_SHOT: Final[Name] = ("k_shot_variance", ONE)
K_FPN: Final[Name] = ("k_fpn_variance", ONE)
SYSTEM_GAIN: Final[Name] = ("system_gain", DN_PER_ELECTRON)
READ_E2: Final[Name] = ("read_noise_variance", ELECTRON2)
READ_DN2: Final[Name] = ("read_noise_variance", DN2)
DSNU_E2: Final[Name] = ("dsnu_variance", ELECTRON2)
DSNU_DN2: Final[Name] = ("dsnu_variance", DN2)
PRNU2: Final[Name] = ("prnu_variance", ONE)
DARK_CURRENT_E: Final[Name] = ("dark_current", ELECTRON_PER_SECOND)
DARK_CURRENT_DN: Final[Name] = ("dark_current", DN_PER_SECOND)
SATURATION_E: Final[Name] = ("saturation_capacity", ELECTRON)
SATURATION_DN: Final[Name] = ("saturation_capacity", DN)
PROFILE_SCALE: Final[Name] = ("noise_profile_scale", ONE)
PROFILE_OFFSET: Final[Name] = ("noise_profile_offset", ONE)

_ROUNDING_SLACK: Final = 1e-9


@dataclass(frozen=True, slots=True, kw_only=True)
class Conventions:
    """What the numbers of a noise model refer to (METHOD 0).

    Parameters
    ----------
    digital_maximum
        D, which the k's are relative to [DN].
    white_level, black_level
        Of the file; None where unknown [DN].
    step
        Distance of two codes q; not 1 where a file was rescaled [DN].
    exposure_s
        Exposure of the frames whose noise in the dark is meant [s].

    """

    digital_maximum: float
    white_level: float | None = None
    black_level: float | None = None
    step: float = 1.0
    exposure_s: float = 0.0

    @property
    def signal_range(self) -> float:
        """White less black level, which NoiseProfile is relative to; D where a level is unknown [DN]."""
        if self.white_level is None or self.black_level is None:
            return self.digital_maximum
        return self.white_level - self.black_level

    @property
    def digital_maximum_is(self) -> str:
        """What D is, in words."""
        if self.white_level is None:
            return "as given"
        if math.isclose(self.digital_maximum, self.white_level, rel_tol=_ROUNDING_SLACK):
            return "white level"
        if self.black_level is not None and math.isclose(
            self.digital_maximum, self.signal_range, rel_tol=_ROUNDING_SLACK
        ):
            return "white level - black level"
        return "as given"


@dataclass(frozen=True, slots=True, kw_only=True)
class GivenModel:
    """A noise model as it was given.

    Parameters
    ----------
    given
        Values by quantity and unit; noises as signed variances, PRNU as a fraction squared.
    conventions
        What they refer to.
    channel
        As in a result row.
    iso
        None where unknown.
    measured
        Figures that were measured directly and stand for themselves, noises with their signed variances.

    """

    given: Mapping[Name, Ingredient]
    conventions: Conventions
    channel: str = "all"
    iso: float | None = None
    measured: tuple[Row, ...] = ()


@dataclass(frozen=True, slots=True, kw_only=True)
class NativeModel:
    """The noise of one frame in DN, and the parts of its noise in the dark in electrons.

    Parameters
    ----------
    dark_dn2
        A: read noise, DSNU, dark current and rounding [DN^2].
    system_gain
        B = K [DN/e-].
    fixed
        C = k_fpn^2 [1]; None where the description has no such term.
    read_e2
        Temporal noise without rounding and dark current; with DSNU where that is not known [e-^2].
    dsnu_e2
        None where unknown [e-^2].
    dark_current
        None where unknown [e-/s].
    saturation_dn
        Signal above black; None where unknown [DN].

    """

    dark_dn2: float
    system_gain: float
    fixed: float | None
    read_e2: float
    dsnu_e2: float | None
    dark_current: float | None
    saturation_dn: float | None


def native_model(values: Mapping[Name, float], conventions: Conventions) -> NativeModel:
    """Return the model in DN of a description (METHOD 8; DNG).

    Parameters
    ----------
    values
        By quantity and unit: the two k's variances, or system gain and read noise, or scale and offset of a noise
        profile, and what else is known.
    conventions
        What they refer to.

    """
    system_gain = _system_gain(values, conventions)
    dsnu2 = _in_unit(values, DSNU_E2, DSNU_DN2, system_gain**2)
    current = _in_unit(values, DARK_CURRENT_E, DARK_CURRENT_DN, system_gain)
    read2 = _in_unit(values, READ_E2, READ_DN2, system_gain**2)
    dark_electrons = (current or 0.0) * conventions.exposure_s
    dark_dn2 = _dark_variance(values, conventions)
    if dark_dn2 is None:
        dark_dn2 = system_gain**2 * conversions.unlit_electrons2(
            read2 or 0.0,
            system_gain=system_gain,
            dsnu_electrons2=dsnu2 or 0.0,
            dark_electrons=dark_electrons,
            step=conventions.step,
        )
    if read2 is None:
        read2 = conversions.read_noise_electrons2(
            dark_dn2 / system_gain**2,
            system_gain=system_gain,
            dsnu_electrons2=dsnu2 or 0.0,
            dark_electrons=dark_electrons,
            step=conventions.step,
        )
    saturation = _in_unit(values, SATURATION_DN, SATURATION_E, 1.0 / system_gain)
    return NativeModel(
        dark_dn2=dark_dn2,
        system_gain=system_gain,
        fixed=values.get(K_FPN, values.get(PRNU2)),
        read_e2=read2,
        dsnu_e2=dsnu2,
        dark_current=current,
        saturation_dn=saturation,
    )


def native_values(model: GivenModel) -> NativeModel:
    """Return a given model in DN, errors left aside."""
    return native_model({name: one.measured.value for name, one in model.given.items()}, model.conventions)


def _system_gain(values: Mapping[Name, float], conventions: Conventions) -> float:
    if K_SHOT in values:
        return conversions.system_gain_of_k(values[K_SHOT], digital_maximum=conventions.digital_maximum)
    if PROFILE_SCALE in values:
        scale = values[PROFILE_SCALE]
        return conversions.system_gain_of_noise_profile(scale, signal_range=conventions.signal_range)
    return values[SYSTEM_GAIN]


def _dark_variance(values: Mapping[Name, float], conventions: Conventions) -> float | None:
    """Return A [DN^2] where the description has the noise in the dark as a whole."""
    if K_DARK in values:
        return conversions.dark_variance(values[K_DARK], digital_maximum=conventions.digital_maximum)
    if PROFILE_OFFSET in values:
        offset = values[PROFILE_OFFSET]
        return conversions.variance_of_noise_profile(offset, signal_range=conventions.signal_range)
    return None


def _in_unit(values: Mapping[Name, float], as_wanted: Name, other: Name, factor: float) -> float | None:
    """Return a value in the unit wanted, or that in the other unit divided by ``factor``."""
    if as_wanted in values:
        return values[as_wanted]
    return None if other not in values else values[other] / factor
