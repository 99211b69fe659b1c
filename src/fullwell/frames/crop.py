"""A region of every frame: cropping moves what counts as visible, and with it the phase of the CFA."""

from dataclasses import replace
from typing import Final

from fullwell.errors import UsageError
from fullwell.frames.series import Frame, Series, Study
from fullwell.raw.cfa import MONO, cell, shifted
from fullwell.raw.image import Area, Levels, RawHeader

SMALLEST_CROP: Final = 2
"""Least width and height of a region, in cells of the CFA: a variance needs two pixels of a plane."""


def cropped(study: Study, region: tuple[int, int, int, int]) -> Study:
    """Return a study of which only a region is visible.

    Parameters
    ----------
    study
        The whole frames.
    region
        x, y, width and height in pixels of the visible mosaic; an odd x or y shifts the CFA.

    Raises
    ------
    UsageError
        Where the region reaches out of the frames, or is too small to measure anything.

    """
    x, y, width, height = region
    if x + width > study.width or y + height > study.height:
        raise UsageError(
            f"--crop {x},{y},{width},{height} reaches out of the visible mosaic, which has "
            f"{study.width} x {study.height} pixels."
        )
    least = SMALLEST_CROP * cell(study.cfa)
    if min(width, height) < least:
        raise UsageError(
            f"--crop {x},{y},{width},{height} is too small: width and height are at least {least} pixels "
            f"({SMALLEST_CROP} x {SMALLEST_CROP} cells of a {study.cfa} mosaic)."
        )
    return replace(
        study,
        width=width,
        height=height,
        cfa=shifted(study.cfa, rows=y, columns=x),
        black_level=_levels(study.black_level, x=x, y=y),
        white_level=_levels(study.white_level, x=x, y=y),
        series=tuple(_series(series, region) for series in study.series),
    )


def _series(series: Series, region: tuple[int, int, int, int]) -> Series:
    frames = tuple(_frame(frame, region) for frame in series.frames)
    return replace(series, frames=frames)


def _frame(frame: Frame, region: tuple[int, int, int, int]) -> Frame:
    return replace(frame, header=_header(frame.header, region))


def _header(header: RawHeader, region: tuple[int, int, int, int]) -> RawHeader:
    x, y, width, height = region
    top, left = header.active_area.top + y, header.active_area.left + x
    return replace(
        header,
        active_area=Area(top, left, top + height, left + width),
        cfa=shifted(header.cfa or MONO, rows=y, columns=x),
        black_level=_levels(header.black_level, x=x, y=y),
        white_level=_levels(header.white_level, x=x, y=y),
    )


def _levels(levels: Levels | None, *, x: int, y: int) -> Levels | None:
    if levels is None or len(levels.values) == 1:
        return levels
    values = tuple(levels.values[(site // 2 + y) % 2 * 2 + (site + x) % 2] for site in range(4))
    return replace(levels, values=values)
