"""A panel: what is drawn in it, and its two axes. The words are those of Matplotlib's axes where both know a thing."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal, TypeAlias

import numpy as np
from numpy.typing import NDArray

from fullwell.report.drawing.axis import Axis
from fullwell.report.drawing.colorbar import Bar
from fullwell.report.drawing.colors import VIRIDIS, Colors
from fullwell.report.drawing.geometry import Scale
from fullwell.report.drawing.images import Interpolation, Shown, Values
from fullwell.report.drawing.legend import Key, Place
from fullwell.report.drawing.painting import Painting
from fullwell.report.drawing.style import INK, LEGEND, LETTERS, TITLE, Across

Which: TypeAlias = Literal["x", "y", "both"]
Limit: TypeAlias = float | None


@dataclass(frozen=True, slots=True, kw_only=True)
class Heading:
    """The title of a panel."""

    text: str = ""
    loc: Across = "left"
    color: str = INK
    size: float = TITLE
    bold: bool = True


@dataclass(frozen=True, slots=True, kw_only=True)
class Inset:
    """A legend inside a panel."""

    keys: tuple[Key, ...]
    loc: Place
    size: float


class Axes(Painting):
    """A panel with its axes. Everything is drawn when the figure is: what is set last holds."""

    def __init__(self) -> None:
        super().__init__()
        self.heading = Heading()
        self.inset: Inset | None = None
        self.bar: Bar | None = None
        self.visible = True
        self.framed = True
        self.equal = False
        self.anchor: Literal["top", "middle", "bottom"] = "middle"
        self.paper = "none"

    def imshow(
        self,
        values: Values,
        *,
        cmap: Colors = VIRIDIS,
        vmin: float | None = None,
        vmax: float | None = None,
        extent: tuple[float, float, float, float] | None = None,
        interpolation: Interpolation = "nearest",
    ) -> Shown:
        """Show an array as an image of square pixels, its first row at the top, without ticks or grid.

        Parameters
        ----------
        values
            Shape (V, H), NaN stays empty; or colours from 0 to 255, shape (V, H, 3).
        cmap, vmin, vmax
            Colours, and the values at their ends: those of the array if not told.
        extent
            Left, right, bottom and top of the image; pixels about whole numbers if not told.
        interpolation
            Whether each pixel shall be seen; colours that need not be are kept as a photograph is, as JPEG.

        Returns
        -------
        Shown
            For `colorbar`.

        """
        height, width = values.shape[:2]
        extent = extent or (-0.5, width - 0.5, height - 0.5, -0.5)
        shown = self.image(values, cmap=cmap, vmin=vmin, vmax=vmax, extent=extent, interpolation=interpolation)
        self.set(xlim=extent[:2], ylim=extent[2:], xticks=(), yticks=())
        self.grid(visible=False)
        self.equal = True
        return shown

    def colorbar(
        self,
        shown: Shown,
        *,
        label: str = "",
        location: Literal["bottom", "right"] = "bottom",
        share: float = 0.8,
        extend: bool = False,
        size: float = LETTERS,
    ) -> None:
        """Put a bar of the colours beside the panel.

        Parameters
        ----------
        shown
            From `imshow`.
        label
            Of its axis.
        location
            Below or right of the panel.
        share
            Its length as a share of that of the panel.
        extend
            Whether pointed ends say that values go on beyond.
        size
            Of the letters [point].

        """
        self.bar = Bar(shown=shown, label=label, level=location == "bottom", share=share, extend=extend, size=size)

    def legend(self, keys: Sequence[Key] | None = None, *, loc: Place = "best", size: float = LEGEND) -> None:
        """Put a legend into the panel: of what has labels, if no keys are told."""
        keys = self.keys if keys is None else keys
        self.inset = Inset(keys=tuple(keys), loc=loc, size=size) if keys else None

    def set_title(
        self, text: str, *, loc: Across = "left", color: str = INK, size: float = TITLE, bold: bool = True
    ) -> None:
        """Name the panel."""
        self.heading = Heading(text=text, loc=loc, color=color, size=size, bold=bold)

    def set_xlabel(self, text: str, *, color: str = INK, size: float = LETTERS) -> None:
        """Name the abscissa."""
        self.x.label, self.x.label_color, self.x.label_size = text, color, size

    def set_ylabel(
        self, text: str, *, color: str = INK, size: float = LETTERS, bold: bool = False, turned: bool = True
    ) -> None:
        """Name the ordinate, turned or upright."""
        self.y.label, self.y.label_color, self.y.label_size, self.y.label_bold = text, color, size, bold
        self.y.label_turned = turned

    def set(
        self,
        *,
        title: str = "",
        xlabel: str = "",
        ylabel: str = "",
        xlim: tuple[Limit, Limit] | None = None,
        ylim: tuple[Limit, Limit] | None = None,
        xticks: Sequence[float] | None = None,
        yticks: Sequence[float] | None = None,
    ) -> None:
        """Set several things at once; what is not told stays."""
        if title:
            self.set_title(title)
        if xlabel:
            self.set_xlabel(xlabel)
        if ylabel:
            self.set_ylabel(ylabel)
        if xlim is not None:
            self.set_xlim(*xlim)
        if ylim is not None:
            self.set_ylim(*ylim)
        if xticks is not None:
            self.set_xticks(xticks)
        if yticks is not None:
            self.set_yticks(yticks)

    def get_xlim(self) -> tuple[float, float]:
        """Return the ends of the abscissa."""
        return self.x.ends()

    def get_ylim(self) -> tuple[float, float]:
        """Return the ends of the ordinate."""
        return self.y.ends()

    def set_xlim(self, left: Limit = None, right: Limit = None) -> None:
        """Set the ends of the abscissa; None leaves an end as it is."""
        self.x.low, self.x.high = self.x.low if left is None else left, self.x.high if right is None else right

    def set_ylim(self, bottom: Limit = None, top: Limit = None) -> None:
        """Set the ends of the ordinate; None leaves an end as it is."""
        self.y.low, self.y.high = self.y.low if bottom is None else bottom, self.y.high if top is None else top

    def set_xscale(self, scale: Literal["linear", "log", "powers"]) -> None:
        """Make the abscissa linear, logarithmic with plain numbers, or logarithmic with powers of ten."""
        self.x.scale = scale

    def set_yscale(self, scale: Literal["linear", "log", "powers"]) -> None:
        """Make the ordinate linear, logarithmic with plain numbers, or logarithmic with powers of ten."""
        self.y.scale = scale

    def scaled(self) -> tuple[Scale, Scale]:
        """Return both scales."""
        return self.x.scaled(), self.y.scaled()

    def margins(self, *, x: float | None = None, y: float | None = None) -> None:
        """Set how far the axes go beyond what is drawn, as shares of it."""
        self.x.margin = self.x.margin if x is None else x
        self.y.margin = self.y.margin if y is None else y

    def set_xticks(self, places: Sequence[float] | NDArray[np.float64], words: Sequence[str] | None = None) -> None:
        """Mark the abscissa at these places alone."""
        self.x.places, self.x.words = tuple(float(one) for one in places), None if words is None else tuple(words)

    def set_yticks(self, places: Sequence[float] | NDArray[np.float64], words: Sequence[str] | None = None) -> None:
        """Mark the ordinate at these places alone."""
        self.y.places, self.y.words = tuple(float(one) for one in places), None if words is None else tuple(words)

    def locator_params(self, *, axis: Which = "both", nbins: int, integer: bool = False) -> None:
        """Mark an axis in ``nbins`` steps at most, 3 at least; at whole numbers alone if told."""
        for one in self._axes(axis):
            one.most, one.whole = nbins, integer

    def tick_params(self, *, axis: Which, labels: bool) -> None:
        """Leave out the words at the marks of an axis."""
        for one in self._axes(axis):
            one.labelled = labels

    def grid(self, *, visible: bool, axis: Which = "both") -> None:
        """Draw lines at the marks of an axis or none."""
        for one in self._axes(axis):
            one.grid = visible

    def invert_yaxis(self) -> None:
        """Let the ordinate fall."""
        self.y.turned = not self.y.turned

    def set_axis_off(self) -> None:
        """Draw no axes."""
        self.framed = False

    def _axes(self, which: Which) -> tuple[Axis, ...]:
        return {"x": (self.x,), "y": (self.y,), "both": (self.x, self.y)}[which]
