"""A sheet of panels: grids that are laid out by measuring what stands around each panel, legends outside of them."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Final, Literal

import numpy as np

from fullwell.report.drawing.axes import Axes
from fullwell.report.drawing.colorbar import Bar
from fullwell.report.drawing.frame import Margins, draw_panel, margins
from fullwell.report.drawing.geometry import Array, Box
from fullwell.report.drawing.images import Shown
from fullwell.report.drawing.legend import Key, Legend
from fullwell.report.drawing.pen import Pen
from fullwell.report.drawing.style import INK, LEGEND, PAPER
from fullwell.report.drawing.text import CAPITAL, height

_INCH: Final = 72.0
_EDGE: Final = 3.0
"""Left empty around everything [point]."""
_BETWEEN: Final = 13.0
"""Between what stands around neighbouring panels [point]."""
_BAR: Final = 0.45
"""Length of a bar of colours that all panels share, as a share of the width."""
_TURNS: Final = 3
"""Ticks depend on the size of a panel and it on what they need: this often both are reckoned."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Cell:
    """A panel and the cells of a row of the grid that it takes."""

    axes: Axes
    row: int
    column: int
    columns: int = 1


@dataclass(slots=True)
class Grid:
    """Rows and columns of panels in a part of the sheet.

    Parameters
    ----------
    rows, columns
        How many.
    heights, widths
        Of the rows and columns in proportion.
    part
        Left, top, right and bottom as shares of what the figure leaves for panels.
    cells
        The panels.

    """

    rows: int
    columns: int
    heights: Sequence[float]
    widths: Sequence[float]
    part: tuple[float, float, float, float] = (0.0, 0.0, 1.0, 1.0)
    cells: list[Cell] = field(default_factory=list[Cell])

    def axes(self, row: int, column: int, *, columns: int = 1) -> Axes:
        """Return a new panel that takes a cell, or several of a row."""
        axes = Axes()
        self.cells.append(Cell(axes=axes, row=row, column=column, columns=columns))
        return axes

    def lines(self) -> list[list[Axes]]:
        """Return a new panel for every cell, row by row."""
        return [[self.axes(row, column) for column in range(self.columns)] for row in range(self.rows)]

    def placed(self, whole: Box) -> list[tuple[Axes, Box]]:
        """Return the panels with their boxes: ticks and boxes are reckoned in turns until both agree."""
        left, top, right, bottom = self.part
        room = whole.inside(
            left=left * whole.width,
            top=top * whole.height,
            right=(1.0 - right) * whole.width,
            bottom=(1.0 - bottom) * whole.height,
        )
        boxes = [Box(left=0.0, top=0.0, width=room.width / self.columns, height=room.height / self.rows)] * len(
            self.cells
        )
        for _ in range(_TURNS):
            boxes = self._boxes(room, [margins(cell.axes, box) for cell, box in zip(self.cells, boxes, strict=True)])
        return [(cell.axes, box) for cell, box in zip(self.cells, boxes, strict=True)]

    def _boxes(self, room: Box, needed: Sequence[Margins]) -> list[Box]:
        """Return a box for every panel within what they need around them."""
        across = _tracks(
            room.left,
            room.width,
            self.widths,
            [(cell.column, cell.columns, need.left, need.right) for cell, need in zip(self.cells, needed, strict=True)],
        )
        down = _tracks(
            room.top,
            room.height,
            self.heights,
            [(cell.row, 1, need.top, need.bottom) for cell, need in zip(self.cells, needed, strict=True)],
        )
        boxes: list[Box] = []
        for cell in self.cells:
            left, right = across[cell.column][0], across[cell.column + cell.columns - 1][1]
            top, bottom = down[cell.row]
            boxes.append(Box(left=left, top=top, width=right - left, height=bottom - top))
        return boxes


@dataclass(frozen=True, slots=True, kw_only=True)
class Said:
    """A line at the top of the sheet."""

    text: str
    size: float
    color: str
    bold: bool


class Figure:
    """A sheet.

    Parameters
    ----------
    figsize
        Width and height [inch].

    """

    def __init__(self, figsize: tuple[float, float]) -> None:
        self.width, self.height = figsize[0] * _INCH, figsize[1] * _INCH
        self._grids: list[Grid] = []
        self._placed: list[tuple[Axes, Box]] = []
        self._titles: list[Said] = []
        self._legend: tuple[Legend, bool] | None = None
        self._bar: Bar | None = None

    def subplots(
        self,
        rows: int = 1,
        columns: int = 1,
        *,
        heights: Sequence[float] | None = None,
        widths: Sequence[float] | None = None,
        part: tuple[float, float, float, float] = (0.0, 0.0, 1.0, 1.0),
    ) -> list[Axes]:
        """Return a grid of panels, row by row.

        Parameters
        ----------
        rows, columns
            How many.
        heights, widths
            Of the rows and columns in proportion; all alike if not told.
        part
            Left, top, right and bottom of the grid as shares of the sheet, without titles and outer legend.

        """
        grid = self.grid(rows, columns, heights=heights, widths=widths, part=part)
        return [axes for line in grid.lines() for axes in line]

    def grid(
        self,
        rows: int,
        columns: int,
        *,
        heights: Sequence[float] | None = None,
        widths: Sequence[float] | None = None,
        part: tuple[float, float, float, float] = (0.0, 0.0, 1.0, 1.0),
    ) -> Grid:
        """Return an empty grid, whose panels may take several cells of a row."""
        heights, widths = heights or [1.0] * rows, widths or [1.0] * columns
        grid = Grid(rows=rows, columns=columns, heights=heights, widths=widths, part=part)
        self._grids.append(grid)
        return grid

    def add_axes(self, place: tuple[float, float, float, float]) -> Axes:
        """Return a panel whose box is left, bottom, width and height as shares of the sheet."""
        left, bottom, width, height = place
        axes = Axes()
        box = Box(
            left=left * self.width,
            top=(1.0 - bottom - height) * self.height,
            width=width * self.width,
            height=height * self.height,
        )
        self._placed.append((axes, box))
        return axes

    def suptitle(self, text: str, *, size: float = 13.0, color: str = INK, bold: bool = True) -> None:
        """Write a line at the top of the sheet, below those that stand there already."""
        self._titles.append(Said(text=text, size=size, color=color, bold=bold))

    def legend(
        self,
        keys: Sequence[Key],
        *,
        loc: Literal["upper right", "lower right"] = "upper right",
        columns: int | None = None,
        size: float = LEGEND,
    ) -> None:
        """Put a legend above or below all panels, at the right."""
        if keys:
            self._legend = Legend(keys=tuple(keys), columns=columns or len(keys), size=size), loc == "upper right"

    def colorbar(self, shown: Shown, *, label: str, extend: bool = False) -> None:
        """Put a bar of the colours that all panels share below them; see `Axes.colorbar`."""
        self._bar = Bar(shown=shown, label=label, level=True, share=_BAR, extend=extend)

    def svg(self) -> bytes:
        """Return the drawing as SVG, the same bytes for the same drawing."""
        pen = Pen(self.width, self.height)
        sheet = Box(left=0.0, top=0.0, width=self.width, height=self.height)
        pen.box(sheet, fill=PAPER)
        room = self._draw_outside(pen, sheet.inside(left=_EDGE, top=_EDGE, right=_EDGE, bottom=_EDGE))
        for axes, box in [*self._placed, *(one for grid in self._grids for one in grid.placed(room))]:
            draw_panel(pen, axes, box)
        return pen.drawing()

    def _draw_outside(self, pen: Pen, room: Box) -> Box:
        """Draw titles, legend and colour bar at the edges of the sheet and return what is left."""
        for said in self._titles:
            pen.words(
                said.text, room.left, room.top + CAPITAL * said.size, size=said.size, color=said.color, bold=said.bold
            )
            room = room.inside(top=height(said.text, said.size) + 0.45 * said.size)
        if self._legend:
            legend, above = self._legend
            wide, high = legend.extent
            legend.draw(pen, room.right - wide, room.top if above else room.bottom - high)
            room = room.inside(top=high + 4.0) if above else room.inside(bottom=high + 4.0)
        if self._bar:
            needed = self._bar.room(room.width)
            room = room.inside(bottom=needed)
            self._bar.draw(pen, room)
        return room


def _tracks(
    start: float,
    length: float,
    shares: Sequence[float],
    needs: Sequence[tuple[int, int, float, float]],
) -> list[tuple[float, float]]:
    """Return start and end of the boxes of each row or column.

    Parameters
    ----------
    start, length
        Of the room [point].
    shares
        Of the rows or columns in proportion.
    needs
        First row or column of each panel, how many it takes, and what it needs before and behind its box.

    """
    before: Array = np.zeros(len(shares))
    behind: Array = np.zeros(len(shares))
    for first, count, low, high in needs:
        before[first] = max(before[first], low)
        behind[first + count - 1] = max(behind[first + count - 1], high)
    free = max(length - float(before.sum() + behind.sum()) - _BETWEEN * (len(shares) - 1), 1.0)
    sizes = free * np.array(shares) / sum(shares)
    taken = before + sizes + behind + _BETWEEN
    starts = start + before + np.concatenate([[0.0], np.cumsum(taken)[:-1]])
    return list(zip(starts.tolist(), (starts + sizes).tolist(), strict=True))
