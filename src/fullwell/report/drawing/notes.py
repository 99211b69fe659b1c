"""Words in a panel: a text at a point, an arrow with two heads, a box of names with their values."""

import math
from dataclasses import dataclass
from typing import Final, TypedDict

import numpy as np

from fullwell.report.drawing.geometry import Array, Box, View
from fullwell.report.drawing.pen import Pen, lines_path, polygon
from fullwell.report.drawing.style import INK, LEGEND, LETTERS, PAPER, QUIET, Across, Up
from fullwell.report.drawing.text import CAPITAL, LINE_HEIGHT, height, width

_NOTHING: Final = np.empty((0, 2))
_BOX_EDGE: Final = "#dfe4e9"
_ROW: Final = 13.5
_PAD: Final = 7.0
"""Line and margin of the box of facts [point]."""
_HEAD: Final = (8.0, 3.2)
"""Length and half the width of the head of an arrow [point]."""
_SHAFT: Final = 1.1
"""Width of its line [point]."""
_PAPER_PAD: Final = 2.5


class NoteOptions(TypedDict, total=False):
    """Options of a text at a point.

    Parameters
    ----------
    x_share, y_share
        Whether its place is a share of the panel, from the left and the bottom, not a value of the axes.
    offset
        How far right and up of the point it stands [point].
    size, color, bold, ha, va
        Its look, and which of its points stands there; letters in points.
    rotation
        Anticlockwise [degree].
    slope
        Instead of it: along a line that rises so much, as `View.slope` has it; the offset is then along and off it.
    halo
        Colour of a line around its letters.
    on_paper
        Whether paper hides what is below.
    zorder
        What is higher is drawn later.
    clipped
        Whether it ends at the edge of the panel.

    """

    x_share: bool
    y_share: bool
    offset: tuple[float, float]
    size: float
    color: str
    bold: bool
    ha: Across
    va: Up
    rotation: float
    slope: float | None
    halo: str
    on_paper: bool
    zorder: float
    clipped: bool


@dataclass(frozen=True, slots=True, kw_only=True)
class Note:
    """A text at a point: see `NoteOptions`."""

    text: str
    x: float
    y: float
    x_share: bool = False
    y_share: bool = False
    offset: tuple[float, float] = (0.0, 0.0)
    size: float = LETTERS
    color: str = INK
    bold: bool = False
    ha: Across = "left"
    va: Up = "baseline"
    rotation: float = 0.0
    slope: float | None = None
    halo: str = ""
    on_paper: bool = False
    zorder: float = 3.0
    clipped: bool = False

    def draw(self, pen: Pen, view: View) -> None:
        """Write it."""
        rotation = self.rotation if self.slope is None else view.slope(self.slope)
        x, y = self._place(view)
        right, up = self.offset
        if self.slope is not None:
            turn = math.radians(rotation)
            right, up = right * math.cos(turn) - up * math.sin(turn), right * math.sin(turn) + up * math.cos(turn)
        x, y = x + right, y - up
        if self.on_paper:
            pen.box(self._around(x, y).widened(_PAPER_PAD), fill=PAPER)
        pen.words(
            self.text,
            x,
            y,
            size=self.size,
            color=self.color,
            bold=self.bold,
            ha=self.ha,
            va=self.va,
            rotation=rotation,
            halo=self.halo,
        )

    def covered(self, view: View) -> Array:
        """Return a grid over an upright text, its place of a turned one."""
        x, y = self._place(view)
        if self.rotation or self.slope is not None:
            return np.array([[x, y]])
        box, share = self._around(x + self.offset[0], y - self.offset[1]), np.linspace(0.0, 1.0, 5)
        across, down = np.meshgrid(box.left + share * box.width, box.top + share * box.height)
        return np.column_stack([across.ravel(), down.ravel()])

    def _place(self, view: View) -> tuple[float, float]:
        box = view.box
        x = box.left + self.x * box.width if self.x_share else float(view.across(np.array(self.x)))
        y = box.bottom - self.y * box.height if self.y_share else float(view.down(np.array(self.y)))
        return x, y

    def _around(self, x: float, y: float) -> Box:
        wide, high = width(self.text, self.size, bold=self.bold), height(self.text, self.size)
        lines = self.text.count("\n")
        above = {
            "top": 0.0,
            "baseline": CAPITAL * self.size,
            "center": 0.5 * self.size * (CAPITAL + LINE_HEIGHT * lines),
            "bottom": high,
        }[self.va]
        return Box(
            left=x - {"left": 0.0, "center": 0.5, "right": 1.0}[self.ha] * wide, top=y - above, width=wide, height=high
        )


@dataclass(frozen=True, slots=True, kw_only=True)
class Arrow:
    """An arrow with heads at both ends, which are values of the axes."""

    start: tuple[float, float]
    end: tuple[float, float]
    zorder: float = 2.5
    clipped: bool = True

    def draw(self, pen: Pen, view: View) -> None:
        """Draw it."""
        x = view.across(np.array([self.start[0], self.end[0]]))
        y = view.down(np.array([self.start[1], self.end[1]]))
        ends = np.column_stack([x, y])
        along = (ends[1] - ends[0]) / max(float(np.hypot(*(ends[1] - ends[0]))), 1e-9)
        aside = np.array([-along[1], along[0]])
        inner = ends + np.array([[1.0], [-1.0]]) * _HEAD[0] * along
        pen.path(lines_path([inner.ravel().tolist()]), stroke=INK, width=_SHAFT)
        for tip, base in zip(ends, inner, strict=True):
            pen.path(polygon(*np.array([tip, base + _HEAD[1] * aside, base - _HEAD[1] * aside]).T), fill=INK)

    def covered(self, view: View) -> Array:
        """Return nothing."""
        del view
        return _NOTHING


@dataclass(frozen=True, slots=True, kw_only=True)
class Facts:
    """Names and values in two columns in a box.

    Parameters
    ----------
    lines
        Each a name and a value.
    corner
        Of the box's upper left, or with ``right`` upper right, as shares of the panel.

    """

    lines: tuple[tuple[str, str], ...]
    corner: tuple[float, float]
    right: bool
    zorder: float = 6.0
    clipped: bool = True

    def draw(self, pen: Pen, view: View) -> None:
        """Draw it."""
        box, value_at = self._box(view)
        pen.box(box, fill=PAPER, stroke=_BOX_EDGE, width=0.8)
        for index, (name, value) in enumerate(self.lines):
            level = box.top + 0.5 * _PAD + (index + 0.5) * _ROW
            pen.words(name, box.left + _PAD, level, size=LEGEND, color=QUIET, va="center")
            pen.words(value, box.left + value_at, level, size=LEGEND, color=INK, va="center")

    def covered(self, view: View) -> Array:
        """Return a grid over the box."""
        box, share = self._box(view)[0], np.linspace(0.0, 1.0, 9)
        across, down = np.meshgrid(box.left + share * box.width, box.top + share * box.height)
        return np.column_stack([across.ravel(), down.ravel()])

    def _box(self, view: View) -> tuple[Box, float]:
        """Return the box, and how far from its left the values stand."""
        value_at = 2.0 * _PAD + max(width(name, LEGEND) for name, _ in self.lines)
        wide = value_at + _PAD + max(width(value, LEGEND) for _, value in self.lines)
        left = view.box.left + self.corner[0] * view.box.width - (wide if self.right else 0.0)
        top = view.box.bottom - self.corner[1] * view.box.height
        return Box(left=left, top=top, width=wide, height=_PAD + _ROW * len(self.lines)), value_at
