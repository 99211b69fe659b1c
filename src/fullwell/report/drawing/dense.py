"""Points too many to be drawn one by one: as pixels in one image, which stays small however many they are."""

import math
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from fullwell.report.drawing import markers
from fullwell.report.drawing.colors import rgb
from fullwell.report.drawing.geometry import Array, Box, View
from fullwell.report.drawing.images import palette_uri
from fullwell.report.drawing.look import Look
from fullwell.report.drawing.pen import Pen

_PER_POINT: Final = 2.0
"""Pixels of a point of length."""
_FINE: Final = 4
"""Parts of a pixel along each side, by which the shape of a marker is known."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Cloud:
    """Points of one look without a line."""

    x: Array
    y: Array
    look: Look
    zorder: float
    clipped: bool = True

    def draw(self, pen: Pen, view: View) -> None:
        """Draw them as an image of the whole panel."""
        box = view.box
        x = (view.across(self.x) - box.left) * _PER_POINT
        y = (view.down(self.y) - box.top) * _PER_POINT
        width, height = math.ceil(box.width * _PER_POINT), math.ceil(box.height * _PER_POINT)
        inside = (x >= 0.0) & (x < width) & (y >= 0.0) & (y < height)
        if not inside.any():
            return
        opacity = _opacity(x[inside], y[inside], (height, width), _mask(self.look), self.look.alpha)
        levels = np.round(255.0 * opacity).astype(np.uint8)
        uri = palette_uri(levels, np.tile(rgb(self.look.color), (256, 1)), opacity=bytes(range(256)))
        covered = Box(left=box.left, top=box.top, width=width / _PER_POINT, height=height / _PER_POINT)
        pen.image(uri, covered, crisp=False)

    def covered(self, view: View) -> Array:
        """Return the points."""
        places = np.column_stack([view.across(self.x), view.down(self.y)])
        return places[np.isfinite(places).all(axis=1)]


def _opacity(
    x: Array, y: Array, shape: tuple[int, int], mask: NDArray[np.float64], alpha: float
) -> NDArray[np.float64]:
    """Return how far the paper is hidden: layers of marks let through what is left of each.

    Parameters
    ----------
    x, y
        Places [pixel].
    shape
        Rows and columns of the image.
    mask
        What a marker covers of the pixels around its middle.
    alpha
        Of a marker.

    """
    reach = mask.shape[0] // 2
    rows, columns = shape[0] + 2 * reach, shape[1] + 2 * reach
    down, across = np.nonzero(mask)
    places = (np.floor(y).astype(np.int64)[:, None] + down) * columns + np.floor(x).astype(np.int64)[:, None] + across
    through = np.log1p(-np.minimum(alpha * mask[down, across], 0.999))
    total = np.bincount(places.ravel(), np.broadcast_to(through, places.shape).ravel(), rows * columns)
    return 1.0 - np.exp(total.reshape(rows, columns)[reach : reach + shape[0], reach : reach + shape[1]])


def _mask(look: Look) -> NDArray[np.float64]:
    """Return the share of each pixel that a marker in the middle covers, of odd sides."""
    from PIL import Image, ImageDraw  # noqa: PLC0415 - loads where there are pixels

    size, edge = look.markersize * _PER_POINT * _FINE, look.markeredgewidth * _PER_POINT * _FINE
    side = 2 * math.ceil((0.75 * size + edge) / _FINE) + 1
    drawn = Image.new("L", (side * _FINE, side * _FINE))
    ink, middle = ImageDraw.Draw(drawn), side * _FINE / 2.0
    if look.marker in markers.LINES:
        reach = size / 2.0
        for x, y in ((1.0, 1.0), (1.0, -1.0)) if look.marker == "x" else ((1.0, 0.0), (0.0, 1.0)):
            ends = (middle - x * reach, middle - y * reach, middle + x * reach, middle + y * reach)
            ink.line(ends, fill=255, width=max(round(edge), 1))
    else:
        hollow = look.face == "none"
        corners = [(middle + size * x, middle + size * y) for x, y in markers.corners(look.marker).tolist()]
        if not hollow:
            ink.polygon(corners, fill=255)
        if edge or hollow:
            ink.line([*corners, *corners[:2]], fill=255, width=max(round(edge), 1), joint="curve")
    fine = np.asarray(drawn, float).reshape(side, _FINE, side, _FINE) / 255.0
    return fine.mean(axis=(1, 3))
