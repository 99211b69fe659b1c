"""A contact sheet: one file read in several ways, side by side, for an eye that knows at once which is right."""

import math
from collections.abc import Sequence
from pathlib import Path
from typing import Final

import numpy as np
from numpy.typing import NDArray

_CELL: Final = (320, 260)
_CAPTION: Final = 44
_MARGIN: Final = 8
_INK: Final = 0
_PAPER: Final = 255
_DARKEST: Final = 0.01
_BRIGHTEST: Final = 0.995


def write_contact_sheet(path: Path, shown: Sequence[tuple[str, NDArray[np.uint16]]], *, across: int = 3) -> None:
    """Write captioned thumbnails of mosaics as a PNG, from left to right and top to bottom.

    Parameters
    ----------
    path
        The PNG; its folder must exist.
    shown
        Caption, of one or two lines, and mosaic of each, shape (height, width) [DN].
    across
        Thumbnails side by side.

    """
    from PIL import Image, ImageDraw  # noqa: PLC0415 - loads when used

    columns = min(across, len(shown))
    width, height = _CELL[0] + _MARGIN, _CELL[1] + _CAPTION + _MARGIN
    sheet = Image.new("L", (columns * width + _MARGIN, -(-len(shown) // columns) * height + _MARGIN), _PAPER)
    pen = ImageDraw.Draw(sheet)
    for index, (caption, mosaic) in enumerate(shown):
        left, top = _MARGIN + index % columns * width, _MARGIN + index // columns * height
        pen.multiline_text((left, top), caption, fill=_INK)
        sheet.paste(Image.fromarray(thumbnail(mosaic, width=_CELL[0], height=_CELL[1])), (left, top + _CAPTION))
    sheet.save(path, format="PNG")


def thumbnail(mosaic: NDArray[np.uint16], *, width: int, height: int) -> NDArray[np.uint8]:
    """Return a mosaic in greys, no larger than a frame, its cells of 2 x 2 pixels averaged and its tones stretched.

    Parameters
    ----------
    mosaic
        Codes, at least 2 x 2 [DN].
    width, height
        Of the frame [pixel].

    """
    rows, columns = mosaic.shape
    step = max(2, 2 * math.ceil(max(columns / width, rows / height) / 2))
    across, down = min(step, columns), min(step, rows)
    whole = mosaic[: rows // down * down, : columns // across * across]
    light = whole.reshape(rows // down, down, columns // across, across).mean(axis=(1, 3), dtype=np.float64)
    dark, bright = np.quantile(light, (_DARKEST, _BRIGHTEST))
    tone = np.sqrt(np.clip((light - dark) / max(bright - dark, 1e-9), 0.0, 1.0))
    return np.round(255.0 * tone).astype(np.uint8)
