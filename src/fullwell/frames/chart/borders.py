"""The borders of steps that touch each other: where they are in the light settles what middles of areas cannot.

Steps in a line say nothing about the strip's width; and where the darkest steps of a film cannot be told apart, their
place follows from the others, a long way off.
"""

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from fullwell.frames.chart.definition import ChartDefinition
from fullwell.frames.chart.homography import homography, mapped
from fullwell.frames.chart.preview import Preview

_REACH: Final = 0.3
"""Share of a patch's edge that is searched on either side of where its border is supposed to be."""
_LAST_REACH: Final = 1.5
"""The same for the far end of the strip, to which no step may lead that can be seen."""
_POINTS: Final = 61
"""Samples of a profile across a border."""
_LINES: Final = (-0.25, 0.0, 0.25)
"""Where along the border profiles are taken, as shares of the patch."""
_CLEAR: Final = 6.0
"""Steepest place of a profile over its median slope, from which on it is a border."""
_ROUNDS: Final = 3


@dataclass(frozen=True, slots=True, kw_only=True)
class _Borders:
    """Borders of patches: which patch, the direction from its middle, and how far to search [share of its edge]."""

    patch: NDArray[np.intp]
    outward: NDArray[np.float64]
    reach: NDArray[np.float64]


def laid_on_borders(
    picture: Preview,
    definition: ChartDefinition,
    matrix: NDArray[np.float64],
    *,
    known: tuple[NDArray[np.float64], NDArray[np.float64]],
) -> NDArray[np.float64]:
    """Return the map of a chart whose patches touch, their borders laid upon those in the light.

    Parameters
    ----------
    picture
        The preview.
    definition
        The chart.
    matrix
        The map so far, shape (3, 3).
    known
        Middles of patches on the chart and in the preview, each of shape (n, 2).

    """
    borders = _borders(definition)
    end = 1.5 * definition.centres[-1] - 0.5 * definition.centres[-2] if definition.in_line else np.full(2, np.inf)
    for _ in range(_ROUNDS):
        places, points = _found(picture, definition, matrix, borders)
        if len(places) < 6:
            return matrix
        source, target = np.vstack((known[0], places)), np.vstack((known[1], points))
        far = np.linalg.norm(source - end, axis=1) < 1e-9
        fitted = homography(source, target)
        for _ in range(2):
            miss = np.linalg.norm(mapped(fitted, source) - target, axis=1)
            if np.isnan(miss).any():
                return matrix
            kept = (miss <= max(3.0 * float(np.median(miss)), 0.5)) | far
            fitted = homography(source[kept], target[kept])
        matrix = fitted
    return matrix


def _borders(definition: ChartDefinition) -> _Borders:
    count = len(definition.patches)
    sides = np.array(((1.0, 0.0), (0.0, 1.0), (-1.0, 0.0), (0.0, -1.0)))
    reach = np.full((len(sides), count), _REACH)
    if definition.in_line:
        along = definition.centres[-1] - definition.centres[0]
        reach[np.argmax(sides @ along), -1] = _LAST_REACH
    return _Borders(
        patch=np.tile(np.arange(count), len(sides)),
        outward=np.repeat(sides, count, axis=0),
        reach=reach.ravel(),
    )


def _found(
    picture: Preview, definition: ChartDefinition, matrix: NDArray[np.float64], borders: _Borders
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the borders that are seen: on the chart and in the preview, each of shape (n, 2)."""
    centres, sizes = definition.centres[borders.patch], definition.sizes[borders.patch]
    along = borders.outward[:, ::-1] * sizes
    border = centres + 0.5 * borders.outward * sizes
    steps = np.linspace(-1.0, 1.0, _POINTS) * borders.reach[:, None]
    base = border[:, None, :] + steps[..., None] * (borders.outward * sizes)[:, None, :]
    lines = np.stack([base + share * along[:, None, :] for share in _LINES])
    x, y = np.moveaxis(mapped(matrix, lines), -1, 0)
    light = ndimage.map_coordinates(picture.light, (np.nan_to_num(y), np.nan_to_num(x)), order=1, mode="nearest")
    profile = light.mean(axis=0)
    slope = np.abs(np.diff(ndimage.gaussian_filter1d(profile, 1.5, axis=1), axis=1))
    peak = slope.argmax(axis=1)
    index = np.arange(len(peak))
    clear = slope[index, peak] > _CLEAR * np.median(slope, axis=1)
    clear &= np.abs(profile[:, -1] - profile[:, 0]) > picture.floor
    clear &= (peak > 1) & (peak < slope.shape[1] - 2)
    points = mapped(matrix, 0.5 * (base[index, peak] + base[index, peak + 1]))
    return border[clear], points[clear]
