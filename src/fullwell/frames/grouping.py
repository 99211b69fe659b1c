"""Frames of one kind with the same ISO, exposures within 0.5 % and one temperature are one series (RESULTS 1)."""

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from itertools import pairwise
from typing import Final, NamedTuple

from fullwell.frames.reading import Reading
from fullwell.frames.selection import EXPOSURE_TOLERANCE
from fullwell.frames.series import MEASURED_KINDS, Kind, Light, Series
from fullwell.model.irradiation import photons_per_pixel

APART_C: Final = 4.0
"""A gap between temperatures that warming up does not explain: beyond it they are conditions of their own [deg C]."""


def conditions(temperatures_c: Iterable[float]) -> tuple[tuple[float, ...], ...]:
    """Group temperatures into the conditions of a study, the coldest first.

    Parameters
    ----------
    temperatures_c
        Of its frames, in any order [deg C].

    Examples
    --------
    >>> conditions([20.1, 35.2, 20.4, 22.0])
    ((20.1, 20.4, 22.0), (35.2,))

    """
    every = sorted(set(temperatures_c))
    cuts = [index for index, (one, following) in enumerate(pairwise(every), 1) if following - one > APART_C]
    return tuple(tuple(every[first:last]) for first, last in pairwise([0, *cuts, len(every)]) if every)


def group_exposures(exposures_s: Iterable[float]) -> tuple[tuple[float, ...], ...]:
    """Link exposures from the shortest up: one within 0.5 % of the last belongs to its group.

    Parameters
    ----------
    exposures_s
        In any order; the outcome does not depend on it [s].

    Examples
    --------
    >>> group_exposures([0.02, 0.01, 0.01004])
    ((0.01, 0.01004), (0.02,))

    """
    groups: list[list[float]] = []
    for exposure_s in sorted(exposures_s):
        if groups and exposure_s <= groups[-1][-1] * (1.0 + EXPOSURE_TOLERANCE):
            groups[-1].append(exposure_s)
        else:
            groups.append([exposure_s])
    return tuple(tuple(group) for group in groups)


def group_series(
    readings: Iterable[Reading], *, light: Light | None = None, area_um2: float | None = None
) -> tuple[Series, ...]:
    """Group frames into series, sorted by key; a series' exposure is the mean of its frames'.

    Flats under different light, stacks and pairs, the blocks of a descriptor, and frames at temperatures apart are
    series of their own. Photons follow from the irradiance where none are stated.

    Parameters
    ----------
    readings
        The frames.
    light
        What flats were taken under.
    area_um2
        Area of a pixel [um^2].

    """
    ordered = sorted(readings, key=lambda reading: reading.frame.name)
    condition = _conditions_of(ordered)
    families: dict[_Family, list[Reading]] = {}
    for reading in ordered:
        families.setdefault(_family(reading, condition), []).append(reading)
    series = [
        _illuminated(_series(family, members), family, light=light or Light(), area_um2=area_um2)
        for family, every in families.items()
        for members in _by_exposure(every)
    ]
    return tuple(sorted(series, key=lambda one: one.key))


class _Family(NamedTuple):
    kind: Kind
    iso: float | None
    photons: float | None
    irradiance_uw_cm2: float | None
    pulse_s: float | None
    stack: bool | None
    block: int | None
    condition_c: float | None


def _conditions_of(readings: Iterable[Reading]) -> Mapping[float, float]:
    """Return the mean temperature of each temperature's condition; nothing where all are one."""
    known = [one.frame.header.temperature_c for one in readings if one.kind in MEASURED_KINDS]
    found = conditions(celsius for celsius in known if celsius is not None)
    if len(found) < 2:
        return {}
    return {celsius: round(mean(group), 1) for group in found for celsius in group}


def _family(reading: Reading, condition: Mapping[float, float]) -> _Family:
    given, lit, celsius = reading.given, reading.kind is Kind.FLAT, reading.frame.header.temperature_c
    return _Family(
        kind=reading.kind,
        iso=reading.frame.header.iso,
        photons=given.photons if lit else None,
        irradiance_uw_cm2=given.irradiance_uw_cm2 if lit else None,
        pulse_s=given.pulse_s if lit else None,
        stack=given.stack,
        block=given.block,
        condition_c=condition.get(celsius) if celsius is not None and reading.kind in MEASURED_KINDS else None,
    )


def _illuminated(series: Series, family: _Family, *, light: Light, area_um2: float | None) -> Series:
    """Return a series with the photons that follow from the irradiance, if all is known that they need."""
    irradiance_uw_cm2 = light.irradiance_uw_cm2 if family.irradiance_uw_cm2 is None else family.irradiance_uw_cm2
    lit_s = family.pulse_s or series.exposure_s
    if (
        series.kind is not Kind.FLAT
        or series.photons is not None
        or irradiance_uw_cm2 is None
        or lit_s is None
        or light.wavelength_nm is None
        or area_um2 is None
    ):
        return series
    photons = photons_per_pixel(
        area_um2=area_um2,
        exposure_s=lit_s,
        wavelength_nm=light.wavelength_nm,
        irradiance_uw_cm2=irradiance_uw_cm2,
    )
    return replace(series, photons=photons)


def mean(values: Sequence[float]) -> float:
    """Return the mean, exact where all values are equal and independent of their order."""
    if min(values) == max(values):
        return values[0]
    return math.fsum(values) / len(values)


def _by_exposure(family: Sequence[Reading]) -> list[list[Reading]]:
    known = [exposure for reading in family if (exposure := reading.frame.header.exposure_s) is not None]
    groups = [
        [reading for reading in family if _within(reading.frame.header.exposure_s, group)]
        for group in group_exposures(known)
    ]
    unknown = [reading for reading in family if reading.frame.header.exposure_s is None]
    return [*groups, unknown] if unknown else groups


def _within(exposure_s: float | None, group: tuple[float, ...]) -> bool:
    return exposure_s is not None and group[0] <= exposure_s <= group[-1]


def _series(family: _Family, members: Sequence[Reading]) -> Series:
    headers = [member.frame.header for member in members]
    exposures = [header.exposure_s for header in headers if header.exposure_s is not None]
    temperatures = [header.temperature_c for header in headers if header.temperature_c is not None]
    return Series(
        kind=family.kind,
        iso=family.iso,
        exposure_s=mean(exposures) if exposures else None,
        temperature_c=mean(temperatures) if temperatures else None,
        photons=family.photons,
        stack=family.stack,
        condition_c=family.condition_c,
        frames=tuple(member.frame for member in members),
    )
