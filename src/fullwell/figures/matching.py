"""Rows of several results side by side: which of them tell of the same thing.

Two rows match where quantity, channel, method, unit, ISO, region and threshold are the same, exposures agree within
0.5 % (as frames of one series do) and temperatures within 1 degree.
"""

import math
from bisect import bisect_right
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Final

from fullwell.figures.differences import Difference, row_difference
from fullwell.figures.results import Row
from fullwell.glossary import RECOMMENDED
from fullwell.glossary.comparable import Verdict, comparability

SAME_EXPOSURE: Final = 0.005
SAME_TEMPERATURE_C: Final = 1.0

EMVA_LINEAR: Final = "emva1288-4.0-linear"

Key = tuple[object, ...]
"""What a row is of, and under which conditions."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Match:
    """One figure as several results have it.

    Parameters
    ----------
    rows
        In the order of the results; None where one does not have it.
    differences
        From the first row that is there; None for that one, where there is none, and between two lower bounds or two
        upper limits.

    """

    rows: tuple[Row | None, ...]
    differences: tuple[Difference | None, ...]

    @property
    def reference(self) -> Row:
        """Return the first row that is there."""
        return next(row for row in self.rows if row is not None)

    @property
    def p_value(self) -> float | None:
        """Return the smallest chance of any difference, None where none has one."""
        return min(
            (one.p_value for one in self.differences if one is not None and one.p_value is not None), default=None
        )


@dataclass(frozen=True, slots=True, kw_only=True)
class Crossing:
    """One quantity by two methods, in two results."""

    first: int
    second: int
    rows: tuple[Row, Row]
    difference: Difference | None
    verdict: Verdict


@dataclass(frozen=True, slots=True, kw_only=True)
class Clusters:
    """Conditions that count as one: exposures and temperatures, each by the first of its kind."""

    exposures_s: tuple[float, ...]
    temperatures_c: tuple[float, ...]

    def exposure(self, value: float | None) -> float | None:
        """Return the exposure that stands for this one [s]."""
        return _representative(self.exposures_s, value)

    def temperature(self, value: float | None) -> float | None:
        """Return the temperature that stands for this one [degree Celsius]."""
        return _representative(self.temperatures_c, value)


def clusters(rows: Iterable[Row]) -> Clusters:
    """Return the conditions of rows, those that count as one together."""
    every = tuple(rows)
    return Clusters(
        exposures_s=_starts(
            (row.exposure_s for row in every), lambda first, value: value <= first * (1.0 + SAME_EXPOSURE)
        ),
        temperatures_c=_starts(
            (row.temperature_c for row in every), lambda first, value: value <= first + SAME_TEMPERATURE_C
        ),
    )


def _starts(values: Iterable[float | None], together: Callable[[float, float], bool]) -> tuple[float, ...]:
    starts: list[float] = []
    for value in sorted({value for value in values if value is not None}):
        if not starts or not together(starts[-1], value):
            starts.append(value)
    return tuple(starts)


def _representative(starts: Sequence[float], value: float | None) -> float | None:
    return None if value is None else starts[bisect_right(starts, value) - 1]


def matched(sides: Sequence[Sequence[Row]], shared: Callable[[int, int], bool]) -> tuple[Match, ...]:
    """Return every figure that at least two results have, in the order of the first.

    Parameters
    ----------
    sides
        The rows of each result.
    shared
        Whether two results, by their places, come from the same frames: their errors are not independent then.

    """
    together = clusters(row for rows in sides for row in rows)
    tables = [{_key(row, together): row for row in reversed(rows)} for rows in sides]
    keys = dict.fromkeys(_key(row, together) for rows in sides for row in rows)
    several = (key for key in keys if sum(key in table for table in tables) > 1)
    return tuple(_match([table.get(key) for table in tables], shared) for key in several)


def _key(row: Row, together: Clusters) -> Key:
    return (*_what(row, together), row.method)


def _what(row: Row, together: Clusters) -> Key:
    """Return everything that identifies a row but its method."""
    return (
        row.quantity,
        row.channel,
        row.measured.unit,
        row.iso,
        together.exposure(row.exposure_s),
        together.temperature(row.temperature_c),
        row.region,
        row.snr_threshold,
    )


def _match(rows: Sequence[Row | None], shared: Callable[[int, int], bool]) -> Match:
    at = next(index for index, row in enumerate(rows) if row is not None)
    reference = rows[at]
    differences = tuple(
        None
        if row is None or reference is None or index == at
        else row_difference(row, reference, independent=not shared(at, index))
        for index, row in enumerate(rows)
    )
    return Match(rows=tuple(rows), differences=differences)


def crossed(sides: Sequence[Sequence[Row]], shared: Callable[[int, int], bool]) -> tuple[Crossing, ...]:
    """Return the figures of two results that stand there by different methods, with whether they mean the same.

    Of each result its recommended row is taken, or that of EMVA 1288; figures that both have by one method are left to
    `matched`. Exposure and temperature are left aside where one of the two does not know them, and an exposure only
    where the other result has no row that belongs to none; no threshold is SNR 1.
    """
    tables = [_leading(rows) for rows in sides]
    found: list[Crossing] = []
    for first in range(len(tables)):
        for second in range(first + 1, len(tables)):
            for key, rows in tables[first].items():
                found += [
                    Crossing(
                        first=first,
                        second=second,
                        rows=(one, other),
                        difference=row_difference(other, one, independent=not shared(first, second)),
                        verdict=comparability(one.quantity, one.method, other.method),
                    )
                    for one, other in _unlike(rows, tables[second].get(key, ()))
                ]
    return tuple(found)


def _leading(rows: Iterable[Row]) -> Mapping[Key, tuple[Row, ...]]:
    """Return the rows that speak for a result, by quantity, channel, unit and ISO."""
    table: dict[Key, tuple[Row, ...]] = {}
    for row in rows:
        if row.region is None and (RECOMMENDED in row.flags or row.method == EMVA_LINEAR):
            key = (row.quantity, row.channel, row.measured.unit, row.iso)
            table[key] = (*table.get(key, ()), row)
    return table


def _unlike(ours: Sequence[Row], theirs: Sequence[Row]) -> list[tuple[Row, Row]]:
    """Return pairs by unlike methods under conditions that do not contradict; none where a method is common."""
    if {row.method for row in ours} & {row.method for row in theirs}:
        return []
    pairs = [(one, other) for one in ours for other in theirs if _compatible(one, other)]
    settled = {id(row) for pair in pairs if _as_particular(*pair) for row in pair}
    return [pair for pair in pairs if _as_particular(*pair) or not settled.intersection(map(id, pair))]


def _as_particular(one: Row, other: Row) -> bool:
    """Tell whether both belong to one exposure, or neither."""
    return (one.exposure_s is None) == (other.exposure_s is None)


def _compatible(one: Row, other: Row) -> bool:
    times = (one.exposure_s, other.exposure_s)
    alike = None in times or math.isclose(times[0] or 0.0, times[1] or 0.0, rel_tol=SAME_EXPOSURE)
    warm = (one.temperature_c, other.temperature_c)
    at_snr = (one.snr_threshold or 1.0) == (other.snr_threshold or 1.0)
    return alike and at_snr and (None in warm or abs((warm[0] or 0.0) - (warm[1] or 0.0)) <= SAME_TEMPERATURE_C)
