"""Maps between the plane of a chart and the plane of its picture."""

from typing import Final

import numpy as np
from numpy.typing import NDArray

from fullwell.frames.chart.definition import ChartDefinition

UNIT_SQUARE: Final = np.array([(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)])
"""The corners of a chart, clockwise from its top left."""
_FLAT: Final = 1e-4
"""Turn at a corner over the square of the longest edge, below which three corners stand in a line."""


def affine(source: NDArray[np.float64], target: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the affine map of least squares, shape (3, 3), from points of shape (n, 2), n at least 3."""
    design = np.column_stack((source, np.ones(len(source))))
    solution = np.linalg.lstsq(design, target, rcond=None)[0]
    return np.vstack((solution.T, (0.0, 0.0, 1.0)))


def homography(source: NDArray[np.float64], target: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the projective map of least squares, shape (3, 3), from points of shape (n, 2), n at least 4.

    By the direct linear transform on points that are centred and scaled.
    """
    to_source, to_target = _normalizing(source), _normalizing(target)
    x, y = mapped(to_source, source).T
    u, v = mapped(to_target, target).T
    one, zero = np.ones_like(x), np.zeros_like(x)
    equations = np.vstack(
        (
            np.column_stack((x, y, one, zero, zero, zero, -u * x, -u * y, -u)),
            np.column_stack((zero, zero, zero, x, y, one, -v * x, -v * y, -v)),
        )
    )
    _, vectors = np.linalg.eigh(equations.T @ equations)
    found = np.asarray(np.linalg.solve(to_target, vectors[:, 0].reshape(3, 3) @ to_source), dtype=np.float64)
    return found / (found[2, 2] if abs(found[2, 2]) > 1e-12 else 1.0)


def mapped(matrix: NDArray[np.float64], points: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return points, shape (..., 2), under a map; NaN for those at or behind the horizon."""
    image = points @ matrix[:, :2].T + matrix[:, 2]
    depth = np.where(image[..., 2:] > 1e-9, image[..., 2:], np.nan)
    return image[..., :2] / depth


def convex(corners: NDArray[np.float64], *, perspective: float = np.inf) -> bool:
    """Whether four points, shape (4, 2), are the corners of a convex quadrilateral in their order.

    Parameters
    ----------
    corners
        The points; NaN where they lie behind the horizon.
    perspective
        Ratio that opposite edges stay below.

    """
    if not np.isfinite(corners).all():
        return False
    edges = np.roll(corners, -1, axis=0) - corners
    lengths = np.linalg.norm(edges, axis=1)
    turns = edges[:, 0] * np.roll(edges[:, 1], -1) - edges[:, 1] * np.roll(edges[:, 0], -1)
    turning = np.abs(turns).min() > _FLAT * lengths.max() ** 2 and abs(np.sign(turns).sum()) == len(turns)
    ratio = lengths / np.roll(lengths, 2)
    return bool(turning) and float(ratio.max()) < perspective


def quadrilaterals(matrix: NDArray[np.float64], definition: ChartDefinition, *, share: float) -> NDArray[np.float64]:
    """Return the corners of the patches in the picture, shape (patches, 4, 2), shrunk to a share of their edges."""
    offsets = (UNIT_SQUARE - 0.5) * share
    return mapped(matrix, definition.centres[:, None, :] + offsets * definition.sizes[:, None, :])


def _normalizing(points: NDArray[np.float64]) -> NDArray[np.float64]:
    middle = points.mean(axis=0)
    spread = float(np.sqrt(np.mean(np.sum((points - middle) ** 2, axis=1)))) or 1.0
    return np.array([(1 / spread, 0.0, -middle[0] / spread), (0.0, 1 / spread, -middle[1] / spread), (0.0, 0.0, 1.0)])
