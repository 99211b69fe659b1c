"""How lines and points look, and the options by which that is told."""

from dataclasses import dataclass
from typing import TypedDict

from fullwell.report.drawing import markers
from fullwell.report.drawing.geometry import Array
from fullwell.report.drawing.pen import Pen
from fullwell.report.drawing.style import INK, LINE, MARKER, PAPER, Fill, LineStyle, Marker, is_drawn


class LookOptions(TypedDict, total=False):
    """Options of lines and points.

    Parameters
    ----------
    color, linestyle, linewidth
        Of the line, and of the edges of the markers; width in points.
    marker, markersize
        Of the points [point].
    markerfacecolor
        Of the area of the markers: the line's own if not told, ``none`` leaves them hollow.
    markeredgewidth
        Of their edges [point].
    fillstyle
        Whether all of a marker is filled, nothing, or its left or lower half.
    alpha
        How far all of it hides what is below, 0 to 1.
    rounded
        Whether the line has round ends.

    """

    color: str
    linestyle: LineStyle
    linewidth: float
    marker: Marker
    markersize: float
    markerfacecolor: str
    markeredgewidth: float
    fillstyle: Fill
    alpha: float
    rounded: bool


@dataclass(frozen=True, slots=True, kw_only=True)
class Look:
    """How a line and its points look: see `LookOptions`; without a face of their own markers have the line's colour."""

    color: str = INK
    linestyle: LineStyle = "-"
    linewidth: float = LINE
    marker: Marker = ""
    markersize: float = MARKER
    markerfacecolor: str = ""
    markeredgewidth: float = 1.0
    fillstyle: Fill = "full"
    alpha: float = 1.0
    rounded: bool = False

    @property
    def face(self) -> str:
        """Return the colour of the area of the markers."""
        if self.fillstyle == "none" or self.marker in markers.LINES:
            return "none"
        return {"": self.color, "white": PAPER}.get(self.markerfacecolor, self.markerfacecolor)

    def stroke(self, pen: Pen, path: str) -> None:
        """Draw a line."""
        if is_drawn(self.linestyle) and self.linewidth > 0.0:
            cap = "round" if self.rounded else "butt"
            pen.path(path, stroke=self.color, width=self.linewidth, style=self.linestyle, alpha=self.alpha, cap=cap)

    def stamp(self, pen: Pen, x: Array, y: Array) -> None:
        """Draw the markers."""
        if not self.marker:
            return
        edge = self.color if self.markeredgewidth > 0.0 else "none"
        face = self.face
        if self.fillstyle in ("left", "bottom"):
            half = markers.half(self.marker, self.markersize, self.fillstyle)
            pen.stamps(half, x, y, stroke="none", width=0.0, fill=face, alpha=self.alpha)
            face = "none"
        shape = markers.outline(self.marker, self.markersize)
        pen.stamps(shape, x, y, stroke=edge, width=self.markeredgewidth, fill=face, alpha=self.alpha)
