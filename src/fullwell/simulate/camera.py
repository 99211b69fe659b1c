"""The camera: the order of the stages is the physics.

Each stage is a pure function of an array and of what is taken; random numbers come from counters, so a pixel's value
depends on the seed, the frame and the pixel alone. A new process is a new function in the tuple, with a stream of its
own, and changes no number that any other process draws.
"""

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from typing import Final

import numpy as np
from numpy.typing import NDArray

from fullwell.model.sensor import SensorParameters
from fullwell.simulate import adc, charge, optics, photons, readout, scene
from fullwell.simulate.chart import Painting
from fullwell.simulate.config import SimulationConfig
from fullwell.simulate.geometry import Margins, Tile, tiles
from fullwell.simulate.individual import make
from fullwell.simulate.lens import Lens, even
from fullwell.simulate.pictures import FloatArray
from fullwell.simulate.shot import Camera, Exposure, Shot

Stage = Callable[[FloatArray, Shot], FloatArray]

STAGES: Final[tuple[Stage, ...]] = (
    scene.light,  # where the light comes from
    optics.focused,  # how sharp the lens draws it
    optics.filtered,  # what passes each colour filter
    optics.illumination,  # what the lens lets through, and its flare
    photons.expected_electrons,  # how many electrons to expect
    charge.collected,  # how many came: shot noise, response, dark current
    charge.attracted,  # where full pixels pushed them
    charge.held,  # full well, and what spilt
    readout.sensed,  # the response curve
    readout.read_out,  # offsets and noise before the amplifier
    readout.amplified,  # amplification, and noise after it
    adc.converted,  # black level, rounding, rails
)


@dataclass(frozen=True, slots=True, kw_only=True)
class Surroundings:
    """What is around a sensor.

    Parameters
    ----------
    lens
        None for a lens that shades nothing.
    margins
        Optical-black pixels.
    chart
        What frames of a chart show.
    pictures
        Light of pictures by their path.
    colour_matrix
        Red, green and blue of the camera from those of the light, shape (3, 3).
    companding_bits
        Of stored codes where they are companded [bit].

    """

    lens: Lens | None = None
    margins: Margins = field(default_factory=Margins)
    chart: Painting | None = None
    pictures: Mapping[str, FloatArray] = field(default_factory=dict[str, FloatArray])
    colour_matrix: FloatArray = field(default_factory=lambda: np.eye(3))
    companding_bits: int | None = None


def build(
    sensor: SensorParameters,
    *,
    seed: int,
    at_iso: Mapping[float, SensorParameters] | None = None,
    around: Surroundings | None = None,
) -> Camera:
    """Return one individual camera: the seed decides its fixed patterns.

    Parameters
    ----------
    sensor
        Parameters at the base ISO.
    seed
        0 to 2^64 - 1.
    at_iso
        Parameters at ISOs where they differ.
    around
        None for a lens that shades nothing, and no more.

    """
    around = around or Surroundings()
    sensors = {sensor.base_iso: sensor, **(at_iso or {})}
    unequal = any(one.dsnu or one.dsnu_row or one.dsnu_column for one in sensors.values())
    return Camera(
        sensor=sensor,
        sensors=sensors,
        seed=seed,
        individual=make(sensor, seed=seed, margins=around.margins, unequal=unequal),
        lens=_behind_margins(even(sensor) if around.lens is None else around.lens.map_for(sensor), around.margins),
        flare=0.0 if around.lens is None else around.lens.flare,
        defocus=0.0 if around.lens is None else around.lens.defocus,
        margins=around.margins,
        colour_matrix=around.colour_matrix,
        chart=around.chart,
        pictures=around.pictures,
        companding=None if around.companding_bits is None else adc.companding_table(sensor, around.companding_bits),
    )


def camera_of(config: SimulationConfig) -> Camera:
    """Return the individual camera that a config and its seed describe."""
    return build(
        config.sensor,
        seed=config.seed,
        at_iso={float(iso): config.sensor_at(iso) for iso in config.isos},
        around=Surroundings(
            lens=config.lens,
            margins=config.margins,
            chart=config.chart,
            pictures=config.pictures,
            colour_matrix=config.colour_matrix,
            companding_bits=config.output.companding_bits,
        ),
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
        Tiles that cover the stored mosaic, in any order; the choice changes no bit of the frame. Charge that pixels
        share with their neighbours makes the whole mosaic one tile.

    Returns
    -------
    ndarray
        The stored mosaic, margins included, uint16 [DN].

    """
    sensor, shape = camera.sensor_at(exposure.iso), camera.shape
    mosaic = np.empty(shape, dtype=np.uint16)
    if sensor.brighter_fatter or sensor.blooming:
        cover = [Tile(top=0, left=0, bottom=shape[0], right=shape[1])]
    for tile in tiles(*shape) if cover is None else cover:
        shot = Shot(camera=camera, sensor=sensor, exposure=exposure, tile=tile)
        array = np.empty((0, 0))
        for stage in STAGES:
            array = stage(array, shot)
        mosaic[tile.window] = adc.as_codes(array)
    return mosaic


def _behind_margins(lens: NDArray[np.float32], margins: Margins) -> NDArray[np.float32]:
    """Return a map of the stored mosaic: no light reaches the margins."""
    return lens if margins.none else np.pad(lens, ((margins.top, margins.bottom), (margins.left, margins.right)))
