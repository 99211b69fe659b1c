"""What is known about one raw file, and the file as an array."""

from dataclasses import dataclass
from pathlib import Path
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from fullwell.findings import Finding


class Area(NamedTuple):
    """A rectangle in raw coordinates: first row and column, and one past the last."""

    top: int
    left: int
    bottom: int
    right: int


class Extent(NamedTuple):
    """The bytes of a file that hold one of its frames: the first, and one past the last."""

    start: int
    stop: int


D65: Final = 21
"""Daylight, as the EXIF tag LightSource numbers it."""


class ColourMatrix(NamedTuple):
    """From XYZ to the camera's own colours under one light.

    Parameters
    ----------
    values
        Nine numbers, row by row, as the DNG tag ColorMatrix1 has them.
    illuminant
        The light, as the EXIF tag LightSource numbers it; 21 is D65.

    """

    values: tuple[float, ...]
    illuminant: int


@dataclass(frozen=True, slots=True, kw_only=True)
class Levels:
    """A level per CFA site, row-major from the visible top-left pixel, and where it came from.

    Parameters
    ----------
    values
        One level for a monochrome mosaic, four for a Bayer mosaic [DN].
    source
        ``metadata``, ``user``, ``manifest``, ``default`` ... ; ``tag`` names the maker's own name for it.

    """

    values: tuple[float, ...]
    source: str
    tag: str = ""


@dataclass(frozen=True, slots=True, kw_only=True)
class RawHeader:
    """Everything a raw file says about itself, without its pixels.

    Parameters
    ----------
    path
        The file.
    format
        ``dng``, ``tiff``, ``png``, ...
    raw_width, raw_height
        Size of the stored mosaic, margins included [pixel].
    active_area
        The visible mosaic in raw coordinates; everything else in Fullwell counts from its top-left pixel.
    cfa
        Order at the visible top-left pixel, ``mono``, or None where the file does not say.
    bit_depth
        Bits per sample as declared.
    black_level, white_level
        None where the file does not say.
    iso, exposure_s, temperature_c
        None where the file does not say, or says 0.
    masked_areas
        Optical-black rectangles in raw coordinates.
    noise_profile
        (S, O) per plane as the DNG tag NoiseProfile has them; empty where absent.
    make, model, serial, firmware
        Of the camera, as the file has them; firmware is the tag Software.
    orientation
        The tag Orientation of TIFF, 1 to 8; 1 where the file has none.
    compression
        How the pixels are stored; ``none`` where they lie in the file as they are.
    as_shot_neutral
        White in the camera's own R, G and B, as the DNG tag AsShotNeutral has it; empty where absent.
    colour_matrix
        For daylight where the file has several; None where it has none.
    level_tags
        Every level the file declares, by its maker's own name.
    settings
        What else sets a camera's amplification and offset, as the file spells it (``EGAIN 10.84``); empty where it
        does not say. Frames that differ in it are no frames of one series.
    page
        Which of the frames of a file this is, counted from 1; None where the file holds one.
    extent
        The bytes that hold this frame; None: all of the file.
    layout
        What the decoder of this format needs to find the pixels; opaque to everybody else.
    findings
        What reading the header brought to light.

    """

    path: Path
    format: str
    raw_width: int
    raw_height: int
    active_area: Area
    cfa: str | None
    bit_depth: int
    black_level: Levels | None = None
    white_level: Levels | None = None
    iso: float | None = None
    exposure_s: float | None = None
    temperature_c: float | None = None
    make: str | None = None
    model: str | None = None
    serial: str | None = None
    firmware: str | None = None
    orientation: int = 1
    compression: str = "none"
    masked_areas: tuple[Area, ...] = ()
    noise_profile: tuple[tuple[float, float], ...] = ()
    as_shot_neutral: tuple[float, ...] = ()
    colour_matrix: ColourMatrix | None = None
    level_tags: tuple[tuple[str, tuple[float, ...]], ...] = ()
    settings: str = ""
    page: int | None = None
    extent: Extent | None = None
    layout: object = None
    findings: tuple[Finding, ...] = ()

    @property
    def width(self) -> int:
        """Columns of the visible mosaic."""
        return self.active_area.right - self.active_area.left

    @property
    def height(self) -> int:
        """Rows of the visible mosaic."""
        return self.active_area.bottom - self.active_area.top

    @property
    def camera(self) -> str | None:
        """Make and model, the make once: many models begin with it; None where the file names neither."""
        make, model = self.make or "", self.model or ""
        named = model if model.casefold().startswith(make.casefold()) else f"{make} {model}"
        return named.strip() or make or None


@dataclass(frozen=True, slots=True, kw_only=True)
class RawImage:
    """The visible mosaic, integer and never clipped at black, with its header.

    Parameters
    ----------
    header
        What the file says about itself.
    mosaic
        Array of ``uint16``, shape (header.height, header.width) [DN], read-only.

    """

    header: RawHeader
    mosaic: NDArray[np.uint16]
