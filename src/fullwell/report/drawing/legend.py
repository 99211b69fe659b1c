"""Legends: keys with their words, in a row above or below the panels or in a corner of one."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final, Literal, TypeAlias, Unpack

import numpy as np

from fullwell.report.drawing.geometry import Array, Box
from fullwell.report.drawing.look import Look, LookOptions
from fullwell.report.drawing.pen import Pen, lines_path
from fullwell.report.drawing.style import LEGEND, is_drawn
from fullwell.report.drawing.text import width

Place: TypeAlias = Literal["best", "upper left", "upper right", "lower left", "lower right", "center right"]

_SAMPLE: Final = 2.0
_TEXT_PAD: Final = 0.55
_BETWEEN: Final = 1.4
_ROW: Final = 1.65
"""Length of a line, what parts it from its words, the columns, and the lines of a legend [em]."""
_AWAY: Final = 0.6
"""From the edge of a panel [em]."""
_CLEAR: Final = 3.0
"""Around a legend that is to cover nothing [point]."""
_PLACES: Final[tuple[Place, ...]] = ("upper right", "upper left", "lower left", "lower right", "center right")


@dataclass(frozen=True, slots=True, kw_only=True)
class Key:
    """An entry of a legend."""

    label: str
    look: Look


def key(label: str, **options: Unpack[LookOptions]) -> Key:
    """Return an entry for a legend; its marker is hollow if not told otherwise."""
    options.setdefault("markerfacecolor", "none")
    return Key(label=label, look=Look(**options))


@dataclass(frozen=True, slots=True, kw_only=True)
class Legend:
    """Keys in columns, filled line by line.

    Parameters
    ----------
    keys
        In their order.
    columns
        How many stand side by side.
    size
        Of the letters [point].

    """

    keys: tuple[Key, ...]
    columns: int
    size: float = LEGEND

    @property
    def extent(self) -> tuple[float, float]:
        """Return width and height [point]."""
        lines = math.ceil(len(self.keys) / self.columns)
        return sum(self._widths()) + self.size * _BETWEEN * (len(self._widths()) - 1), lines * self.size * _ROW

    def draw(self, pen: Pen, left: float, top: float) -> None:
        """Draw it."""
        widths = self._widths()
        for index, one in enumerate(self.keys):
            line, column = divmod(index, self.columns)
            x = left + sum(widths[:column]) + column * self.size * _BETWEEN
            y = top + (line + 0.5) * self.size * _ROW
            sample = self._sample(one)
            one.look.stroke(pen, lines_path([(x, y, x + sample, y)]))
            one.look.stamp(pen, np.array([x + sample / 2.0]), np.array([y]))
            pen.words(one.label, x + sample + self.size * _TEXT_PAD, y, size=self.size, va="center")

    def placed(self, box: Box, place: Place, covered: Sequence[Array]) -> tuple[float, float]:
        """Return left and top of the legend in a panel: where it covers least if the place is the best."""
        if place != "best":
            return self._corner(box, place)
        points = np.concatenate([*covered, np.empty((0, 2))])
        wide, high = self.extent
        half = np.array([wide, high]) / 2.0
        hidden: list[tuple[int, int]] = []
        for rank, one in enumerate(_PLACES):
            away = np.abs(points - self._corner(box, one) - half)
            hidden.append((int((away <= half + _CLEAR).all(axis=1).sum()), rank))
        return self._corner(box, _PLACES[min(hidden)[1]])

    def _corner(self, box: Box, place: Place) -> tuple[float, float]:
        wide, high = self.extent
        away = self.size * _AWAY
        left = box.left + away if place.endswith("left") else box.right - away - wide
        if place.startswith("center"):
            return left, (box.top + box.bottom - high) / 2.0
        return left, box.top + away if place.startswith("upper") else box.bottom - away - high

    def _sample(self, one: Key) -> float:
        """Return the length of the line of a key, or what a marker alone needs where no line stands below [point]."""
        alone = self.columns >= len(self.keys)
        lines = is_drawn(one.look.linestyle) if alone else any(is_drawn(each.look.linestyle) for each in self.keys)
        return self.size * (_SAMPLE if lines else 0.9)

    def _widths(self) -> list[float]:
        each = [self._sample(one) + self.size * _TEXT_PAD + width(one.label, self.size) for one in self.keys]
        columns = min(self.columns, len(each))
        return [max(each[column :: self.columns]) for column in range(columns)]
