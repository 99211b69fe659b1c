"""The camera: the order of the stages is the physics.

Each stage is a pure function of an array and of what is taken; random numbers come from counters, so a pixel's value
depends on the seed, the frame and the pixel alone. A new process is a new function in the tuple, with a stream of its
own, and changes no number that any other process draws.
"""

from collections.abc import Callable, Iterable
from typing import Final

import numpy as np
from numpy.typing import NDArray

from fullwell.kernels.random import Draws, normal
from fullwell.model.sensor import SensorParameters
from fullwell.raw.cfa import cell
from fullwell.simulate import adc, charge, optics, photons, readout, scene
from fullwell.simulate.shot import Camera, Exposure, FloatArray, Shot, Stream, Tile, tiles

Stage = Callable[[FloatArray, Shot], FloatArray]

STAGES: Final[tuple[Stage, ...]] = (
    scene.light,  # where the light comes from
    optics.illumination,  # what the lens lets through, and its flare
    photons.expected_electrons,  # how many electrons to expect
    charge.collected,  # how many came: shot noise, response, dark current, full well
    readout.read_out,  # offsets and noise before the amplifier
    readout.amplified,  # amplification, and noise after it
    adc.converted,  # black level, rounding, rails
)


def build(
    sensor: SensorParameters, *, seed: int, lens: NDArray[np.float32] | None = None, flare: float = 0.0
) -> Camera:
    """Return one individual camera: the seed decides its fixed patterns.

    Parameters
    ----------
    sensor
        Parameters.
    seed
        0 to 2^64 - 1.
    lens
        Relative illumination times response, shape (height, width); None for a lens that shades nothing.
    flare
        Stray light as a fraction of the largest signal [1].

    """
    return Camera(
        sensor=sensor,
        seed=seed,
        lens=optics.even(sensor) if lens is None else lens,
        response=np.maximum(1.0 + _fixed_pattern(sensor, seed, Stream.PRNU, sensor.prnu), np.float32(0.0)),
        dsnu=_fixed_pattern(sensor, seed, Stream.DSNU, sensor.dsnu),
        flare=flare,
    )


def take(camera: Camera, exposure: Exposure, cover: Iterable[Tile] | None = None) -> NDArray[np.uint16]:
    """Take one frame.

    Parameters
    ----------
    camera
        The camera.
    exposure
        How the frame is taken.
    cover
        Tiles that cover the mosaic, in any order; the choice changes no bit of the frame.

    Returns
    -------
    ndarray
        The mosaic, shape (height, width), uint16 [DN].

    """
    sensor = camera.sensor
    mosaic = np.empty((sensor.height, sensor.width), dtype=np.uint16)
    for tile in tiles(sensor.height, sensor.width) if cover is None else cover:
        shot = Shot(camera=camera, exposure=exposure, tile=tile)
        array = np.empty((0, 0))
        for stage in STAGES:
            array = stage(array, shot)
        mosaic[tile.window] = adc.as_codes(array)
    return mosaic


def _fixed_pattern(sensor: SensorParameters, seed: int, stream: Stream, spread: float) -> NDArray[np.float32]:
    """Return a pattern of the given spread and of mean zero over each CFA plane; an empty one where there is none."""
    if spread == 0.0:
        return np.empty((0, 0), dtype=np.float32)
    pattern = np.empty((sensor.height, sensor.width), dtype=np.float32)
    for tile in tiles(sensor.height, sensor.width):
        first = tile.top * sensor.width
        pattern[tile.window] = normal(
            tile.shape, Draws(seed=seed, stream=stream.value, first=first, stride=sensor.width)
        )
    period = cell(sensor.cfa)
    for site in range(period * period):
        plane = pattern[site // period :: period, site % period :: period]
        plane -= plane.mean(dtype=np.float64)
    pattern *= spread
    return pattern
