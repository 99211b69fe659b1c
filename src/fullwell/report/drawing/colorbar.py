"""Bars that say which value a colour stands for."""

from dataclasses import dataclass
from typing import Final

import numpy as np

from fullwell.report.drawing.axis import Axis
from fullwell.report.drawing.colors import hexadecimal
from fullwell.report.drawing.geometry import Box
from fullwell.report.drawing.images import Shown, palette_uri
from fullwell.report.drawing.pen import Pen, polygon
from fullwell.report.drawing.style import INK, LETTERS, SMALL, SPINE, TICK
from fullwell.report.drawing.text import CAPITAL, DEPTH, width

_THICK: Final = 6.5
_AWAY: Final = 7.0
_TICK: Final = 3.0
_PAD: Final = 3.0
"""Thickness, distance from the panel, length of ticks, between all of them [point]."""
_POINTED: Final = 8.0
_COLORS: Final = 255


@dataclass(frozen=True, slots=True, kw_only=True)
class Bar:
    """A bar of the colours of an image, below it or at its right.

    Parameters
    ----------
    shown
        The image.
    label
        Of its axis.
    level
        Whether it lies below the panel.
    share
        Its length as a share of that of the panel.
    extend
        Whether it has pointed ends.
    size
        Of the letters of the label [point].

    """

    shown: Shown
    label: str
    level: bool
    share: float
    extend: bool
    size: float = LETTERS

    def room(self, length: float) -> float:
        """Return how much it takes beside a panel of a length [point]."""
        words = self._axis().marks(self.share * length).words
        wide = max((width(word, self._small) for word in words), default=0.0)
        beside = (CAPITAL + DEPTH) * self._small if self.level else wide
        said = self.size * (CAPITAL + DEPTH) + _PAD if self.label else 0.0
        return _AWAY + _THICK + _TICK + _PAD + beside + said

    def draw(self, pen: Pen, panel: Box) -> None:
        """Draw it beside a panel."""
        if self.level:
            long = self.share * panel.width
            left = panel.left + (panel.width - long) / 2.0
            self._draw_level(pen, Box(left=left, top=panel.bottom + _AWAY, width=long, height=_THICK))
        else:
            long = self.share * panel.height
            top = panel.top + (panel.height - long) / 2.0
            self._draw_upright(pen, Box(left=panel.right + _AWAY, top=top, width=_THICK, height=long))

    @property
    def _small(self) -> float:
        return min(SMALL, self.size - 1.0)

    def _axis(self) -> Axis:
        return Axis(across=self.level, low=self.shown.low, high=self.shown.high, most=6)

    def _draw_level(self, pen: Pen, box: Box) -> None:
        self._colors(pen, box)
        if self.extend:
            self._points(pen, box)
        axis = self._axis()
        marks = axis.marks(box.width)
        places = box.left + axis.scaled().share(np.array(marks.places)) * box.width
        below = box.bottom + _TICK + _PAD + CAPITAL * self._small
        for place, word in zip(places.tolist(), marks.words, strict=True):
            pen.line(place, box.bottom, place, box.bottom + _TICK, stroke=TICK, width=0.8)
            pen.words(word, place, below, size=self._small, color=TICK, ha="center")
        if self.label:
            low = below + DEPTH * self._small + _PAD + CAPITAL * self.size
            pen.words(self.label, box.left + box.width / 2.0, low, size=self.size, color=INK, ha="center")

    def _draw_upright(self, pen: Pen, box: Box) -> None:
        self._colors(pen, box)
        axis = self._axis()
        marks = axis.marks(box.height)
        places = box.bottom - axis.scaled().share(np.array(marks.places)) * box.height
        for place, word in zip(places.tolist(), marks.words, strict=True):
            pen.line(box.right, place, box.right + _TICK, place, stroke=TICK, width=0.8)
            pen.words(word, box.right + _TICK + _PAD, place, size=self._small, color=TICK, va="center")
        if self.label:
            right = box.right + self.room(box.height / self.share) - _AWAY - _THICK
            pen.words(self.label, right, box.top + box.height / 2, size=self.size, ha="center", rotation=90.0)

    def _colors(self, pen: Pen, box: Box) -> None:
        table = self.shown.colors.at(np.linspace(0.0, 1.0, _COLORS))
        indices = np.arange(_COLORS, dtype=np.uint8)
        uri = palette_uri(indices[None, :] if self.level else indices[::-1, None], table, opacity=b"\xff" * _COLORS)
        pen.image(uri, box, crisp=True)
        pen.box(box, stroke=SPINE, width=0.6)

    def _points(self, pen: Pen, box: Box) -> None:
        ends = self.shown.colors.at(np.array([0.0, 1.0]))
        for edge, out, color in ((box.left, -_POINTED, ends[0]), (box.right, _POINTED, ends[1])):
            path = polygon(np.array([edge, edge + out, edge]), np.array([box.top, box.top + _THICK / 2, box.bottom]))
            pen.path(path, fill=hexadecimal(color.tolist()), stroke=SPINE, width=0.6)
