"""What is drawn in a panel: each mark knows what it draws and, for the place of a legend, which points it covers."""

from dataclasses import dataclass
from typing import Final, Literal, Protocol, TypeAlias

import numpy as np
from numpy.typing import NDArray

from fullwell.report.drawing.geometry import Array, Box, View
from fullwell.report.drawing.look import Look
from fullwell.report.drawing.pen import Pen, lines_path, polygon, polyline
from fullwell.report.drawing.style import LineStyle, is_drawn
from fullwell.report.drawing.thinning import thinned

DrawStyle: TypeAlias = Literal["default", "steps-mid", "steps-post"]

_LARGEST: Final = 12.0
"""Half the size of the largest marker [point]."""
_NOTHING: Final = np.empty((0, 2))


class Mark(Protocol):
    """Something drawn."""

    @property
    def zorder(self) -> float:
        """Return its layer: what is higher covers what is lower."""
        ...

    @property
    def clipped(self) -> bool:
        """Tell whether it ends at the edge of the panel."""
        ...

    def draw(self, pen: Pen, view: View) -> None:
        """Draw it."""
        ...

    def covered(self, view: View) -> Array:
        """Return places that it covers, shape (places, 2)."""
        ...


@dataclass(frozen=True, slots=True, kw_only=True)
class Course:
    """Points, and the line through them."""

    x: Array
    y: Array
    look: Look
    drawstyle: DrawStyle = "default"
    zorder: float = 2.0
    clipped: bool = True

    def draw(self, pen: Pen, view: View) -> None:
        """Draw the line, then the markers."""
        x, y = view.across(self.x), view.down(self.y)
        self.look.stroke(pen, _course_path(x, y, self.drawstyle))
        if self.look.marker:
            shown = np.isfinite(x) & np.isfinite(y)
            shown = shown & _near(view.box, x, y) if self.clipped else shown
            self.look.stamp(pen, x[shown], y[shown])

    def covered(self, view: View) -> Array:
        """Return the points, and others on the line between them."""
        places = np.column_stack([view.across(self.x), view.down(self.y)])
        places = places[np.isfinite(places).all(axis=1)]
        if is_drawn(self.look.linestyle) and len(places) > 1:
            share = np.linspace(0.0, 1.0, 9)[:, None, None]
            places = (places[:-1] + share * np.diff(places, axis=0)).reshape(-1, 2)
        return places


@dataclass(frozen=True, slots=True, kw_only=True)
class Bars:
    """Errors as lines from low to high at places, with caps at their ends."""

    places: Array
    low: Array
    high: Array
    upright: bool
    colors: tuple[str, ...]
    linewidth: float
    capsize: float = 0.0
    zorder: float = 2.0
    clipped: bool = True

    def draw(self, pen: Pen, view: View) -> None:
        """Draw the bars, those of one colour as one path."""
        along = view.across if self.upright else view.down
        upon = view.down if self.upright else view.across
        place, low, high = along(self.places), upon(self.low), upon(self.high)
        known = np.isfinite(place) & np.isfinite(low) & np.isfinite(high) & (low != high)
        colors = self.colors if len(self.colors) == len(place) else self.colors[:1] * len(place)
        for color in dict.fromkeys(colors):
            mine = known & np.array([one == color for one in colors])
            path = self._path(place[mine], low[mine], high[mine])
            pen.path(path, stroke=color, width=self.linewidth)

    def covered(self, view: View) -> Array:
        """Return the ends."""
        along = view.across if self.upright else view.down
        upon = view.down if self.upright else view.across
        ends = [np.column_stack([along(self.places), upon(end)]) for end in (self.low, self.high)]
        places = np.concatenate(ends)
        places = places[np.isfinite(places).all(axis=1)]
        return places if self.upright else places[:, ::-1]

    def _path(self, place: Array, low: Array, high: Array) -> str:
        lines = [place, low, place, high]
        size = self.capsize
        caps = [[place - size, end, place + size, end] for end in (low, high)] if size else []
        ends = np.concatenate([np.column_stack(one) for one in (lines, *caps)]) if place.size else np.empty((0, 4))
        return lines_path((ends if self.upright else ends[:, [1, 0, 3, 2]]).tolist())


@dataclass(frozen=True, slots=True, kw_only=True)
class Rule:
    """A line through the whole panel at a value of one axis."""

    at: float
    level: bool
    look: Look
    zorder: float
    clipped: bool = True

    def draw(self, pen: Pen, view: View) -> None:
        """Draw it."""
        box = view.box
        if self.level:
            place = float(view.down(np.array(self.at)))
            ends = (box.left, place, box.right, place)
        else:
            place = float(view.across(np.array(self.at)))
            ends = (place, box.top, place, box.bottom)
        self.look.stroke(pen, lines_path([ends]))

    def covered(self, view: View) -> Array:
        """Return points along it."""
        box, share = view.box, np.linspace(0.0, 1.0, 25)
        if self.level:
            place = np.full(share.shape, float(view.down(np.array(self.at))))
            return np.column_stack([box.left + share * box.width, place])
        place = np.full(share.shape, float(view.across(np.array(self.at))))
        return np.column_stack([place, box.top + share * box.height])


@dataclass(frozen=True, slots=True, kw_only=True)
class Span:
    """A band through the whole panel between two values of one axis."""

    low: float
    high: float
    level: bool
    color: str
    alpha: float = 1.0
    zorder: float = -2.0
    clipped: bool = True

    def draw(self, pen: Pen, view: View) -> None:
        """Draw it."""
        box, ends = view.box, np.array([self.low, self.high])
        first, last = sorted((view.down if self.level else view.across)(ends).tolist())
        if self.level:
            band = Box(left=box.left, top=first, width=box.width, height=last - first)
        else:
            band = Box(left=first, top=box.top, width=last - first, height=box.height)
        pen.box(band, fill=self.color, alpha=self.alpha)

    def covered(self, view: View) -> Array:
        """Return nothing: a legend may stand upon it."""
        del view
        return _NOTHING


@dataclass(frozen=True, slots=True, kw_only=True)
class Area:
    """A polygon, filled, outlined or both; ``halo`` is the colour of a broader line below the outline."""

    x: Array
    y: Array
    fill: str = "none"
    edge: str = "none"
    linewidth: float = 1.0
    linestyle: LineStyle = "-"
    halo: str = ""
    zorder: float = 1.0
    clipped: bool = True

    def draw(self, pen: Pen, view: View) -> None:
        """Draw it."""
        path = polygon(view.across(self.x), view.down(self.y))
        if self.halo:
            pen.path(path, stroke=self.halo, width=self.linewidth + 1.3)
        pen.path(path, fill=self.fill, stroke=self.edge, width=self.linewidth, style=self.linestyle)

    def covered(self, view: View) -> Array:
        """Return its corners."""
        return np.column_stack([view.across(self.x), view.down(self.y)])


def _course_path(x: Array, y: Array, drawstyle: DrawStyle) -> str:
    if drawstyle == "default":
        return polyline(*thinned(x, y))
    if drawstyle == "steps-mid":
        middle = (x[1:] + x[:-1]) / 2.0
        edges = np.concatenate([x[:1], np.repeat(middle, 2), x[-1:]])
        return polyline(*thinned(edges, np.repeat(y, 2)))
    return polyline(*thinned(np.repeat(x, 2)[1:], np.repeat(y, 2)[:-1]))


def _near(box: Box, x: Array, y: Array) -> NDArray[np.bool_]:
    """Tell which points may be seen in a box, their markers reckoned in."""
    wide = box.widened(_LARGEST)
    return (x >= wide.left) & (x <= wide.right) & (y >= wide.top) & (y <= wide.bottom)
