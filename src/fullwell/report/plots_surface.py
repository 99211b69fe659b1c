"""Surfaces over the sensor: in space, and flat with colours that diverge from zero.

Which function: `space` for the axes, `draw_surfaces` for one surface or several in one space, `draw_map` for a flat
map; `symmetric_limit` for the one range that several maps of differences share.

Space is projected here and drawn on flat axes: some eighty surfaces of a report would take seconds longer otherwise.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from fullwell.report.drawing import DIVERGING, VIRIDIS, Axes, Colors, Shown, rgb, shades
from fullwell.report.drawing.colors import hexadecimal
from fullwell.report.drawing.style import QUIET, SPINE
from fullwell.report.drawing.ticks import linear_ticks, minus
from fullwell.report.plots import color_of

MOST_FACETS: Final = 40
_SMALL_PT: Final = 6.5

_BOX: Final = np.array([4.0, 3.0, 2.3])
"""Width, depth and height of the space."""

_TURN: Final = np.radians(28.0)
_TILT: Final = np.radians(26.0)
"""Seen from the front, a little from the left and from above."""

_LIGHT: Final = np.array([-0.45, 0.35, 0.82])
"""Where the light comes from: left, behind, above."""

_PANES: Final = np.array(
    [
        [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]],
        [[0, 1, 0], [1, 1, 0], [1, 1, 1], [0, 1, 1]],
        [[0, 0, 0], [0, 1, 0], [0, 1, 1], [0, 0, 1]],
    ],
    float,
)
"""Floor, back and left wall, in shares of the box."""

_WALLS: Final = ("#f4f5f6", "#f0f1f3", "#f8f9fa")

_EDGES: Final = np.array([[[0, 0, 0], [1, 0, 0]], [[1, 0, 0], [1, 1, 0]], [[1, 1, 0], [1, 1, 1]]], float)
"""Where the three axes stand: column in front, row at the right, height at the right behind."""

_OUTWARD: Final = ((0.0, -0.16), (0.16, -0.08), (0.14, 0.0))
"""Where the labels of the three axes stand beside their ticks."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Surface:
    """One surface over the plane.

    Parameters
    ----------
    rows, columns
        Positions of the points, shapes (V,) and (H,).
    values
        Heights, NaN where unknown, shape (V, H).
    colors
        Colour map of the heights.

    """

    rows: NDArray[np.float64]
    columns: NDArray[np.float64]
    values: NDArray[np.float64]
    colors: Colors = VIRIDIS


def channel_colors(channel: str) -> Colors:
    """Return a colour map from a dark to a light shade of the channel's own colour."""
    full = rgb(color_of(channel)).astype(float)
    dark, light = (0.55 * full).astype(np.uint8), (full + 0.5 * (255.0 - full)).astype(np.uint8)
    return shades(hexadecimal(dark.tolist()), color_of(channel), hexadecimal(light.tolist()), count=64)


def space(axes: Axes) -> None:
    """Make a panel one to draw surfaces on."""
    axes.set_axis_off()
    axes.equal = True
    axes.set(xlim=(-0.1, 5.6), ylim=(-1.15, 3.3))


def draw_surfaces(
    axes: Axes, surfaces: Sequence[Surface], *, limits: tuple[float, float] | None = None, most: int = MOST_FACETS
) -> None:
    """Draw surfaces in one space, those behind hidden by those in front; the first row of the plane at the back.

    Parameters
    ----------
    axes
        From `space`.
    surfaces
        In any order.
    limits
        Lowest and highest value of the axis and the colours; those of the surfaces if not told.
    most
        Facets along each side of each surface.

    """
    low, high = limits or _limits([surface.values for surface in surfaces])
    columns = _ends([surface.columns for surface in surfaces])
    rows = _ends([surface.rows for surface in surfaces])
    origin = np.array([columns[0], rows[1], low])
    scale = _BOX / np.array([columns[1] - columns[0], rows[0] - rows[1], high - low])
    quads: list[NDArray[np.float64]] = []
    colors: list[NDArray[np.uint8]] = []
    for surface in surfaces:
        corners = _quads(surface, most)
        share = (corners[:, :, 2].mean(axis=1) - low) / (high - low)
        corners = (corners - origin) * scale
        colors.append(_lit(surface.colors.at(share), corners))
        quads.append(corners)
    _frame(axes, columns, rows, (low, high))
    points, distance = _projected(np.concatenate(quads))
    behind = np.argsort(-distance.mean(axis=1), kind="stable")
    axes.facets(points[behind], np.concatenate(colors)[behind])


def draw_map(
    axes: Axes,
    values: NDArray[np.float64],
    *,
    limit: float | None = None,
    ends: tuple[float, float] | None = None,
) -> Shown:
    """Draw a flat map: about zero in diverging colours where a limit is told, else from its lowest to its highest.

    Parameters
    ----------
    axes
        To draw on.
    values
        NaN stays empty, shape (V, H).
    limit
        Magnitude at both ends of diverging colours.
    ends
        Values at the ends of the others.

    """
    low, high = ends or _limits([values]) if limit is None else (-limit, limit)
    axes.paper = "#d5dbe1"
    return axes.imshow(values, cmap=VIRIDIS if limit is None else DIVERGING, vmin=low, vmax=high)


def symmetric_limit(*values: NDArray[np.float64], share: float = 99.5, least: float = 1e-9) -> float:
    """Return the magnitude that a share [%] of all values stay below: the common end of diverging colours."""
    every = np.concatenate([np.abs(one[np.isfinite(one)]) for one in values]) if values else np.array([])
    return max(float(np.percentile(every, share)), least) if every.size else least


def _limits(values: Sequence[NDArray[np.float64]]) -> tuple[float, float]:
    every = np.concatenate([one[np.isfinite(one)] for one in values])
    if not every.size:
        return 0.0, 1.0
    low, high = float(every.min()), float(every.max())
    return (low, high) if high > low else (low - 0.5, high + 0.5)


def _ends(positions: Sequence[NDArray[np.float64]]) -> tuple[float, float]:
    return min(float(one.min()) for one in positions), max(float(one.max()) for one in positions)


def _thin(count: int, most: int) -> NDArray[np.intp]:
    return np.unique(np.linspace(0, count - 1, min(count, most + 1)).round().astype(np.intp))


def _quads(surface: Surface, most: int) -> NDArray[np.float64]:
    """Return the facets whose four corners are known, shape (facets, 4, 3)."""
    rows, columns = _thin(len(surface.rows), most), _thin(len(surface.columns), most)
    x, y = np.meshgrid(surface.columns[columns], surface.rows[rows])
    points = np.stack([x, y, surface.values[np.ix_(rows, columns)]], axis=-1)
    corners = [points[:-1, :-1], points[:-1, 1:], points[1:, 1:], points[1:, :-1]]
    quads = np.stack(corners, axis=-2).reshape(-1, 4, 3)
    return quads[np.isfinite(quads[:, :, 2]).all(axis=1)]


def _lit(colors: NDArray[np.uint8], quads: NDArray[np.float64]) -> NDArray[np.uint8]:
    """Return the colours of facets under a lamp, so that slopes are seen, shape (facets, 3)."""
    normal = np.cross(quads[:, 2] - quads[:, 0], quads[:, 3] - quads[:, 1])
    normal *= np.sign(normal[:, 2:]) / np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-30)
    bright = 0.62 + 0.42 * np.clip(normal @ _LIGHT, 0.0, 1.0)
    return np.clip(colors * bright[:, None], 0.0, 255.0).round().astype(np.uint8)


def _projected(points: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return where points of the box are seen, shape (..., 2), and how far away they are, shape (...)."""
    across, away, up = np.moveaxis(points, -1, 0)
    right = np.cos(_TURN) * across + np.sin(_TURN) * away
    depth = np.cos(_TURN) * away - np.sin(_TURN) * across
    seen = np.stack([right, np.cos(_TILT) * up + np.sin(_TILT) * depth], axis=-1)
    return seen, np.cos(_TILT) * depth - np.sin(_TILT) * up


def _frame(axes: Axes, columns: tuple[float, float], rows: tuple[float, float], heights: tuple[float, float]) -> None:
    """Draw the walls, the three axes and their ticks behind everything."""
    walls, _ = _projected(_PANES * _BOX)
    for wall, color in zip(walls, _WALLS, strict=True):
        axes.fill(wall[:, 0], wall[:, 1], color=color, zorder=0.0)
    lines, _ = _projected(_EDGES * _BOX)
    for (start, end), ends, outward in zip(lines, (columns, (rows[1], rows[0]), heights), _OUTWARD, strict=True):
        _edge(axes, start, end, ends, np.array(outward))


def _edge(
    axes: Axes,
    start: NDArray[np.float64],
    end: NDArray[np.float64],
    ends: tuple[float, float],
    outward: NDArray[np.float64],
) -> None:
    """Draw an axis of the space with its ticks and their numbers."""
    axes.plot(*np.stack([start, end], axis=1), color=SPINE, linewidth=0.7, zorder=0.5)
    for tick in linear_ticks(min(ends), max(ends), most=3):
        at = start + (end - start) * (tick - ends[0]) / (ends[1] - ends[0])
        axes.plot(*np.stack([at, at + 0.4 * outward], axis=1), color=SPINE, linewidth=0.7, zorder=0.5)
        x, y = (at + outward).tolist()
        axes.text(
            x,
            y,
            minus(f"{tick:g}"),
            size=_SMALL_PT,
            color=QUIET,
            ha="left" if outward[0] else "center",
            va="top" if outward[1] else "center",
        )
