"""What stands around a panel: spines, grid, ticks and their words, labels, the title; and how much room that takes."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from fullwell.report.drawing.axes import Axes
from fullwell.report.drawing.axis import Axis, Marks
from fullwell.report.drawing.geometry import Box, View
from fullwell.report.drawing.legend import Legend
from fullwell.report.drawing.marks import Mark
from fullwell.report.drawing.pen import Pen, lines_path
from fullwell.report.drawing.style import GRID, GRID_WIDTH, PAPER, SMALL, SPINE, SPINE_WIDTH, TICK
from fullwell.report.drawing.text import CAPITAL, DEPTH, LINE_HEIGHT, height, width

_PAPER_PAD: Final = 2.0
_PAPER_ALPHA: Final = 0.8
"""Around a legend inside a panel [point], and how far its paper hides what is below."""
_TICK: Final = 3.5
_SMALL_TICK: Final = 2.0
_PAD: Final = 3.5
_LABEL_PAD: Final = 4.0
_TITLE_PAD: Final = 6.0
"""Length of ticks, and what parts them, their words, labels and title from each other and the panel [point]."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Margins:
    """What a panel needs around its box [point]."""

    left: float = 0.0
    right: float = 0.0
    top: float = 0.0
    bottom: float = 0.0


def margins(axes: Axes, box: Box) -> Margins:
    """Return the room for all that stands around a panel, if its box has this size."""
    if not axes.visible:
        return Margins()
    box = panel_box(axes, box)
    x, y = (axes.x.marks(box.width), axes.y.marks(box.height)) if axes.framed else (_EMPTY, _EMPTY)
    across = _edges(axes.x, x, box.width)
    return Margins(
        left=max(_beside(axes.y, y), across[0]),
        right=max(across[1], axes.bar.room(box.height) if axes.bar and not axes.bar.level else 0.0),
        top=max(_above(axes), CAPITAL * SMALL / 2.0 if y.words else 0.0),
        bottom=max(_below(axes.x, x), CAPITAL * SMALL / 2.0 if y.words else 0.0)
        + (axes.bar.room(box.width) if axes.bar and axes.bar.level else 0.0),
    )


def panel_box(axes: Axes, box: Box) -> Box:
    """Return the box of a panel within the place that it has: smaller where units must be square."""
    if not axes.equal:
        return box
    (left, right), (low, high) = axes.get_xlim(), axes.get_ylim()
    return box.shaped(
        abs((right - left) / (high - low)), anchor={"top": 0.0, "middle": 0.5, "bottom": 1.0}[axes.anchor]
    )


def draw_panel(pen: Pen, axes: Axes, place: Box) -> None:
    """Draw a panel with all that stands around it."""
    if not axes.visible:
        return
    box = panel_box(axes, place)
    x, y = axes.scaled()
    view = View(box=box, x=x, y=y)
    if axes.paper != "none":
        pen.box(box, fill=axes.paper)
    marks = sorted(axes.marks, key=lambda mark: mark.zorder)
    _draw_clipped(pen, view, [mark for mark in marks if mark.zorder < 0.0])
    _draw_axes(pen, axes, view) if axes.framed else _draw_labels(pen, axes, box, (_EMPTY, _EMPTY))
    _draw_clipped(pen, view, [mark for mark in marks if mark.zorder >= 0.0])
    _draw_heading(pen, axes, box)
    if axes.bar:
        lower = _below(axes.x, axes.x.marks(box.width)) if axes.framed and axes.bar.level else 0.0
        axes.bar.draw(pen, box.inside(bottom=-lower))
    if axes.inset:
        legend = Legend(keys=axes.inset.keys, columns=1, size=axes.inset.size)
        covered = [mark.covered(view) for mark in marks] if axes.inset.loc == "best" else []
        left, top = legend.placed(box, axes.inset.loc, covered)
        wide, high = legend.extent
        pen.box(Box(left=left, top=top, width=wide, height=high).widened(_PAPER_PAD), fill=PAPER, alpha=_PAPER_ALPHA)
        legend.draw(pen, left, top)


def _draw_clipped(pen: Pen, view: View, marks: Sequence[Mark]) -> None:
    """Draw marks, first those that end at the edge of the panel."""
    with pen.clipped(view.box):
        for mark in marks:
            if mark.clipped:
                mark.draw(pen, view)
    for mark in marks:
        if not mark.clipped:
            mark.draw(pen, view)


_EMPTY: Final = Marks(places=(), words=())


def _draw_axes(pen: Pen, axes: Axes, view: View) -> None:
    box = view.box
    x, y = axes.x.marks(box.width), axes.y.marks(box.height)
    at = {
        "x": view.across(np.array(x.places, float)).tolist(),
        "y": view.down(np.array(y.places, float)).tolist(),
        "small x": view.across(np.array(x.small, float)).tolist(),
        "small y": view.down(np.array(y.small, float)).tolist(),
    }
    grid = [(place, box.top, place, box.bottom) for place in at["x"] if axes.x.grid]
    grid += [(box.left, place, box.right, place) for place in at["y"] if axes.y.grid]
    pen.path(lines_path(grid), stroke=GRID, width=GRID_WIDTH)
    spines = [(box.left, box.top, box.left, box.bottom), (box.left, box.bottom, box.right, box.bottom)]
    if not (axes.equal and not x.places and not y.places):
        pen.path(lines_path(spines), stroke=SPINE, width=SPINE_WIDTH, cap="square")
    ticks = [(place, box.bottom, place, box.bottom + _TICK) for place in at["x"]]
    ticks += [(box.left, place, box.left - _TICK, place) for place in at["y"]]
    pen.path(lines_path(ticks), stroke=TICK, width=SPINE_WIDTH)
    small = [(place, box.bottom, place, box.bottom + _SMALL_TICK) for place in at["small x"]]
    small += [(box.left, place, box.left - _SMALL_TICK, place) for place in at["small y"]]
    pen.path(lines_path(small), stroke=SPINE, width=0.6)
    for place, word in zip(at["x"], x.words if axes.x.labelled else (), strict=False):
        level = box.bottom + _TICK + _PAD + CAPITAL * SMALL
        pen.words(word, place, level, size=SMALL, color=TICK, ha="center")
    for place, word in zip(at["y"], y.words if axes.y.labelled else (), strict=False):
        pen.words(word, box.left - _TICK - _PAD, place, size=SMALL, color=TICK, ha="right", va="center")
    _draw_labels(pen, axes, box, (x, y))


def _draw_labels(pen: Pen, axes: Axes, box: Box, marks: tuple[Marks, Marks]) -> None:
    """Write the names of both axes."""
    x, y = axes.x, axes.y
    if x.label:
        fall = DEPTH + LINE_HEIGHT * x.label.count("\n")
        level = box.bottom + _below(x, marks[0]) - fall * x.label_size
        pen.words(
            x.label,
            box.left + box.width / 2.0,
            level,
            size=x.label_size,
            color=x.label_color,
            bold=x.label_bold,
            ha="center",
        )
    if y.label:
        left, middle = box.left - _beside(y, marks[1]), box.top + box.height / 2.0
        turned = y.label_turned
        pen.words(
            y.label,
            left + (CAPITAL * y.label_size if turned else 0.0),
            middle,
            size=y.label_size,
            color=y.label_color,
            bold=y.label_bold,
            ha="center" if turned else "left",
            va="baseline" if turned else "center",
            rotation=90.0 if turned else 0.0,
        )


def _draw_heading(pen: Pen, axes: Axes, box: Box) -> None:
    told = axes.heading
    if not told.text:
        return
    share = {"left": 0.0, "center": 0.5, "right": 1.0}[told.loc]
    level = box.top - _TITLE_PAD - told.size * LINE_HEIGHT * told.text.count("\n")
    pen.words(
        told.text, box.left + share * box.width, level, size=told.size, color=told.color, bold=told.bold, ha=told.loc
    )


def _below(axis: Axis, marks: Marks) -> float:
    """Return the room below a panel: ticks, their words, the label."""
    room = _TICK if marks.places else 0.0
    if axis.labelled and any(marks.words):
        room += _PAD + height("", SMALL)
    if axis.label:
        room += _LABEL_PAD + height(axis.label, axis.label_size)
    return room


def _beside(axis: Axis, marks: Marks) -> float:
    """Return the room at the left of a panel."""
    room = _TICK if marks.places else 0.0
    if axis.labelled and any(marks.words):
        room += _PAD + max(width(word, SMALL) for word in marks.words)
    if axis.label:
        wide = width(axis.label, axis.label_size, bold=axis.label_bold)
        room += _LABEL_PAD + (height(axis.label, axis.label_size) if axis.label_turned else wide)
    return room


def _above(axes: Axes) -> float:
    told = axes.heading
    return _TITLE_PAD + height(told.text, told.size) - DEPTH * told.size if told.text else 0.0


def _edges(axis: Axis, marks: Marks, length: float) -> tuple[float, float]:
    """Return how far the words and the label of the abscissa stand out at the left and the right."""
    out = max((width(axis.label, axis.label_size, bold=axis.label_bold) - length) / 2.0, 0.0) if axis.label else 0.0
    if not (axis.labelled and marks.words):
        return out, out
    share = axis.scaled().share(np.array(marks.places, float))
    half = np.array([width(word, SMALL) / 2.0 for word in marks.words])
    places = share * length
    return max(float(np.max(half - places)), out), max(float(np.max(places + half - length)), out)
