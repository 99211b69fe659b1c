"""A mosaic as a picture to look at, and the picture as a PNG file: the door to Pillow."""

from collections.abc import Sequence
from pathlib import Path
from typing import Final, Literal

import numpy as np
from numpy.typing import NDArray

from fullwell.errors import UsageError
from fullwell.render.demosaic import demosaic
from fullwell.render.tone import srgb_curve, white_balanced

FloatImage = NDArray[np.float32]
Style = Literal["linear", "srgb"]

STYLES: Final[tuple[Style, ...]] = ("linear", "srgb")
"""``linear`` is demosaicked and nothing else, ``srgb`` white balanced; both are shown through the sRGB curve."""
LONGEST_SIDE: Final = 2048
"""Pictures are made smaller until no side is longer [pixel]."""

_TURNS: Final = {1: 0, 2: 0, 3: 2, 4: 2, 5: 3, 6: 3, 7: 1, 8: 1}
"""Quarter turns to the left that put a stored picture upright, by the TIFF tag Orientation; before the mirror."""
_MIRRORED: Final = (2, 4, 5, 7)


def developed(light: FloatImage, *, cfa: str) -> FloatImage:
    """Return a mosaic with all colours at every pixel, still linear.

    Parameters
    ----------
    light
        Mosaic from black 0 to white 1, shape (height, width).
    cfa
        Order at the top-left pixel, or ``mono``.

    Returns
    -------
    ndarray
        Shape (height, width, 3), no side longer than `LONGEST_SIDE`.

    """
    return reduced(demosaic(light, cfa=cfa), longest=LONGEST_SIDE)


def picture(rgb: FloatImage, *, style: Style, neutral: Sequence[float], orientation: int = 1) -> FloatImage:
    """Return a linear picture as it is looked at.

    Parameters
    ----------
    rgb
        What `developed` returns.
    style
        One of `STYLES`.
    neutral
        White as the camera sees it; used by ``srgb`` alone.
    orientation
        TIFF tag Orientation.

    Returns
    -------
    ndarray
        Display values from 0 to 1, upright, of the same size.

    """
    balanced = white_balanced(rgb, neutral=neutral) if style == "srgb" else rgb
    return upright(srgb_curve(balanced), orientation)


def reduced(rgb: FloatImage, *, longest: int) -> FloatImage:
    """Return a linear picture made smaller by a whole number, each pixel the mean of a square.

    Parameters
    ----------
    rgb
        Shape (height, width, 3).
    longest
        No side of the result is longer [pixel]. Rows and columns that fill no square are left out.

    """
    height, width, colours = rgb.shape
    step = -(-max(height, width) // longest)
    if step == 1:
        return rgb
    down, across = max(height // step, 1), max(width // step, 1)
    squares = rgb[: down * step, : across * step].reshape(down, min(step, height), across, min(step, width), colours)
    return squares.mean(axis=(1, 3), dtype=np.float32)


def upright(rgb: FloatImage, orientation: int) -> FloatImage:
    """Return a stored picture as its TIFF tag Orientation wants it shown."""
    turned = np.rot90(rgb, _TURNS.get(orientation, 0))
    return turned[:, ::-1] if orientation in _MIRRORED else turned


def write_png(path: Path, shown: FloatImage) -> None:
    """Write display values from 0 to 1, shape (height, width, 3), as a PNG of 8 bits."""
    from PIL import Image  # noqa: PLC0415 - loads when used

    pixels = np.ascontiguousarray(np.rint(shown * np.float32(255.0)).astype(np.uint8))
    Image.fromarray(pixels).save(path, format="PNG", compress_level=4)


def read_picture(path: Path) -> FloatImage:
    """Read a developed picture: JPEG, PNG, TIFF, whatever Pillow reads.

    Returns
    -------
    ndarray
        Display values from 0 to 1 as they are stored, shape (height, width, 1 or 3).

    Raises
    ------
    UsageError
        Where the file is missing or no picture.

    """
    from PIL import Image, UnidentifiedImageError  # noqa: PLC0415 - loads when used

    try:
        with Image.open(path) as stored:
            wide = stored.mode.startswith("I;16")
            values = np.asarray(stored if wide or stored.mode in {"L", "RGB"} else stored.convert("RGB"))
    except FileNotFoundError:
        raise UsageError(f"{path} does not exist. Give a developed picture of the scene, a JPEG or PNG.") from None
    except (OSError, UnidentifiedImageError, Image.DecompressionBombError) as error:
        raise UsageError(f"{path} cannot be read as a picture ({error}). Give a JPEG or PNG.") from None
    largest = np.float32(np.iinfo(values.dtype).max)
    shown = values.astype(np.float32) / largest
    return shown[..., None] if shown.ndim == 2 else shown
