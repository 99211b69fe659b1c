"""Where the Pixel study looks: its crop and its sixteen tiles, coordinates swapped as published (RESULTS 4)."""

import math
from dataclasses import dataclass
from fractions import Fraction
from typing import Final

STUDY_SIZE: Final = (3024, 4032)
"""Height and width of the study's frames [pixel]."""

_CROP: Final = (917, 1505, 1317, 967)
_TILE_STARTS: Final = ((1, 193, 387, 581), (1, 263, 527, 791))
_TILE_EDGE: Final = 63


@dataclass(frozen=True, slots=True, kw_only=True)
class Box:
    """A rectangle of pixels: first row and column, counted from 0, and its size."""

    top: int
    left: int
    height: int
    width: int


@dataclass(frozen=True, slots=True, kw_only=True)
class StudyRegions:
    """Where the study looks.

    Parameters
    ----------
    crop
        ``imcrop [917 1505 1317 967]``, in the mosaic.
    tiles
        Sixteen, in the study's order, in the mosaic; their coordinates are swapped as in its code.
    scaled
        Whether the frame is too small for the published numbers and they were scaled down (flag ``scaled-crop``).

    """

    crop: Box
    tiles: tuple[Box, ...]
    scaled: bool


def study_regions(height: int, width: int) -> StudyRegions:
    """Return crop and tiles for a frame of this size, at least 2 x 2 pixels.

    Where the published numbers do not fit, each is scaled by width / 4032 (height / 3024 where that is less), cut off
    to an integer and made odd, so that crop and tiles start on the same CFA site and have even sizes (RESULTS 4).

    Examples
    --------
    >>> study_regions(3024, 4032).crop
    Box(top=1504, left=916, height=968, width=1318)
    >>> study_regions(1512, 2016).crop
    Box(top=752, left=458, height=484, width=660)

    """
    left, top, wide, high = _CROP
    scaled = top + high > height or left + wide > width
    factor = min(Fraction(width, STUDY_SIZE[1]), Fraction(height, STUDY_SIZE[0])) if scaled else Fraction(1)
    crop = _imcrop(_CROP, factor)
    columns, rows = _TILE_STARTS  # swapped, as published: imcrop takes the column first
    tiles = tuple(_imcrop((column, row, _TILE_EDGE, _TILE_EDGE), factor) for row in rows for column in columns)
    shifted = tuple(
        Box(top=crop.top + tile.top, left=crop.left + tile.left, height=tile.height, width=tile.width) for tile in tiles
    )
    return StudyRegions(crop=crop, tiles=shifted, scaled=scaled)


def _imcrop(numbers: tuple[int, int, int, int], factor: Fraction) -> Box:
    """Return the pixels that imcrop [x y width height] takes: it counts from 1, and one more than the size."""
    x, y, width, height = (_odd(number * factor) for number in numbers)
    return Box(top=y - 1, left=x - 1, height=height + 1, width=width + 1)


def _odd(number: Fraction) -> int:
    whole = math.floor(number)
    return whole + 1 if whole % 2 == 0 else whole
