"""Every pixel gets its two missing colours: gradient-corrected linear interpolation (Malvar, He and Cutler 2004)."""

import numpy as np
from numpy.typing import NDArray

from fullwell.raw.cfa import MONO

FloatImage = NDArray[np.float32]
_MARGIN = 2


def demosaic(mosaic: FloatImage, *, cfa: str) -> FloatImage:
    """Return the three colours of every pixel.

    A missing colour is its bilinear estimate plus a share of the Laplacian of the colour that is there: 1/2 for green
    at red and blue, 5/8 for red and blue at green, 3/4 for red at blue and blue at red.

    Parameters
    ----------
    mosaic
        Shape (height, width), any linear scale; levels must be balanced between colours only for the eye.
    cfa
        Order at the top-left pixel, or ``mono``.

    Returns
    -------
    ndarray
        Shape (height, width, 3), the scale of ``mosaic``; red, green, blue. What a pixel measured is kept as it is.

    References
    ----------
    H. S. Malvar, L.-W. He, R. Cutler, "High-quality linear interpolation for demosaicing of Bayer-patterned color
    images", ICASSP 2004.

    """
    if cfa == MONO:
        return np.repeat(mosaic[:, :, np.newaxis], 3, axis=2)
    out = np.empty((*mosaic.shape, 3), dtype=np.float32)
    padded = np.pad(mosaic, _MARGIN, mode="reflect")  # keeps the phase of the pattern
    for site, letter in enumerate(cfa):
        row, column = divmod(site, 2)
        own, beside, below = ("RGB".index(cfa[place]) for place in (site, site ^ 1, site ^ 2))
        target = out[row::2, column::2]
        target[..., own] = mosaic[row::2, column::2]
        if letter == "G":
            target[..., beside], target[..., below] = _red_and_blue_at_green(padded, row, column, target.shape)
        else:
            target[..., 1], target[..., 2 - own] = _green_and_opposite(padded, row, column, target.shape)
    return out


def _green_and_opposite(
    padded: FloatImage, row: int, column: int, shape: tuple[int, ...]
) -> tuple[FloatImage, FloatImage]:
    """Return green and the opposite colour at the sites of red, or of blue."""
    centre = _around(padded, row, column, shape, ((0, 0),))
    sides = _around(padded, row, column, shape, ((-1, 0), (1, 0), (0, -1), (0, 1)))
    corners = _around(padded, row, column, shape, ((-1, -1), (-1, 1), (1, -1), (1, 1)))
    far = _around(padded, row, column, shape, ((-2, 0), (2, 0), (0, -2), (0, 2)))
    green = (4.0 * centre + 2.0 * sides - far) / 8.0
    opposite = (6.0 * centre + 2.0 * corners - 1.5 * far) / 8.0
    return green.astype(np.float32, copy=False), opposite.astype(np.float32, copy=False)


def _red_and_blue_at_green(
    padded: FloatImage, row: int, column: int, shape: tuple[int, ...]
) -> tuple[FloatImage, FloatImage]:
    """Return the colour of the neighbours beside, and of those above and below, at the sites of one green."""
    centre = _around(padded, row, column, shape, ((0, 0),))
    beside = _around(padded, row, column, shape, ((0, -1), (0, 1)))
    below = _around(padded, row, column, shape, ((-1, 0), (1, 0)))
    corners = _around(padded, row, column, shape, ((-1, -1), (-1, 1), (1, -1), (1, 1)))
    far_beside = _around(padded, row, column, shape, ((0, -2), (0, 2)))
    far_below = _around(padded, row, column, shape, ((-2, 0), (2, 0)))
    shared = 5.0 * centre - corners
    level = (shared + 4.0 * beside - far_beside + 0.5 * far_below) / 8.0
    upright = (shared + 4.0 * below - far_below + 0.5 * far_beside) / 8.0
    return level.astype(np.float32, copy=False), upright.astype(np.float32, copy=False)


def _around(
    padded: FloatImage, row: int, column: int, shape: tuple[int, ...], steps: tuple[tuple[int, int], ...]
) -> FloatImage:
    """Return the sum of the neighbours at some steps from each pixel of a site."""
    total = np.zeros(shape[:2], dtype=np.float32)
    for down, across in steps:
        top, left = _MARGIN + row + down, _MARGIN + column + across
        total += padded[top : top + 2 * shape[0] : 2, left : left + 2 * shape[1] : 2][: shape[0], : shape[1]]
    return total
