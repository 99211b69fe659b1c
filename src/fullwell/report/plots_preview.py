"""What a raw file looks like, on one sheet: the picture, its colour planes, its codes; and the four CFA orders."""

import io
import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.colors import LinearSegmentedColormap
from matplotlib.figure import Figure, SubFigure
from matplotlib.lines import Line2D
from numpy.typing import NDArray

from fullwell.report.plots import INK, QUIET, color_of, log_axis, stepped, style

_SIZE_IN: Final = (13.0, 9.4)
_SHEET_IN: Final = (13.0, 6.6)
_DPI: Final = 130
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
    with style():
        figure = Figure(figsize=_SIZE_IN, layout="constrained")
        figure.suptitle(preview.title, x=0.008, ha="left", fontsize=13, fontweight="bold")
        above, below = np.ravel(figure.subfigures(2, 1, squeeze=False, height_ratios=(1.75, 1.0)))
        above.suptitle(preview.subtitle, x=0.008, ha="left", fontsize=9.5, color=QUIET)
        left, right = np.ravel(above.subfigures(1, 2, squeeze=False, width_ratios=(1.55, 1.0)))
        seen = left.subplots()
        _show(seen, preview.picture, title="Picture")
        seen.set_xlabel(preview.caption, fontsize=8, color=QUIET)
        _draw_planes(right, preview.planes)
        _draw_codes(below, preview.planes)
        return _png(figure)


def orders_png(title: str, subtitle: str, views: Sequence[OrderView]) -> bytes:
    """Return a mosaic rendered in several CFA orders side by side as a PNG, a magnified detail below each.

    Parameters
    ----------
    title, subtitle
        Which file it is, and what to look for.
    views
        One per order.

    """
    with style():
        figure = Figure(figsize=_SHEET_IN, layout="constrained")
        figure.suptitle(title, x=0.008, ha="left", fontsize=13, fontweight="bold")
        (body,) = np.ravel(figure.subfigures(1, 1, squeeze=False))
        body.suptitle(subtitle, x=0.008, ha="left", fontsize=9.5, color=QUIET)
        height, width, _colours = views[0].picture.shape
        axes = body.subplots(2, len(views), squeeze=False, height_ratios=(height / width, 1.0))
        for column, view in enumerate(views):
            _show(axes[0, column], view.picture, title=view.order)
            _show(axes[1, column], view.detail, title="")
            axes[1, column].set_xlabel("detail, pixel by pixel", fontsize=8, color=QUIET)
        return _png(figure)


def _draw_planes(figure: SubFigure, planes: Sequence[Plane]) -> None:
    across = math.ceil(math.sqrt(len(planes)))
    axes = np.ravel(figure.subplots(across, across, squeeze=False))
    for panel, plane in zip(axes, planes, strict=True):
        shades = LinearSegmentedColormap.from_list(plane.channel, ["#000000", color_of(plane.channel), "#ffffff"])
        title = f"Plane {plane.channel}" if len(planes) > 1 else "Centre, pixel by pixel"
        _show(panel, plane.image, title=title, shades=shades if len(planes) > 1 else "gray")


def _show(
    axes: Axes, image: NDArray[np.float32], *, title: str, shades: LinearSegmentedColormap | str = "gray"
) -> None:
    axes.imshow(image.clip(0.0, 1.0), cmap=shades, vmin=0.0, vmax=1.0, interpolation="nearest")
    axes.set_title(title)
    axes.grid(visible=False)
    axes.set_xticks([])
    axes.set_yticks([])
    for side in axes.spines.values():
        side.set_visible(False)


def _draw_codes(figure: SubFigure, planes: Sequence[Plane]) -> None:
    whole, near = figure.subplots(1, 2, width_ratios=(1.55, 1.0), sharey=True)
    highest = max(int(np.flatnonzero(plane.counts)[-1]) for plane in planes)
    top = max([highest, *(math.ceil(plane.white_level) for plane in planes if plane.white_level is not None)])
    _draw_range(whole, planes, first=0, last=top)
    whole.set_title("Codes")
    whole.set_ylabel("pixels")
    first, last, title = _detail(planes, highest)
    _draw_range(near, planes, first=first, last=last)
    near.set_title(title)
    log_axis(whole, "y")
    names = [Line2D([], [], color=color_of(one.channel), label=one.channel) for one in planes]
    lines: list[Line2D] = []
    if any(plane.black_level is not None for plane in planes):
        lines.append(Line2D([], [], color=INK, linestyle="--", label="black level", linewidth=1.0))
    if any(plane.white_level is not None for plane in planes):
        lines.append(Line2D([], [], color=INK, linestyle=":", label="white level", linewidth=1.0))
    figure.legend(handles=[*names, *lines], loc="outside upper right", ncols=len(names) + 2, fontsize=8)


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
        axes.step(codes, shown, where="post", color=color_of(plane.channel), linewidth=1.0)
        for level, kind in ((plane.black_level, "--"), (plane.white_level, ":")):
            if level is not None and first <= level <= last:
                axes.axvline(level, color=color_of(plane.channel), linestyle=kind, linewidth=1.1)
    margin = 0.01 * (last - first)
    axes.set_xlim(first - margin, last + width + margin)
    axes.set_yscale("log")
    axes.set_xlabel(f"DN, {width} codes together" if width > 1 else "DN")


def _png(figure: Figure) -> bytes:
    packed = io.BytesIO()
    FigureCanvasAgg(figure)
    figure.savefig(packed, format="png", dpi=_DPI, metadata={"Software": None})
    return packed.getvalue()
