"""The camera: the order of the stages is the physics.

Each stage is a pure function of an array and of what is taken; random numbers come from counters, so a pixel's value
depends on the seed, the frame and the pixel alone. A new process is a new function in the tuple, with a stream of its
own, and changes no number that any other process draws.
"""

from collections.abc import Callable, Iterable, Mapping
from typing import Final

import numpy as np
from numpy.typing import NDArray

from fullwell.kernels.random import Draws, normal
from fullwell.model.sensor import SensorParameters
from fullwell.raw.cfa import cell
from fullwell.simulate import adc, charge, optics, photons, readout, scene
from fullwell.simulate.chart import Painting
from fullwell.simulate.config import SimulationConfig
from fullwell.simulate.optics import Lens
from fullwell.simulate.shot import Camera, Exposure, FloatArray, Shot, Stream, Tile, tiles

Stage = Callable[[FloatArray, Shot], FloatArray]

_NO_PATTERN: Final = np.empty((0, 0), dtype=np.float32)
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
    sensor: SensorParameters,
    *,
    seed: int,
    lens: Lens | None = None,
    at_iso: Mapping[float, SensorParameters] | None = None,
    chart: Painting | None = None,
) -> Camera:
    """Return one individual camera: the seed decides its fixed patterns.

    Parameters
    ----------
    sensor
        Parameters at the base ISO.
    seed
        0 to 2^64 - 1.
    lens
        None for a lens that shades nothing.
    at_iso
        Parameters at ISOs where they differ.
    chart
        What frames of a chart show.

    """
    sensors = {sensor.base_iso: sensor, **(at_iso or {})}
    return Camera(
        sensor=sensor,
        sensors=sensors,
        seed=seed,
        lens=optics.even(sensor) if lens is None else lens.map_for(sensor),
        prnu=_pattern(sensor, seed, Stream.PRNU) if sensor.prnu else _NO_PATTERN,
        dsnu=_pattern(sensor, seed, Stream.DSNU) if any(one.dsnu for one in sensors.values()) else _NO_PATTERN,
        flare=0.0 if lens is None else lens.flare,
        chart=chart,
    )


def camera_of(config: SimulationConfig) -> Camera:
    """Return the individual camera that a config and its seed describe."""
    return build(
        config.sensor,
        seed=config.seed,
        lens=config.lens,
        at_iso={float(iso): config.sensor_at(iso) for iso in config.isos},
        chart=config.chart,
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
    sensor = camera.sensor_at(exposure.iso)
    mosaic = np.empty((sensor.height, sensor.width), dtype=np.uint16)
    for tile in tiles(sensor.height, sensor.width) if cover is None else cover:
        shot = Shot(camera=camera, sensor=sensor, exposure=exposure, tile=tile)
        array = np.empty((0, 0))
        for stage in STAGES:
            array = stage(array, shot)
        mosaic[tile.window] = adc.as_codes(array)
    return mosaic


def _pattern(sensor: SensorParameters, seed: int, stream: Stream) -> NDArray[np.float32]:
    """Return a pattern of spread 1 and of mean zero over each CFA plane."""
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
    return pattern
