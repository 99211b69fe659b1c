"""The markers of points, as SVG paths about their middle and as pixels."""

import math
from functools import lru_cache
from typing import Final

import numpy as np

from fullwell.report.drawing.geometry import Array
from fullwell.report.drawing.pen import lines_path, number, polygon
from fullwell.report.drawing.style import Fill, Marker

LINES: Final = frozenset({"x", "+"})
"""Markers that have no area."""

_DIAMOND: Final = math.sqrt(0.5)
_THIRD: Final = 1.0 / 6.0
_CIRCLE: Final = 48

_CORNERS: Final = (
    ("s", ((-0.5, -0.5), (0.5, -0.5), (0.5, 0.5), (-0.5, 0.5))),
    ("D", ((0.0, -_DIAMOND), (_DIAMOND, 0.0), (0.0, _DIAMOND), (-_DIAMOND, 0.0))),
    ("^", ((0.0, -0.5), (0.5, 0.5), (-0.5, 0.5))),
    (
        "P",
        (
            (-_THIRD, -0.5),
            (_THIRD, -0.5),
            (_THIRD, -_THIRD),
            (0.5, -_THIRD),
            (0.5, _THIRD),
            (_THIRD, _THIRD),
            (_THIRD, 0.5),
            (-_THIRD, 0.5),
            (-_THIRD, _THIRD),
            (-0.5, _THIRD),
            (-0.5, -_THIRD),
            (-_THIRD, -_THIRD),
        ),
    ),
)


@lru_cache(maxsize=256)
def outline(marker: Marker, size: float) -> str:
    """Return the outline of a marker of a size [point]."""
    if marker == "x":
        return lines_path(((-size / 2, -size / 2, size / 2, size / 2), (-size / 2, size / 2, size / 2, -size / 2)))
    if marker == "+":
        return lines_path(((-size / 2, 0.0, size / 2, 0.0), (0.0, -size / 2, 0.0, size / 2)))
    if marker in ("o", "."):
        radius = number(size / 2 if marker == "o" else size / 4)
        return f"M-{radius} 0A{radius} {radius} 0 1 1 {radius} 0A{radius} {radius} 0 1 1 -{radius} 0Z"
    return polygon(*(size * corners(marker).T))


@lru_cache(maxsize=64)
def half(marker: Marker, size: float, side: Fill) -> str:
    """Return the outline of the left or the lower half of a marker of a size [point]."""
    points = corners(marker)
    direction = np.array([-1.0, 0.0] if side == "left" else [0.0, 1.0])
    kept: list[Array] = []
    for here, after in zip(points, np.roll(points, -1, axis=0), strict=True):
        a, b = float(here @ direction), float(after @ direction)
        if a >= 0.0:
            kept.append(here)
        if a * b < 0.0:
            kept.append(here + (after - here) * a / (a - b))
    return polygon(*(size * np.array(kept).T))


def corners(marker: Marker) -> Array:
    """Return the corners of a marker of size 1 with an area, y downwards, shape (corners, 2)."""
    if marker == "*":
        turn = np.arange(10) * math.pi / 5.0
        radius = np.where(np.arange(10) % 2 == 0, 0.5, 0.1909830)
        return np.column_stack([radius * np.sin(turn), -radius * np.cos(turn)])
    if marker in ("o", "."):
        turn = np.arange(_CIRCLE) * 2.0 * math.pi / _CIRCLE
        return (0.5 if marker == "o" else 0.25) * np.column_stack([np.cos(turn), np.sin(turn)])
    return np.array(dict(_CORNERS)[marker])
