"""Lenses: relative illumination times response, pixel by pixel.

Natural vignetting is cos^4 of the angle off the axis, raised to an exponent per channel where colours fall off
differently. A map takes its place where one was measured: an array, a map of `fullwell shading fit`, or the table of a
libcamera tuning file.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from fullwell.model.sensor import SensorParameters
from fullwell.raw.cfa import cell
from fullwell.simulate.lens_maps import LensMap, read_maps
from fullwell.simulate.sensors import by_channel
from fullwell.simulate.tables import CameraTable, LensTable

Map = NDArray[np.float32]


@dataclass(frozen=True, slots=True, kw_only=True)
class Lens:
    """A lens.

    Parameters
    ----------
    shading
        ``none``, ``cos4``, or the path of a map.
    exponents
        Power of the fall-off per CFA site, row-major [1].
    focal_length_mm
        Distance of the exit pupil [mm].
    flare
        Stray light as a fraction of the largest signal [1].
    defocus
        Standard deviation of the blur [pixel].
    colour_temperature
        Of the light that a libcamera table is taken for [K].

    """

    shading: str
    exponents: tuple[float, ...]
    focal_length_mm: float
    flare: float
    defocus: float = 0.0
    colour_temperature: float = 5000.0

    def map_for(self, sensor: SensorParameters) -> Map:
        """Return relative illumination times response of each visible pixel, shape (height, width) [1].

        Raises
        ------
        UsageError
            Where a map cannot be read, or does not suit the sensor.

        """
        if self.shading == "none":
            return even(sensor)
        if self.shading == "cos4":
            return cos4(sensor, focal_length_mm=self.focal_length_mm, exponents=self.exponents)
        return _over(sensor, read_maps(Path(self.shading), sensor, colour_temperature=self.colour_temperature))


def lens_of(table: LensTable, camera: CameraTable, *, folder: Path) -> Lens:
    """Return the lens that a config describes; the path of a map is relative to ``folder``."""
    return Lens(
        shading=table.shading if table.shading in {"none", "cos4"} else str(folder / table.shading),
        exponents=by_channel(camera, table.shading_exponent.model_dump()),
        focal_length_mm=table.focal_length_mm,
        flare=table.flare,
        defocus=table.defocus,
        colour_temperature=table.colour_temperature,
    )


def cos4(sensor: SensorParameters, *, focal_length_mm: float, exponents: tuple[float, ...]) -> NDArray[np.float32]:
    """Return the relative illumination (1 + r^2/f^2)^-2 times the response of each pixel.

    Parameters
    ----------
    sensor
        Size, pitch, CFA and response.
    focal_length_mm
        Distance of the exit pupil [mm].
    exponents
        Per CFA site, row-major: the power the fall-off is raised to [1].

    Returns
    -------
    ndarray
        Shape (height, width), float32, the response at the optical centre [1].

    """
    reach = focal_length_mm * 1000.0 / sensor.pixel_pitch_um
    y2 = ((np.arange(sensor.height) - (sensor.height - 1) / 2.0) / reach) ** 2
    x2 = ((np.arange(sensor.width) - (sensor.width - 1) / 2.0) / reach) ** 2
    out = np.empty((sensor.height, sensor.width), dtype=np.float32)
    period = cell(sensor.cfa)
    for site, (response, exponent) in enumerate(zip(sensor.response, exponents, strict=True)):
        rows, columns = slice(site // period, None, period), slice(site % period, None, period)
        out[rows, columns] = response * (1.0 + y2[rows, None] + x2[None, columns]) ** (-2.0 * exponent)
    return out


def even(sensor: SensorParameters) -> NDArray[np.float32]:
    """Return the response of each pixel behind a lens that shades nothing, shape (height, width), float32 [1]."""
    return cos4(sensor, focal_length_mm=1.0, exponents=(0.0,) * len(sensor.response))


def _over(sensor: SensorParameters, maps: Sequence[LensMap]) -> Map:
    """Return maps, one a site, times the response of each pixel."""
    out = np.empty((sensor.height, sensor.width), dtype=np.float32)
    period = cell(sensor.cfa)
    for site, (response, lens) in enumerate(zip(sensor.response, maps, strict=True)):
        rows = (np.arange(site // period, sensor.height, period) + 0.5) / sensor.height
        columns = (np.arange(site % period, sensor.width, period) + 0.5) / sensor.width
        out[site // period :: period, site % period :: period] = response * lens.at(rows, columns)
    return out
