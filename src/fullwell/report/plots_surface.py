"""Surfaces over the sensor: in space, and flat with colours that diverge from zero.

Which function: `space` for the axes, `draw_surfaces` for one surface or several in one space, `draw_map` for a flat
map; `symmetric_limit` for the one range that several maps of differences share.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Final, cast

import numpy as np
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Colormap, LinearSegmentedColormap, Normalize, to_rgb
from matplotlib.figure import Figure
from matplotlib.gridspec import SubplotSpec
from matplotlib.ticker import MaxNLocator
from mpl_toolkits.mplot3d.art3d import Poly3DCollection
from mpl_toolkits.mplot3d.axes3d import Axes3D
from numpy.typing import NDArray

from fullwell.report.plots import QUIET, color_of

MOST_FACETS: Final = 40
DIVERGING: Final = "RdBu_r"
HEIGHTS: Final = "viridis"
_BOX: Final = (4.0, 3.0, 2.3)
_SMALL_PT: Final = 6.5
_LIGHT: Final = np.array([-0.45, 0.35, 0.82])
"""Where the light comes from: left, behind, above."""


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
    colors: str | Colormap = HEIGHTS


def channel_colors(channel: str) -> Colormap:
    """Return a colour map from a dark to a light shade of the channel's own colour."""
    full = np.array(to_rgb(color_of(channel)))
    shades = [tuple(0.55 * full), tuple(full), tuple(full + 0.5 * (1.0 - full))]
    return LinearSegmentedColormap.from_list(f"shades of {channel}", shades, N=64)


def space(figure: Figure, place: SubplotSpec) -> Axes3D:
    """Return axes in space, seen from the front left, with the first row of the plane at the back."""
    axes = figure.add_subplot(place, projection="3d")
    axes.view_init(elev=26.0, azim=-62.0)
    axes.set_box_aspect(_BOX)
    axes.tick_params(labelsize=_SMALL_PT, pad=-2.5, colors=QUIET)
    axes.grid(visible=False)
    return axes


def draw_surfaces(
    axes: Axes3D, surfaces: Sequence[Surface], *, limits: tuple[float, float] | None = None, most: int = MOST_FACETS
) -> None:
    """Draw surfaces in one space, those behind hidden by those in front, on at most ``most`` x ``most`` facets each.

    Parameters
    ----------
    axes
        From `space`.
    surfaces
        In any order.
    limits
        Lowest and highest value of the axis and the colours; those of the surfaces if not told.
    most
        Facets along each side.

    """
    low, high = limits or _limits([surface.values for surface in surfaces])
    quads: list[NDArray[np.float64]] = []
    colors: list[NDArray[np.float64]] = []
    for surface in surfaces:
        corners = _quads(surface, most)
        share = Normalize(low, high)(corners[:, :, 2].mean(axis=1))
        shade = ScalarMappable(cmap=surface.colors).get_cmap()(share)
        colors.append(_lit(np.asarray(shade, float), corners, high - low))
        quads.append(corners)
    drawn = Poly3DCollection(
        cast("Any", np.concatenate(quads)), facecolors=np.concatenate(colors), edgecolors="none", antialiaseds=False
    )
    axes.add_collection3d(drawn)
    ends = [(surface.columns[[0, -1]], surface.rows[[0, -1]]) for surface in surfaces]
    across = min(float(x.min()) for x, _ in ends), max(float(x.max()) for x, _ in ends)
    down = min(float(y.min()) for _, y in ends), max(float(y.max()) for _, y in ends)
    axes.set(xlim=across, ylim=down[::-1], zlim=(low, high))
    axes.set(xticks=_round_steps(*across), yticks=_round_steps(*down), zticks=_round_steps(low, high))


def draw_map(axes: Axes, values: NDArray[np.float64], *, limit: float | None = None) -> ScalarMappable:
    """Draw a flat map: about zero in diverging colours where a limit is told, else from its lowest to its highest.

    Parameters
    ----------
    axes
        To draw on.
    values
        NaN stays empty, shape (V, H).
    limit
        Value at both ends of the colours.

    """
    low, high = _limits([values]) if limit is None else (-limit, limit)
    colors = HEIGHTS if limit is None else DIVERGING
    shown = axes.imshow(values, cmap=colors, vmin=low, vmax=high, interpolation="nearest")
    axes.set(xticks=[], yticks=[], facecolor="#d5dbe1")
    axes.grid(visible=False)
    return shown


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


def _round_steps(low: float, high: float) -> list[float]:
    """Return two to four round values between the ends: every tick in space costs time to draw."""
    ticks = MaxNLocator(nbins=3, steps=[1, 2, 2.5, 5, 10]).tick_values(low, high)
    slack = 1e-9 * (high - low)
    return [float(tick) for tick in ticks if low - slack <= tick <= high + slack]


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


def _lit(colors: NDArray[np.float64], quads: NDArray[np.float64], height: float) -> NDArray[np.float64]:
    """Return the colours of facets under a lamp, so that slopes are seen, shape (facets, 4)."""
    if not len(quads):
        return colors
    extent = np.ptp(quads.reshape(-1, 3), axis=0)
    scale = np.array(_BOX) / np.where(extent > 0.0, extent, 1.0)
    scale[2] = _BOX[2] / height
    scale[1] *= -1.0
    first, second = (quads[:, 2] - quads[:, 0]) * scale, (quads[:, 3] - quads[:, 1]) * scale
    normal = np.cross(first, second)
    normal *= np.sign(normal[:, 2:]) / np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-30)
    bright = 0.62 + 0.42 * np.clip(normal @ _LIGHT, 0.0, 1.0)
    return np.clip(np.column_stack([colors[:, :3] * bright[:, None], colors[:, 3]]), 0.0, 1.0)
