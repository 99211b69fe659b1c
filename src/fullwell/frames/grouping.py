"""Frames of one kind with the same ISO and exposures within 0.5 % are one series (RESULTS 1)."""

import math
from collections.abc import Iterable, Sequence
from dataclasses import replace
from typing import NamedTuple

from fullwell.frames.reading import Reading
from fullwell.frames.selection import EXPOSURE_TOLERANCE
from fullwell.frames.series import Kind, Light, Series
from fullwell.model.irradiation import photons_per_pixel


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

    Flats under different light, stacks and pairs, and the blocks of a descriptor are series of their own. Photons
    follow from the irradiance where none are stated.

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
    families: dict[_Family, list[Reading]] = {}
    for reading in ordered:
        families.setdefault(_family(reading), []).append(reading)
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


def _family(reading: Reading) -> _Family:
    given, lit = reading.given, reading.kind is Kind.FLAT
    return _Family(
        kind=reading.kind,
        iso=reading.frame.header.iso,
        photons=given.photons if lit else None,
        irradiance_uw_cm2=given.irradiance_uw_cm2 if lit else None,
        pulse_s=given.pulse_s if lit else None,
        stack=given.stack,
        block=given.block,
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
        frames=tuple(member.frame for member in members),
    )
