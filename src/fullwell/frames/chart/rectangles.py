"""The largest upright rectangle inside a quadrilateral, on even pixels."""

import math
from typing import Final

import numpy as np
from numpy.typing import NDArray

_SHAPES: Final = 2.0 ** np.linspace(-4.0, 4.0, 65)
"""Ratios of width to height that are tried."""
_NARROW: Final = 12.0
"""Edge below which a rectangle had better be shorter and wider [pixel]."""


def inner_rectangle(corners: NDArray[np.float64]) -> tuple[int, int, int, int]:
    """Return x, y, width and height of the largest upright rectangle around the middle of a convex quadrilateral.

    Where even the largest is narrow, a smaller one that is less so is taken.

    Parameters
    ----------
    corners
        Its corners in order, shape (4, 2); an even pixel begins at its own number [pixel].

    Examples
    --------
    >>> inner_rectangle(np.array([(0.0, 1.0), (41.0, 1.0), (41.0, 31.0), (0.0, 31.0)]))
    (0, 2, 40, 28)

    """
    middle = corners.mean(axis=0)
    edges = np.roll(corners, -1, axis=0) - corners
    normals = np.column_stack((edges[:, 1], -edges[:, 0]))
    distance = np.abs(np.sum(normals * (corners - middle), axis=1))
    width, height = np.sqrt(_SHAPES), 1.0 / np.sqrt(_SHAPES)
    reach = np.abs(normals[:, :1]) * width + np.abs(normals[:, 1:]) * height
    scale = np.min(distance[:, None] / np.maximum(reach, 1e-12), axis=0)
    narrow = 2.0 * scale * np.minimum(width, height)
    best = int(np.argmax(scale * np.minimum(narrow / _NARROW, 1.0)))
    half = scale[best] * np.array((width[best], height[best]))
    left, top = (2 * math.ceil(value / 2 - 1e-6) for value in middle - half)
    right, bottom = (2 * math.floor(value / 2 + 1e-6) for value in middle + half)
    return left, top, max(right - left, 0), max(bottom - top, 0)
