"""Facets of surfaces, painted one over the other as pixels: thousands of polygons would make a heavy page."""

import math
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from fullwell.report.drawing.geometry import Array, Box, View
from fullwell.report.drawing.images import palette_uri
from fullwell.report.drawing.pen import Pen

_PER_POINT: Final = 3.0
"""Pixels of a point of length."""
_MOST_COLORS: Final = 255


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
    zorder: float
    clipped: bool = True

    def draw(self, pen: Pen, view: View) -> None:
        """Draw them as an image just as large as they need."""
        from PIL import Image, ImageDraw  # noqa: PLC0415 - loads where there are pixels

        x, y = self._places(view)
        if not x.size:
            return
        left, top = math.floor(x.min()), math.floor(y.min())
        width, height = math.ceil(x.max() + 1.0) - left, math.ceil(y.max() + 1.0) - top
        indices, palette = _palette(self.colors)
        painted = Image.new("L", (math.ceil(width * _PER_POINT), math.ceil(height * _PER_POINT)), _MOST_COLORS)
        brush = ImageDraw.Draw(painted)
        flat = np.stack([(x - left) * _PER_POINT, (y - top) * _PER_POINT], axis=-1).reshape(-1, 8)
        for outline, color in zip(flat.tolist(), indices.tolist(), strict=True):
            brush.polygon(outline, fill=color)
        covered = Box(left=left, top=top, width=painted.width / _PER_POINT, height=painted.height / _PER_POINT)
        pen.image(palette_uri(np.asarray(painted), palette, empty=_MOST_COLORS), covered, crisp=False)

    def covered(self, view: View) -> Array:
        """Return the corners."""
        x, y = self._places(view)
        return np.column_stack([x.ravel(), y.ravel()])

    def _places(self, view: View) -> tuple[Array, Array]:
        return view.across(self.corners[..., 0]), view.down(self.corners[..., 1])


def _palette(colors: NDArray[np.uint8]) -> tuple[NDArray[np.uint8], NDArray[np.uint8]]:
    """Return the index of every colour in a palette of few, and the palette."""
    from PIL import Image  # noqa: PLC0415 - as above

    few = Image.fromarray(colors[None]).quantize(_MOST_COLORS, dither=Image.Dither.NONE)
    palette = np.zeros((_MOST_COLORS + 1, 3), np.uint8)
    known = np.array(few.getpalette() or [], np.uint8).reshape(-1, 3)[:_MOST_COLORS]
    palette[: len(known)] = known
    return np.asarray(few)[0], palette
