"""Where things are in a stored mosaic: rectangles of it, the visible part, and the numbers of random processes."""

from collections.abc import Iterator
from dataclasses import dataclass
from enum import IntEnum

from fullwell.model.sensor import SensorParameters
from fullwell.raw.image import Area


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
    PRNU_ROW = 9
    PRNU_COLUMN = 10
    DSNU_ROW = 11
    DSNU_COLUMN = 12
    DARK_CURRENT = 13
    HOT_PIXEL = 14
    HOT_PIXEL_CURRENT = 15
    HOT_PIXEL_CURRENT_2 = 16
    RTS = 17
    RTS_STATE = 18


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
class Margins:
    """Optical-black pixels around the visible ones, even [pixel]."""

    left: int = 0
    top: int = 0
    right: int = 0
    bottom: int = 0

    @property
    def none(self) -> bool:
        """Whether every stored pixel is visible."""
        return not (self.left or self.top or self.right or self.bottom)

    def shape(self, sensor: SensorParameters) -> tuple[int, int]:
        """Return rows and columns of the stored mosaic."""
        return sensor.height + self.top + self.bottom, sensor.width + self.left + self.right

    def active(self, sensor: SensorParameters) -> Area:
        """Return the visible rectangle."""
        return Area(self.top, self.left, self.top + sensor.height, self.left + sensor.width)

    def masked(self, sensor: SensorParameters) -> tuple[Area, ...]:
        """Return the margins as rectangles that do not overlap."""
        height, width = self.shape(sensor)
        bottom, right = self.top + sensor.height, self.left + sensor.width
        every = (
            Area(0, 0, self.top, width),
            Area(self.top, 0, bottom, self.left),
            Area(self.top, right, bottom, width),
            Area(bottom, 0, height, width),
        )
        return tuple(area for area in every if area.bottom > area.top and area.right > area.left)


def tiles(height: int, width: int, *, pixels: int = 131072) -> Iterator[Tile]:
    """Yield bands of whole rows that cover a mosaic, each of about ``pixels`` pixels."""
    rows = max(1, pixels // width)
    for top in range(0, height, rows):
        yield Tile(top=top, left=0, bottom=min(top + rows, height), right=width)
