"""Facets of surfaces, painted one over the other as pixels: thousands of polygons would make a heavy page."""

import math
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from fullwell.raw.png_writing import flat_png
from fullwell.report.drawing.geometry import Array, Box, View
from fullwell.report.drawing.images import data_uri
from fullwell.report.drawing.pen import Pen

_PER_POINT: Final = 2.0
"""Pixels of a point of length."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Facets:
    """Filled polygons of four corners, the first painted first.

    Parameters
    ----------
    corners
        In the units of the axes, shape (facets, 4, 2).
    colors
        Shape (facets, 3).

    """

    corners: NDArray[np.float64]
    colors: NDArray[np.uint8]
    zorder: float = 1.0
    clipped: bool = True

    def draw(self, pen: Pen, view: View) -> None:
        """Draw them as an image just as large as they need."""
        from PIL import Image, ImageDraw  # noqa: PLC0415 - loads where there are pixels

        x, y = self._places(view)
        if not x.size:
            return
        left, top = math.floor(x.min()), math.floor(y.min())
        width, height = math.ceil(x.max() + 1.0) - left, math.ceil(y.max() + 1.0) - top
        size = (math.ceil(width * _PER_POINT), math.ceil(height * _PER_POINT))
        painted = Image.new("RGBA", size, (0, 0, 0, 0))
        brush = ImageDraw.Draw(painted)
        flat = np.stack([(x - left) * _PER_POINT, (y - top) * _PER_POINT], axis=-1).reshape(-1, 8)
        for outline, color in zip(flat.tolist(), self.colors.tolist(), strict=True):
            brush.polygon(outline, fill=(*color, 255))
        covered = Box(left=left, top=top, width=size[0] / _PER_POINT, height=size[1] / _PER_POINT)
        pen.image(data_uri(flat_png(np.asarray(painted))), covered, crisp=False)

    def covered(self, view: View) -> Array:
        """Return the corners."""
        x, y = self._places(view)
        return np.column_stack([x.ravel(), y.ravel()])

    def _places(self, view: View) -> tuple[Array, Array]:
        return view.across(self.corners[..., 0]), view.down(self.corners[..., 1])
