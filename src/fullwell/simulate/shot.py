"""What one exposure of one camera is: everything a stage may know beside the array it works on."""

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from fullwell.kernels.random import Draws
from fullwell.model.sensor import SensorParameters
from fullwell.raw.cfa import cell
from fullwell.simulate.chart import Painting
from fullwell.simulate.geometry import Margins, Stream, Tile
from fullwell.simulate.individual import Individual

FloatArray = NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True)
class Exposure:
    """How one frame is taken.

    Parameters
    ----------
    iso
        ISO.
    exposure_s
        Exposure [s].
    electrons
        Mean photo-electrons where scene, lens and response are 1 [e-]; 0 in the dark.
    subject
        What the camera looks at: a name of `scene.SUBJECTS`, ``chart``, or the path of a picture.
    temperature_c
        Temperature of the sensor, None for that of its reference [deg C].
    frame
        Number of the frame in the study: no two frames share their temporal noise.

    """

    iso: float
    exposure_s: float
    electrons: float = 0.0
    subject: str = "flat"
    temperature_c: float | None = None
    frame: int = 0


@dataclass(frozen=True, slots=True, kw_only=True)
class Camera:
    """A sensor and a lens, with everything about them that does not change from frame to frame.

    Parameters
    ----------
    sensor
        Parameters at the base ISO.
    sensors
        Parameters at ISOs where they differ.
    seed
        Key of every random number.
    individual
        Fixed patterns of the sensor.
    lens
        Relative illumination times the response of each pixel's site, shape of the stored mosaic, 0 in the margins,
        float32 [1].
    flare
        Stray light everywhere, as a fraction of the largest signal [1].
    defocus
        Standard deviation of the blur [pixel].
    margins
        Optical-black pixels.
    colour_matrix
        Red, green and blue of the camera from those of the light, shape (3, 3).
    chart
        What frames of a chart show; None without one.
    pictures
        Light of pictures by their path, shape (3, rows, columns), stretched over the visible mosaic.
    companding
        Linear code of each stored code, None where codes are linear [DN].

    """

    sensor: SensorParameters
    sensors: Mapping[float, SensorParameters]
    seed: int
    individual: Individual
    lens: NDArray[np.float32]
    flare: float = 0.0
    defocus: float = 0.0
    margins: Margins = field(default_factory=Margins)
    colour_matrix: FloatArray = field(default_factory=lambda: np.eye(3))
    chart: Painting | None = None
    pictures: Mapping[str, FloatArray] = field(default_factory=dict[str, FloatArray])
    companding: NDArray[np.uint16] | None = None

    @property
    def shape(self) -> tuple[int, int]:
        """Rows and columns of the stored mosaic."""
        return self.margins.shape(self.sensor)

    def sensor_at(self, iso: float) -> SensorParameters:
        """Return the parameters at an ISO."""
        return self.sensors.get(iso, self.sensor)


@dataclass(frozen=True, slots=True, kw_only=True)
class Shot:
    """One tile of one exposure of one camera."""

    camera: Camera
    sensor: SensorParameters
    exposure: Exposure
    tile: Tile

    def draws(self, stream: Stream) -> Draws:
        """Return one number per pixel of the tile."""
        width = self.camera.shape[1]
        first = self.tile.top * width + self.tile.left
        return Draws(seed=self.camera.seed, stream=stream.value, frame=self.exposure.frame, first=first, stride=width)

    def line_draws(self, stream: Stream, first: int) -> Draws:
        """Return one number per line, counted from ``first``."""
        return Draws(seed=self.camera.seed, stream=stream.value, frame=self.exposure.frame, first=first)

    def places(self, *, beyond: int = 0) -> tuple[FloatArray, FloatArray]:
        """Return the middles of rows and columns in pixels of the visible mosaic; what lies outside is its edge.

        Parameters
        ----------
        beyond
            Rows and columns around the tile that are wanted too.

        """
        margins, tile = self.camera.margins, self.tile
        rows = np.arange(tile.top - beyond, tile.bottom + beyond, dtype=np.float64) + (0.5 - margins.top)
        columns = np.arange(tile.left - beyond, tile.right + beyond, dtype=np.float64) + (0.5 - margins.left)
        height, width = self.sensor.height, self.sensor.width
        return np.clip(rows, 0.5, height - 0.5), np.clip(columns, 0.5, width - 0.5)

    def add_by_site(self, array: FloatArray, values: tuple[float, ...]) -> FloatArray:
        """Add one value per CFA site to an array of the tile, in place."""
        if len(set(values)) == 1:
            array += values[0]
            return array
        period = cell(self.sensor.cfa)
        pattern = np.reshape(np.asarray(values, dtype=np.float64), (period, period))
        line = np.arange(self.tile.left, self.tile.right) % period
        for row in range(min(period, array.shape[0])):
            array[row::period] += pattern[(self.tile.top + row) % period, line]
        return array
