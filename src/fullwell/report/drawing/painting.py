"""What can be drawn in a panel: lines, points, errors, bands, polygons, images, words."""

from collections.abc import Sequence
from typing import Unpack

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fullwell.report.drawing.axis import Axis
from fullwell.report.drawing.colors import VIRIDIS, Colors
from fullwell.report.drawing.dense import Cloud
from fullwell.report.drawing.facets import Facets
from fullwell.report.drawing.geometry import Array
from fullwell.report.drawing.images import Interpolation, Shown, Values
from fullwell.report.drawing.legend import Key
from fullwell.report.drawing.look import Look, LookOptions
from fullwell.report.drawing.marks import Area, Bars, Course, DrawStyle, Mark, Rule, Span
from fullwell.report.drawing.notes import Arrow, Facts, Note, NoteOptions
from fullwell.report.drawing.style import INK, LINE, LineStyle, is_drawn


class Painting:
    """The inside of a panel. What is drawn is remembered with its values, and drawn with the figure."""

    def __init__(self) -> None:
        self.x = Axis(across=True)
        self.y = Axis(across=False)
        self.marks: list[Mark] = []
        self.keys: list[Key] = []
        """Of what has a label."""

    def plot(
        self,
        x: ArrayLike,
        y: ArrayLike,
        *,
        drawstyle: DrawStyle = "default",
        dense: bool = False,
        clip_on: bool = True,
        zorder: float = 2.0,
        label: str = "",
        **options: Unpack[LookOptions],
    ) -> None:
        """Draw points, and the line through them; NaN leaves a gap.

        Parameters
        ----------
        x, y
            Shape (points,), or one value.
        drawstyle
            Whether points are joined by lines or by steps.
        dense
            Whether the points are drawn as pixels, below all lines: for many hundreds of them.
        clip_on
            Whether they end at the edge of the panel.
        zorder
            What is higher is drawn later.
        label
            In the legend.
        options
            See `LookOptions`.

        """
        look = Look(**options)
        across, up = self._seen(x, y)
        if dense and not is_drawn(look.linestyle):
            self._add(Cloud(x=across, y=up, look=look, zorder=-1.0))
        else:
            self._add(Course(x=across, y=up, look=look, drawstyle=drawstyle, zorder=zorder, clipped=clip_on))
        if label:
            self.keys.append(Key(label=label, look=look))

    def errorbar(
        self,
        x: ArrayLike,
        y: ArrayLike,
        *,
        xerr: ArrayLike | None = None,
        yerr: ArrayLike | None = None,
        elinewidth: float = 0.9,
        capsize: float = 0.0,
        **options: Unpack[LookOptions],
    ) -> None:
        """Draw points with errors: those of one length both ways, or a pair of lengths below and above.

        Parameters
        ----------
        x, y
            Shape (points,).
        xerr, yerr
            Errors along each axis, shape (points,) or (2, points); a point without an error has NaN.
        elinewidth, capsize
            Width of the bars, half the width of their caps [point].
        options
            As in `plot`.

        """
        for error, upright in ((xerr, False), (yerr, True)):
            if error is not None:
                places, low, high = self._ends(x, y, error, upright=upright)
                bars = Bars(
                    places=places,
                    low=low,
                    high=high,
                    upright=upright,
                    colors=(options.get("color", INK),),
                    linewidth=elinewidth,
                    capsize=capsize,
                )
                self._add(bars)
        self.plot(x, y, **options)

    def vlines(
        self, x: ArrayLike, low: ArrayLike, high: ArrayLike, *, colors: Sequence[str] = (INK,), linewidth: float = LINE
    ) -> None:
        """Draw upright lines from low to high, of one colour or each of its own."""
        places, ends = self._seen(x, low)
        _, tops = self._seen(x, high)
        bars = Bars(places=places, low=ends, high=tops, upright=True, colors=tuple(colors), linewidth=linewidth)
        self._add(bars)

    def axhline(self, y: float, *, zorder: float = 2.0, label: str = "", **options: Unpack[LookOptions]) -> None:
        """Draw a level line through the whole panel; options as in `plot`."""
        self.y.see(np.array([y]))
        look = Look(**options)
        self._add(Rule(at=y, level=True, look=look, zorder=zorder))
        if label:
            self.keys.append(Key(label=label, look=look))

    def axvline(self, x: float, *, zorder: float = 2.0, **options: Unpack[LookOptions]) -> None:
        """Draw an upright line through the whole panel; options as in `plot`."""
        self.x.see(np.array([x]))
        self._add(Rule(at=x, level=False, look=Look(**options), zorder=zorder))

    def axhspan(self, low: float, high: float, *, color: str, alpha: float = 1.0) -> None:
        """Draw a level band through the whole panel, below all else."""
        self.y.see(np.array([low, high]))
        self._add(Span(low=low, high=high, level=True, color=color, alpha=alpha))

    def axvspan(self, low: float, high: float, *, color: str) -> None:
        """Draw an upright band through the whole panel, below all else."""
        self.x.see(np.array([low, high]))
        self._add(Span(low=low, high=high, level=False, color=color))

    def fill(
        self,
        x: ArrayLike,
        y: ArrayLike,
        *,
        color: str = "none",
        edgecolor: str = "none",
        linewidth: float = 1.0,
        linestyle: LineStyle = "-",
        halo: str = "",
        zorder: float = 1.0,
    ) -> None:
        """Draw a polygon, filled, outlined or both; ``halo`` is the colour of a broader line below its outline."""
        across, up = self._seen(x, y)
        area = Area(
            x=across,
            y=up,
            fill=color,
            edge=edgecolor,
            linewidth=linewidth,
            linestyle=linestyle,
            halo=halo,
            zorder=zorder,
        )
        self._add(area)

    def rectangle(
        self,
        x: float,
        y: float,
        width: float,
        height: float,
        *,
        edgecolor: str,
        linewidth: float,
        halo: str = "",
    ) -> None:
        """Outline a rectangle from a corner on."""
        across, up = [x, x + width, x + width, x], [y, y, y + height, y + height]
        self.fill(across, up, edgecolor=edgecolor, linewidth=linewidth, halo=halo)

    def facets(self, corners: NDArray[np.float64], colors: NDArray[np.uint8]) -> None:
        """Draw filled polygons of four corners, shape (facets, 4, 2), the first painted first, as pixels."""
        self._add(Facets(corners=corners, colors=colors))

    def image(
        self,
        values: Values,
        *,
        cmap: Colors = VIRIDIS,
        vmin: float | None = None,
        vmax: float | None = None,
        extent: tuple[float, float, float, float],
        interpolation: Interpolation = "nearest",
    ) -> Shown:
        """Show an array as colours: see `Axes.imshow`, which sets the axes too."""
        known = values[np.isfinite(values)] if vmin is None or vmax is None else np.empty(0)
        ends = (float(known.min()), float(known.max())) if known.size else (0.0, 1.0)
        shown = Shown(
            values=values,
            colors=cmap,
            low=ends[0] if vmin is None else vmin,
            high=ends[1] if vmax is None else vmax,
            extent=extent,
            crisp=interpolation == "nearest",
        )
        self._add(shown)
        return shown

    def text(self, x: float, y: float, text: str, **options: Unpack[NoteOptions]) -> None:
        """Write at a point of the panel; options as in `NoteOptions`, ``^{2}`` raises, ``_{min}`` lowers."""
        self._add(Note(text=text, x=x, y=y, **options))

    def arrow(self, start: tuple[float, float], end: tuple[float, float]) -> None:
        """Draw an arrow with heads at both ends."""
        self._add(Arrow(start=start, end=end))

    def facts(self, lines: Sequence[tuple[str, str]], *, corner: tuple[float, float], right: bool = False) -> None:
        """Write names and values as two columns in a box.

        Parameters
        ----------
        lines
            Each a name and a value; without any there is no box.
        corner
            Top left of the box as shares of the panel; top right with ``right``.
        right
            Whether the corner is the right one.

        """
        if lines:
            self._add(Facts(lines=tuple(lines), corner=corner, right=right))

    def _add(self, mark: Mark) -> None:
        self.marks.append(mark)

    def _seen(self, x: ArrayLike, y: ArrayLike) -> tuple[Array, Array]:
        """Return points as arrays; the axes know of them from now on."""
        across, up = np.broadcast_arrays(np.atleast_1d(np.asarray(x, float)), np.atleast_1d(np.asarray(y, float)))
        shown = np.isfinite(across) & np.isfinite(up)
        self.x.see(across[shown])
        self.y.see(up[shown])
        return across, up

    def _ends(self, x: ArrayLike, y: ArrayLike, error: ArrayLike, *, upright: bool) -> tuple[Array, Array, Array]:
        """Return places along one axis with the ends of their errors on the other."""
        across, up = np.atleast_1d(np.asarray(x, float)), np.atleast_1d(np.asarray(y, float))
        below, above = np.broadcast_to(np.abs(np.asarray(error, float)), (2, len(across)))
        middle = up if upright else across
        low, high = middle - below, middle + above
        for end in (low, high):
            self._seen(*((across, end) if upright else (end, up)))
        return (across if upright else up), low, high
