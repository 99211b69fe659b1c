"""The scene: how much light comes from where, before any lens, relative to the brightest thing in it.

A subject is a function of the place in the picture, x to the right and y down, both from 0 to 1, and of a channel; it
knows nothing of pixels, so that a quarter-size camera sees the same picture.
"""

import math
from collections.abc import Callable
from typing import Final

import numpy as np

from fullwell.raw.cfa import MONO
from fullwell.simulate.pictures import stretched
from fullwell.simulate.shot import FloatArray, Shot

Subject = Callable[[FloatArray, FloatArray, int], FloatArray]

FLAT: Final = "flat"
"""The subject of an even field."""
CHART: Final = "chart"
"""The subject of frames of a chart."""
_PATCHES: Final = (
    np.array(
        [
            [(17, 8, 5), (54, 30, 22), (12, 19, 34), (10, 15, 5), (23, 21, 43), (13, 51, 41)],
            [(68, 20, 3), (6, 10, 38), (53, 9, 12), (11, 4, 15), (33, 50, 5), (74, 36, 3)],
            [(3, 5, 27), (6, 30, 7), (43, 3, 4), (83, 57, 1), (49, 9, 30), (1, 23, 37)],
            [(90, 90, 90), (59, 59, 59), (36, 36, 36), (19, 19, 19), (9, 9, 9), (3, 3, 3)],
        ]
    )
    / 100.0
)


def flat(x: FloatArray, y: FloatArray, colour: int) -> FloatArray:
    """Return an evenly lit white field."""
    return np.ones(np.broadcast_shapes(x.shape, y.shape)) + 0.0 * colour


def gradient(x: FloatArray, y: FloatArray, colour: int) -> FloatArray:
    """Return a grey wedge over three decades from left to right."""
    return 10.0 ** (3.0 * (x - 1.0)) + 0.0 * (y + colour)


def patches(x: FloatArray, y: FloatArray, colour: int) -> FloatArray:
    """Return a chart of six by four painted squares on black."""
    across, down = 6.0 * x, 4.0 * y
    painted = _PATCHES[np.minimum(down, 3.0).astype(np.intp), np.minimum(across, 5.0).astype(np.intp), colour]
    framed = (np.abs(across % 1.0 - 0.5) < 0.42) & (np.abs(down % 1.0 - 0.5) < 0.42)
    return np.where(framed, painted, 0.01)


def star(x: FloatArray, y: FloatArray, colour: int) -> FloatArray:
    """Return a star of 36 black and white spokes."""
    angle = np.arctan2(3.0 * (y - 0.5), 4.0 * (x - 0.5))
    return np.where(np.sin(36.0 * angle) > 0.0, 0.9, 0.05) + 0.0 * colour


def sunset(x: FloatArray, y: FloatArray, colour: int) -> FloatArray:
    """Return a warm sky over a dark hill, with the sun beyond white."""
    sky = (0.9, 0.6, 0.3)[colour] * (0.25 + 0.6 * y)
    sun = 1.5 * np.exp(-((4.0 * (x - 0.62)) ** 2 + (3.0 * (y - 0.55)) ** 2) / 0.012)
    hill = y > 0.72 + 0.06 * np.sin(7.0 * x) + 0.02 * np.sin(23.0 * x)
    return np.where(hill, 0.02, sky + sun)


def night(x: FloatArray, y: FloatArray, colour: int) -> FloatArray:
    """Return lamps in the dark."""
    near_x, near_y = (9.0 * x) % 1.0 - 0.5, (7.0 * y) % 1.0 - 0.5
    lamp = np.exp(-(near_x**2 + near_y**2) / 0.003)
    return (0.002 + lamp) * (1.0, 0.8, 0.5)[colour]


def window(x: FloatArray, y: FloatArray, colour: int) -> FloatArray:
    """Return a bright window in a dim room."""
    pane = (np.abs(x - 0.65) < 0.18) & (np.abs(y - 0.42) < 0.26) & (np.abs(x - 0.65) > 0.008)
    return np.where(pane, (0.85, 0.95, 1.0)[colour], (0.05, 0.04, 0.03)[colour] * (0.4 + x))


SUBJECTS: Final[dict[str, Subject]] = {
    subject.__name__: subject for subject in (flat, gradient, patches, star, sunset, night, window)
}


def light(_nothing: FloatArray, shot: Shot) -> FloatArray:
    """Return the light of the scene, relative to a response of 1, red, green and blue [1].

    Returns
    -------
    ndarray
        Shape (3, rows, columns) with what a lens out of focus brings from around the tile; for a sensor without
        colours shape (1, rows, columns), and (1, 1, 1) for an even field.

    """
    if shot.exposure.subject == FLAT:
        return np.ones((1, 1, 1))
    rows, columns = shot.places(beyond=reach(shot.camera.defocus))
    colours = (1,) if shot.sensor.cfa == MONO else (0, 1, 2)
    return np.stack([_seen(shot, rows, columns, colour) for colour in colours])


def reach(defocus: float) -> int:
    """Return how far a blur brings light from [pixel]; four standard deviations."""
    return math.ceil(4.0 * defocus)


def _seen(shot: Shot, rows: FloatArray, columns: FloatArray, colour: int) -> FloatArray:
    """Return the light of one colour at the outer product of rows and columns [1]."""
    camera, subject = shot.camera, shot.exposure.subject
    if subject == CHART and camera.chart is not None:
        return camera.chart.seen(rows, columns, colour)
    x, y = columns[None, :] / shot.sensor.width, rows[:, None] / shot.sensor.height
    if subject in camera.pictures:
        return stretched(camera.pictures[subject][colour], y[:, 0], x[0])
    return SUBJECTS[subject](x, y, colour)
