"""The lens: how sharp the picture is, and how much of the light reaches each pixel, with stray light on top."""

import numpy as np

from fullwell.raw.cfa import MONO, cell
from fullwell.simulate.scene import reach
from fullwell.simulate.shot import FloatArray, Shot


def focused(light: FloatArray, shot: Shot) -> FloatArray:
    """Return the picture that the lens throws: the light, blurred by a normal law where it is out of focus [1].

    Parameters
    ----------
    light
        Light of the scene, shape (colours, rows, columns), with `scene.reach` more on each side of the tile [1].
    shot
        What is taken.

    """
    defocus = shot.camera.defocus
    if not defocus or light.shape[1:] == (1, 1):
        return light
    from scipy.ndimage import gaussian_filter1d  # noqa: PLC0415 - loads when used

    edge = reach(defocus)
    for axis in (1, 2):
        light = gaussian_filter1d(light, defocus, axis=axis, mode="nearest", radius=edge)
    return light[:, edge:-edge, edge:-edge]


def filtered(light: FloatArray, shot: Shot) -> FloatArray:
    """Return what passes each pixel's colour filter: a mixture of red, green and blue [1].

    Parameters
    ----------
    light
        Shape (colours, rows, columns) [1].
    shot
        What is taken.

    """
    cfa, tile = shot.sensor.cfa, shot.tile
    if light.shape[0] == 1 or cfa == MONO:
        return light[0]
    mixed = np.tensordot(shot.camera.colour_matrix, light, axes=1)
    out = np.empty(light.shape[1:])
    period = cell(cfa)
    for site, letter in enumerate(cfa):
        window = (
            slice((site // period - tile.top) % period, None, period),
            slice((site % period - tile.left) % period, None, period),
        )
        out[window] = mixed["RGB".index(letter)][window]
    return np.maximum(out, 0.0, out=out)


def illumination(light: FloatArray, shot: Shot) -> FloatArray:
    """Return the light at each pixel of the tile, its site's response applied [1].

    Parameters
    ----------
    light
        What passed the filters [1].
    shot
        What is taken.

    """
    camera = shot.camera
    lens = camera.lens[shot.tile.window]
    seen = np.multiply(lens, light, dtype=np.float64)
    if not camera.flare:
        return seen
    shot.add_by_site(seen, tuple(camera.flare * response for response in shot.sensor.response))
    return seen if camera.margins.none else np.where(lens > 0.0, seen, 0.0)
