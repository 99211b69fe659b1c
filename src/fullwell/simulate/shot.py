"""What one exposure of one camera is: everything a stage may know beside the array it works on."""

from collections.abc import Iterator
from dataclasses import dataclass
from enum import IntEnum

import numpy as np
from numpy.typing import NDArray

from fullwell.kernels.random import Draws
from fullwell.model.sensor import SensorParameters
from fullwell.raw.cfa import cell
from fullwell.simulate.chart import Painting

FloatArray = NDArray[np.float64]
Pattern = NDArray[np.float32]


class Stream(IntEnum):
    """Random processes of a sensor; the numbers are part of what a seed means, so they are never reused."""

    PRNU = 1
    DSNU = 2
    CHARGE = 3
    READ_NOISE = 4
    READ_NOISE_ROW = 5
    READ_NOISE_COLUMN = 6
    READ_NOISE_FRAME = 7
    READ_NOISE_POST = 8


@dataclass(frozen=True, slots=True, kw_only=True)
class Tile:
    """A rectangle of the mosaic: first row and column, and one past the last."""

    top: int
    left: int
    bottom: int
    right: int

    @property
    def shape(self) -> tuple[int, int]:
        """Rows and columns."""
        return self.bottom - self.top, self.right - self.left

    @property
    def window(self) -> tuple[slice, slice]:
        """The rectangle as an index into an array of the whole mosaic."""
        return slice(self.top, self.bottom), slice(self.left, self.right)


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
        What the camera looks at: a name of `scene.SUBJECTS`, or ``chart``.
    frame
        Number of the frame in the study: no two frames share their temporal noise.

    """

    iso: float
    exposure_s: float
    electrons: float = 0.0
    subject: str = "flat"
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
    lens
        Relative illumination times the response of each pixel's site, shape (height, width), float32 [1].
    prnu, dsnu
        Patterns of spread 1 and of mean zero over each CFA plane, shape (height, width), float32; empty where the
        sensor has none.
    flare
        Stray light everywhere, as a fraction of the largest signal [1].
    chart
        What frames of a chart show; None without one.

    """

    sensor: SensorParameters
    sensors: dict[float, SensorParameters]
    seed: int
    lens: Pattern
    prnu: Pattern
    dsnu: Pattern
    flare: float = 0.0
    chart: Painting | None = None

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
        width = self.sensor.width
        first = self.tile.top * width + self.tile.left
        return Draws(seed=self.camera.seed, stream=stream.value, frame=self.exposure.frame, first=first, stride=width)

    def line_draws(self, stream: Stream, first: int) -> Draws:
        """Return one number per line, counted from ``first``."""
        return Draws(seed=self.camera.seed, stream=stream.value, frame=self.exposure.frame, first=first)

    def by_site(self, values: tuple[float, ...]) -> FloatArray:
        """Return one value per CFA site as an array that broadcasts over rows of the tile.

        Returns
        -------
        ndarray
            Shape of the tile, or (1, 1) where all sites agree.

        """
        return by_site(values, self.sensor.cfa, self.tile)


def by_site(values: tuple[float, ...], cfa: str, tile: Tile) -> FloatArray:
    """Return the value of each pixel's CFA site, shape of the tile; (1, 1) where all sites agree."""
    if len(set(values)) == 1:
        return np.full((1, 1), values[0])
    period = cell(cfa)
    pattern = np.reshape(np.asarray(values, dtype=np.float64), (period, period))
    rows = np.arange(tile.top, tile.bottom) % period
    columns = np.arange(tile.left, tile.right) % period
    return pattern[np.ix_(rows, columns)]


def tiles(height: int, width: int, *, pixels: int = 32768) -> Iterator[Tile]:
    """Yield bands of whole rows that cover a mosaic, each of about ``pixels`` pixels."""
    rows = max(1, pixels // width)
    for top in range(0, height, rows):
        yield Tile(top=top, left=0, bottom=min(top + rows, height), right=width)
