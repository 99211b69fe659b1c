"""What a raw file looks like, on one sheet: the picture, its colour planes, its codes; and the four CFA orders."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from fullwell.report.drawing import GRAYS, Axes, Colors, Figure, key, shades
from fullwell.report.drawing.style import QUIET, LineStyle
from fullwell.report.plots import color_of, stepped
from fullwell.report.typesetting import png_of

_SIZE_IN: Final = (13.0, 9.4)
_SHEET_IN: Final = (13.0, 6.6)
_DPI: Final = 130
_UPPER: Final = 0.63
_LEFT: Final = 0.6
"""Shares of the sheet for all images, and of those for the picture."""
_BETWEEN: Final = 0.02
_CRISP: Final = 200
"""Pixels along the longer side up to which each of them is shown as a square."""
_MOST_STEPS: Final = 1500
"""Codes drawn one by one; where there are more, neighbours are counted together."""
_LEAST_NEAR: Final = 16
"""Codes above black that are shown near black at least [DN]."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Plane:
    """The pixels of one colour filter.

    Parameters
    ----------
    channel
        Its name.
    image
        What it looks like, from 0 to 1, shape (height, width).
    counts
        How often each code occurs, from code 0 on.
    black_level, white_level
        None where unknown [DN].

    """

    channel: str
    image: NDArray[np.float32]
    counts: NDArray[np.int64]
    black_level: float | None
    white_level: float | None


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Preview:
    """What one raw file looks like.

    Parameters
    ----------
    title, subtitle
        Which file it is, and what it says about itself.
    picture
        Display values from 0 to 1, shape (height, width, 3).
    caption
        How the picture was made.
    planes
        One, or four in the order of the CFA's sites.

    """

    title: str
    subtitle: str
    picture: NDArray[np.float32]
    caption: str
    planes: tuple[Plane, ...]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class OrderView:
    """A mosaic taken for one CFA order: the whole of it and a detail, display values, shapes (height, width, 3)."""

    order: str
    picture: NDArray[np.float32]
    detail: NDArray[np.float32]


def preview_png(preview: Preview) -> bytes:
    """Return the sheet of one file as a PNG."""
    figure = _sheet(_SIZE_IN, preview.title, preview.subtitle)
    (seen,) = figure.subplots(part=(0.0, 0.0, _LEFT, _UPPER))
    _show(seen, preview.picture, title="Picture")
    seen.set_xlabel(preview.caption, size=8.0, color=QUIET)
    _draw_planes(figure, preview.planes)
    _draw_codes(figure, preview.planes)
    return png_of(figure.svg(), per_inch=_DPI)


def orders_png(title: str, subtitle: str, views: Sequence[OrderView]) -> bytes:
    """Return a mosaic rendered in several CFA orders side by side as a PNG, a magnified detail below each.

    Parameters
    ----------
    title, subtitle
        Which file it is, and what to look for.
    views
        One per order.

    """
    figure = _sheet(_SHEET_IN, title, subtitle)
    height, width, _colours = views[0].picture.shape
    axes = figure.subplots(2, len(views), heights=(height / width, 1.0))
    for above, below, view in zip(axes, axes[len(views) :], views, strict=False):
        _show(above, view.picture, title=view.order)
        _show(below, view.detail, title="")
        below.set_xlabel("detail, pixel by pixel", size=8.0, color=QUIET)
    return png_of(figure.svg(), per_inch=_DPI)


def _sheet(size_in: tuple[float, float], title: str, subtitle: str) -> Figure:
    figure = Figure(size_in)
    figure.suptitle(title)
    figure.suptitle(subtitle, size=9.5, color=QUIET, bold=False)
    return figure


def _draw_planes(figure: Figure, planes: Sequence[Plane]) -> None:
    across = math.ceil(math.sqrt(len(planes)))
    axes = figure.subplots(across, across, part=(_LEFT + _BETWEEN, 0.0, 1.0, _UPPER))
    for panel, plane in zip(axes, planes, strict=True):
        if len(planes) > 1:
            own = shades("#000000", color_of(plane.channel), "#ffffff")
            _show(panel, plane.image, title=f"Plane {plane.channel}", colors=own)
        else:
            _show(panel, plane.image, title="Centre, pixel by pixel")


def _show(axes: Axes, image: NDArray[np.float32], *, title: str, colors: Colors = GRAYS) -> None:
    """Show display values from 0 to 1, of one colour or of three."""
    values = np.rint(255.0 * image.clip(0.0, 1.0)).astype(np.uint8) if image.ndim == 3 else image
    interpolation = "nearest" if max(image.shape[:2]) <= _CRISP else "smooth"
    axes.imshow(values, cmap=colors, vmin=0.0, vmax=1.0, interpolation=interpolation)
    axes.set_title(title)


def _draw_codes(figure: Figure, planes: Sequence[Plane]) -> None:
    whole, near = figure.subplots(1, 2, widths=(1.55, 1.0), part=(0.0, _UPPER + _BETWEEN, 1.0, 1.0))
    highest = max(int(np.flatnonzero(plane.counts)[-1]) for plane in planes)
    top = max([highest, *(math.ceil(plane.white_level) for plane in planes if plane.white_level is not None)])
    _draw_range(whole, planes, first=0, last=top)
    whole.set_title("Codes")
    whole.set_ylabel("pixels")
    first, last, title = _detail(planes, highest)
    _draw_range(near, planes, first=first, last=last)
    near.set_title(title)
    near.tick_params(axis="y", labels=False)
    ends = [*whole.get_ylim(), *near.get_ylim()]
    for axes in (whole, near):
        axes.set_ylim(min(ends), max(ends))
    keys = [key(one.channel, color=color_of(one.channel)) for one in planes]
    if any(plane.black_level is not None for plane in planes):
        keys.append(key("black level", linestyle="--", linewidth=1.0))
    if any(plane.white_level is not None for plane in planes):
        keys.append(key("white level", linestyle=":", linewidth=1.0))
    figure.legend(keys, loc="lower right", size=8.0)


def _detail(planes: Sequence[Plane], highest: int) -> tuple[int, int, str]:
    """Return the codes that are shown at large, first and last, and what they are.

    They go from the lowest to three times as far above black as it lies below; in a frame without black, from the
    lowest to the highest.
    """
    lowest = min(int(np.flatnonzero(plane.counts)[0]) for plane in planes)
    blacks = [plane.black_level for plane in planes if plane.black_level is not None]
    black = max(blacks) if blacks else lowest
    last = math.ceil(black + 3.0 * max(black - lowest, _LEAST_NEAR))
    if last <= lowest:
        return lowest, max(highest, lowest + 1), "Codes that occur"
    return lowest, min(last, max(highest, lowest + _LEAST_NEAR)), "Codes near black"


def _draw_range(axes: Axes, planes: Sequence[Plane], *, first: int, last: int) -> None:
    width = -(-(last - first + 1) // _MOST_STEPS)
    for plane in planes:
        counts = np.zeros(-(-(last - first + 1) // width) * width)
        part = plane.counts[first : last + 1]
        counts[: part.size] = part
        together = counts.reshape(-1, width).sum(axis=1)
        codes, shown = stepped(first + width * np.arange(together.size, dtype=np.float64), together)
        axes.plot(codes, shown, drawstyle="steps-post", color=color_of(plane.channel), linewidth=1.0)
        levels: tuple[tuple[float | None, LineStyle], ...] = ((plane.black_level, "--"), (plane.white_level, ":"))
        for level, dashes in levels:
            if level is not None and first <= level <= last:
                axes.axvline(level, color=color_of(plane.channel), linestyle=dashes, linewidth=1.1)
    margin = 0.01 * (last - first)
    axes.set_xlim(first - margin, last + width + margin)
    axes.set_yscale("log")
    axes.set_xlabel(f"DN, {width} codes together" if width > 1 else "DN")
