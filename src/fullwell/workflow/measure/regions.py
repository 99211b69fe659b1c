"""Rectangles of the mosaic that are looked at on their own: a central crop and its sixteen tiles."""

from dataclasses import dataclass
from typing import Final

CROP_WIDTH: Final = 1318
CROP_HEIGHT: Final = 968
TILE: Final = 64
_FULL_WIDTH: Final = 4032
_FULL_HEIGHT: Final = 3024
_ACROSS: Final = 4


@dataclass(frozen=True, slots=True, kw_only=True)
class Region:
    """A rectangle of the visible mosaic, every number even [pixel]."""

    x: int
    y: int
    width: int
    height: int

    def __str__(self) -> str:
        """Return it as rows write it: ``x,y,w,h``."""
        return f"{self.x},{self.y},{self.width},{self.height}"

    def plane(self, cell: int) -> tuple[slice, slice]:
        """Return the rows and columns of a plane that lie in it, the mosaic's period being ``cell`` pixels."""
        return (
            slice(self.y // cell, (self.y + self.height) // cell),
            slice(self.x // cell, (self.x + self.width) // cell),
        )


def central_crop(*, width: int, height: int) -> Region:
    """Return the central megapixel of a frame; the same share of a frame smaller than the published study's.

    Examples
    --------
    >>> str(central_crop(width=4032, height=3024))
    '1356,1028,1318,968'

    """
    scale = _scale(width, height)
    crop_width, crop_height = _even(CROP_WIDTH * scale), _even(CROP_HEIGHT * scale)
    return Region(
        x=_even((width - crop_width) / 2), y=_even((height - crop_height) / 2), width=crop_width, height=crop_height
    )


def central_tiles(*, width: int, height: int) -> tuple[Region, ...]:
    """Return sixteen square tiles spread evenly over the central crop, row by row."""
    crop = central_crop(width=width, height=height)
    edge = _even(TILE * _scale(width, height))
    return tuple(
        Region(
            x=crop.x + _even((2 * column + 1) * crop.width / (2 * _ACROSS) - edge / 2),
            y=crop.y + _even((2 * row + 1) * crop.height / (2 * _ACROSS) - edge / 2),
            width=edge,
            height=edge,
        )
        for row in range(_ACROSS)
        for column in range(_ACROSS)
    )


def _scale(width: int, height: int) -> float:
    return min(1.0, width / _FULL_WIDTH, height / _FULL_HEIGHT)


def _even(length: float) -> int:
    return int(length) // 2 * 2
