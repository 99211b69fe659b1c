"""One axis of a panel: its scale, its ends, its marks."""

import math
from dataclasses import dataclass, field, replace
from typing import Final, Literal

import numpy as np

from fullwell.report.drawing import ticks
from fullwell.report.drawing.geometry import Array, Scale
from fullwell.report.drawing.style import INK, LETTERS, SMALL
from fullwell.report.drawing.text import width

_APART: Final = 0.7
"""Left free between two labels side by side [em]."""
_FEWEST: Final = 3
_SAME: Final = 1e-12
"""Values that differ by so small a share of them are one."""
_HALF: Final = 0.05
"""Of a single value: half the length of its axis."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Marks:
    """Where an axis is marked, and with which words; small marks have none."""

    places: tuple[float, ...]
    words: tuple[str, ...]
    small: tuple[float, ...] = ()


@dataclass(slots=True)
class Axis:
    """An axis as it is told; what is not told follows from what is drawn."""

    across: bool
    label: str = ""
    label_color: str = INK
    label_size: float = LETTERS
    label_bold: bool = False
    label_turned: bool = True
    scale: Literal["linear", "log", "powers"] = "linear"
    low: float | None = None
    high: float | None = None
    margin: float = 0.05
    turned: bool = False
    most: int | None = None
    whole: bool = False
    places: tuple[float, ...] | None = None
    words: tuple[str, ...] | None = None
    labelled: bool = True
    grid: bool = True
    seen: list[Array] = field(default_factory=list[Array])
    """What was drawn along it."""

    @property
    def log(self) -> bool:
        """Tell whether it is logarithmic."""
        return self.scale != "linear"

    def see(self, values: Array) -> None:
        """Know of values that are drawn."""
        self.seen.append(np.ravel(values))

    def ends(self) -> tuple[float, float]:
        """Return the ends as told, else a little beyond what is drawn; they are never one."""
        low, high = self.low, self.high
        if low is None or high is None or not (self._fit(low) and self._fit(high)):
            around = self._around()
            low = low if low is not None and self._fit(low) else around[0]
            high = high if high is not None and self._fit(high) else around[1]
        if abs(high - low) <= _SAME * max(abs(low), abs(high)):
            low, high = (low / 2.0, low * 2.0) if self.log else _around_one(low)
        return (high, low) if self.turned else (low, high)

    def scaled(self) -> Scale:
        """Return the scale."""
        low, high = self.ends()
        return Scale(low=low, high=high, log=self.log)

    def marks(self, length: float) -> Marks:
        """Return the marks of an axis of a length [point], as many as have room."""
        low, high = sorted(self.ends())
        if self.places is not None:
            inside = [at for at, place in enumerate(self.places) if _within(place, low, high)]
            places = tuple(self.places[at] for at in inside)
            words = self.words
            told = tuple(words[at] for at in inside) if words is not None else tuple(ticks.linear_words(places))
            return Marks(places=places, words=told)
        room = length / (SMALL * (3.0 if self.across else 2.0))
        most = max(min(int(room), self.most or 9), _FEWEST)
        marks = self._marked(low, high, most)
        while most > _FEWEST and not self._fits(marks, length):
            most -= 1
            marks = self._marked(low, high, most)
        thinner = (_thinned(marks, step) for step in range(1, len(marks.words) + 2))
        return next(some for some in thinner if self._fits(some, length))

    def _marked(self, low: float, high: float, most: int) -> Marks:
        if self.scale == "linear":
            places = ticks.linear_ticks(low, high, most=most, whole=self.whole)
            return Marks(places=tuple(places), words=tuple(ticks.linear_words(places)))
        places = ticks.log_ticks(low, high, most=min(most, 7))
        if self.scale == "log":
            return Marks(places=tuple(places), words=tuple(ticks.log_words(places)))
        small = tuple(ticks.small_log_ticks(low, high))
        return Marks(places=tuple(places), words=tuple(ticks.power_words(places)), small=small)

    def _fits(self, marks: Marks, length: float) -> bool:
        """Tell whether labels side by side leave each other room."""
        if not self.across:
            return True
        scale = self.scaled()
        told = [(place, word) for place, word in zip(marks.places, marks.words, strict=True) if word]
        middle = np.sort(scale.share(np.array([place for place, _ in told], float)) * length)
        wide = np.array([width(word, SMALL) for _, word in told])
        wide = wide if scale.low < scale.high else wide[::-1]
        return bool(np.all(np.diff(middle) >= 0.5 * (wide[1:] + wide[:-1]) + _APART * SMALL))

    def _around(self) -> tuple[float, float]:
        """Return ends a margin beyond what is drawn."""
        every = np.concatenate(self.seen) if self.seen else np.empty(0)
        every = every[np.isfinite(every)]
        every = every[every > 0.0] if self.log else every
        low, high = (float(every.min()), float(every.max())) if every.size else (0.1, 1.0) if self.log else (0.0, 1.0)
        if self.log:
            beyond = math.exp(self.margin * math.log(high / low))
            return low / beyond, high * beyond
        beyond = self.margin * (high - low)
        return low - beyond, high + beyond

    def _fit(self, end: float) -> bool:
        """Tell whether an end can be one."""
        return math.isfinite(end) and (end > 0.0 or not self.log)


def _around_one(value: float) -> tuple[float, float]:
    half = _HALF * (abs(value) or 1.0)
    return value - half, value + half


def _thinned(marks: Marks, step: int) -> Marks:
    """Return marks with one word of ``step`` kept."""
    return replace(marks, words=tuple("" if at % step else word for at, word in enumerate(marks.words)))


def _within(place: float, low: float, high: float) -> bool:
    slack = 1e-9 * (high - low)
    return low - slack <= place <= high + slack
