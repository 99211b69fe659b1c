"""Frames of one kind with the same ISO and exposures within 0.5 % are one series (RESULTS 1)."""

import math
from collections.abc import Iterable, Sequence

from fullwell.errors import UsageError
from fullwell.frames.reading import Reading
from fullwell.frames.selection import EXPOSURE_TOLERANCE
from fullwell.frames.series import Kind, Series


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


def group_series(readings: Iterable[Reading]) -> tuple[Series, ...]:
    """Group frames into series, sorted by key; a series' exposure is the mean of its frames'.

    Raises
    ------
    UsageError
        Where a manifest gives frames of one series different numbers of photons.

    """
    ordered = sorted(readings, key=lambda reading: reading.frame.name)
    families: dict[tuple[Kind, float | None], list[Reading]] = {}
    for reading in ordered:
        families.setdefault((reading.kind, reading.frame.header.iso), []).append(reading)
    series = [
        _series(kind, iso, members) for (kind, iso), family in families.items() for members in _by_exposure(family)
    ]
    return tuple(sorted(series, key=lambda one: one.key))


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


def _series(kind: Kind, iso: float | None, members: Sequence[Reading]) -> Series:
    headers = [member.frame.header for member in members]
    exposures = [header.exposure_s for header in headers if header.exposure_s is not None]
    temperatures = [header.temperature_c for header in headers if header.temperature_c is not None]
    photons = {member.photons for member in members}
    if len(photons) > 1:
        raise UsageError(
            f"Frames of one {kind.value} series (ISO {_said(iso)}, {exposures[0] if exposures else 'unknown'} s) are "
            f"given different photons: {', '.join(sorted(_said(one) for one in photons))}. One series has "
            "one exposure and one number of photons; give each its own exposure_s."
        )
    return Series(
        kind=kind,
        iso=iso,
        exposure_s=mean(exposures) if exposures else None,
        temperature_c=mean(temperatures) if temperatures else None,
        photons=photons.pop(),
        frames=tuple(member.frame for member in members),
    )


def _said(value: float | None) -> str:
    return "unknown" if value is None else f"{value:g}"
