"""Arrays as pictures: PNG and JPEG as data URIs, and the mark that shows an array in a panel."""

import base64
import io
from dataclasses import dataclass
from typing import Final, Literal, TypeAlias

import numpy as np
from numpy.typing import NDArray

from fullwell.report.drawing.colors import Colors
from fullwell.report.drawing.geometry import Array, Box, View
from fullwell.report.drawing.pen import Pen

Interpolation: TypeAlias = Literal["nearest", "smooth"]
Values: TypeAlias = NDArray[np.float64] | NDArray[np.float32] | NDArray[np.uint8]

_PALETTE: Final = 3 * 256
_KNOWN: Final = 254
"""Last index of the colours of a palette; the one behind stands for what is unknown."""
_PER_POINT: Final = 2.2
"""Pixels of a point of length that are kept at most: no screen and no print shows more."""
_JPEG_QUALITY: Final = 92


def data_uri(image: bytes, *, kind: Literal["png", "jpeg", "svg+xml"] = "png") -> str:
    """Return a picture as a data URI."""
    return f"data:image/{kind};base64,{base64.b64encode(image).decode('ascii')}"


def png_uri(image: NDArray[np.uint8]) -> str:
    """Return colours, shape (V, H, 3), as the data URI of a PNG."""
    from PIL import Image  # noqa: PLC0415 - loads where there are pictures

    packed = io.BytesIO()
    Image.fromarray(image).save(packed, format="PNG")
    return data_uri(packed.getvalue())


def jpeg_uri(image: NDArray[np.uint8]) -> str:
    """Return colours, shape (V, H, 3), as the data URI of a JPEG: a fifth of a PNG where they are a photograph."""
    from PIL import Image  # noqa: PLC0415 - loads where there are pictures

    packed = io.BytesIO()
    Image.fromarray(image).save(packed, format="JPEG", quality=_JPEG_QUALITY, subsampling=0)
    return data_uri(packed.getvalue(), kind="jpeg")


def palette_uri(indices: NDArray[np.uint8], palette: NDArray[np.uint8], *, opacity: bytes) -> str:
    """Return indices into a palette as the data URI of a PNG.

    Parameters
    ----------
    indices
        Shape (V, H).
    palette
        Shape (colours, 3).
    opacity
        Of every colour, 0 to 255.

    """
    from PIL import Image  # noqa: PLC0415 - loads where there are pictures

    packed = io.BytesIO()
    image = Image.frombytes("P", indices.shape[::-1], np.ascontiguousarray(indices).tobytes())
    image.putpalette(palette.tobytes().ljust(_PALETTE, b"\0"))
    image.save(packed, format="PNG", transparency=opacity)
    return data_uri(packed.getvalue())


@dataclass(frozen=True, slots=True, kw_only=True)
class Shown:
    """An array shown as colours, with what a colour bar needs to know.

    Parameters
    ----------
    values
        Shape (V, H), NaN where unknown; or colours, shape (V, H, 3).
    colors
        Of the values.
    low, high
        Values at the ends of the colours.
    extent
        Left, right, bottom, top in the units of the axes.
    crisp
        Whether each pixel shall be seen as a square.

    """

    values: Values
    colors: Colors
    low: float
    high: float
    extent: tuple[float, float, float, float]
    crisp: bool
    zorder: float = 0.0
    clipped: bool = True

    def draw(self, pen: Pen, view: View) -> None:
        """Draw it."""
        left, right, bottom, top = self.extent
        x, y = view.across(np.array([left, right])), view.down(np.array([top, bottom]))
        box = Box(left=float(x[0]), top=float(y[0]), width=float(x[1] - x[0]), height=float(y[1] - y[0]))
        pen.image(self._uri(_seen(self.values, box) if self.crisp else self.values), box, crisp=self.crisp)

    def covered(self, view: View) -> Array:
        """Return a grid over it."""
        share = np.linspace(0.0, 1.0, 12)
        x, y = np.meshgrid(view.box.left + share * view.box.width, view.box.top + share * view.box.height)
        return np.column_stack([x.ravel(), y.ravel()])

    def _uri(self, values: Values) -> str:
        if values.ndim == 3:
            return (png_uri if self.crisp else jpeg_uri)(values.astype(np.uint8))
        share = (values.astype(float) - self.low) / ((self.high - self.low) or 1.0)
        count = min(len(self.colors.table), _KNOWN + 1)
        known = np.isfinite(share)
        indices = np.clip(np.where(known, share, 0.0) * count, 0, count - 1).astype(np.uint8)
        palette = self.colors.at(np.linspace(0.0, 1.0, count))
        shown = np.where(known, indices, count).astype(np.uint8)
        return palette_uri(shown, palette, opacity=b"\xff" * count + b"\0")


def _seen(values: Values, box: Box) -> Values:
    """Return no more pixels than a box of this size can show, each as it is."""
    kept = [
        np.unique(np.linspace(0, count - 1, min(count, max(int(length * _PER_POINT), 1))).round().astype(np.intp))
        for count, length in zip(values.shape[:2], (box.height, box.width), strict=True)
    ]
    return (
        values
        if all(len(one) == count for one, count in zip(kept, values.shape, strict=False))
        else values[np.ix_(*kept)]
    )
