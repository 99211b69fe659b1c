"""A raw frame developed for the eye: black off, white balanced, demosaicked along edges, colours and tones of sRGB."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from fullwell.raw.cfa import MONO
from fullwell.render.directional import demosaic_along_edges
from fullwell.render.tone import relative, srgb_curve

FloatImage = NDArray[np.float32]


def develop(
    mosaic: NDArray[np.uint16],
    *,
    cfa: str,
    black_level: Sequence[float],
    white_level: Sequence[float],
    neutral: Sequence[float] = (1.0, 1.0, 1.0),
    colour_matrix: NDArray[np.float64] | None = None,
) -> FloatImage:
    """Return a frame as display values.

    Parameters
    ----------
    mosaic
        Codes, shape (height, width), linear [DN].
    cfa
        Order at the top-left pixel, or ``mono``.
    black_level, white_level
        Per CFA site, row-major [DN].
    neutral
        White as the camera sees it: red, green, blue (DNG tag AsShotNeutral).
    colour_matrix
        Linear sRGB from the camera's balanced red, green and blue, shape (3, 3), white to white; None leaves colours.

    Returns
    -------
    ndarray
        sRGB from 0 to 1, shape (height, width, 3).

    """
    light = relative(mosaic, cfa=cfa, black_level=black_level, white_level=white_level)
    rgb = demosaic_along_edges(_balanced(light, cfa=cfa, neutral=neutral), cfa=cfa)
    if colour_matrix is not None:
        rgb = (rgb @ colour_matrix.T.astype(np.float32)).astype(np.float32)
    return srgb_curve(rgb)


def write_jpeg(path: Path, shown: FloatImage) -> None:
    """Write display values from 0 to 1, shape (height, width, 3), as a JPEG of 8 bits."""
    from PIL import Image  # noqa: PLC0415 - loads when used

    pixels = np.ascontiguousarray(np.rint(shown * np.float32(255.0)).astype(np.uint8))
    Image.fromarray(pixels).save(path, format="JPEG", quality=92, subsampling=0)


def _balanced(light: FloatImage, *, cfa: str, neutral: Sequence[float]) -> FloatImage:
    """Return a mosaic in which white has one value in all colours; what is beyond it is cut, so that it has no hue."""
    if cfa == MONO:
        return light
    out = light.copy()
    for site, letter in enumerate(cfa):
        window = (slice(site // 2, None, 2), slice(site % 2, None, 2))
        out[window] *= np.float32(max(neutral) / neutral["RGB".index(letter)])
    return np.minimum(out, np.float32(1.0), out=out)
