"""TIFF files for programs that read no DNG, and linear pictures in colour, as TIFF or DNG.

Which function: `write_tiff` for a mosaic, whose levels TIFF has no tags for; `write_rgb` for a picture.
"""

from pathlib import Path
from typing import Final, Literal

import numpy as np
from numpy.typing import NDArray

from fullwell.raw.cfa import MONO
from fullwell.raw.fields import Field, text
from fullwell.raw.tags import Compression, Photometric, Tag
from fullwell.raw.tiff_file import exif_fields, long, short, tiff_parts, write_whole
from fullwell.raw.write import DngExtras, camera_fields, pattern_fields

_BITS: Final = 16


def write_tiff(
    path: Path,
    mosaic: NDArray[np.uint16],
    *,
    cfa: str,
    iso: float | None = None,
    exposure_s: float | None = None,
    make: str | None = None,
    model: str | None = None,
    extras: DngExtras | None = None,
) -> None:
    """Write a mosaic as an uncompressed TIFF file of 16 bits, grey to everybody, its CFA in the tags of TIFF/EP.

    Parameters
    ----------
    path
        The file; one that exists is replaced.
    mosaic
        ``uint16``, shape (height, width) [DN].
    cfa
        Order at the top-left pixel, or ``mono``.
    iso, exposure_s
        ISO speed (a whole number) and exposure time [-, s].
    make, model
        Names of the camera.
    extras
        Orientation and temperature are kept; TIFF has no tags for the rest.

    """
    extras = extras or DngExtras()
    fields = [
        *_stored_fields(mosaic, photometric=Photometric.BLACK_IS_ZERO),
        *([] if cfa == MONO else pattern_fields(cfa)),
        *_named_fields(make=make, model=model, orientation=extras.orientation),
    ]
    exif = exif_fields(iso=iso, exposure_s=exposure_s, temperature_c=extras.temperature_c)
    write_whole(path, tiff_parts(fields, exif, [_bytes(mosaic)]))


def write_rgb(
    path: Path,
    rgb: NDArray[np.uint16],
    *,
    kind: Literal["dng", "tiff"],
    iso: float | None = None,
    exposure_s: float | None = None,
    make: str | None = None,
    model: str | None = None,
    extras: DngExtras | None = None,
) -> None:
    """Write a linear picture of 16 bits, black 0, white 65535, uncompressed.

    Parameters
    ----------
    path
        The file; one that exists is replaced.
    rgb
        The camera's red, green and blue, ``uint16``, shape (height, width, 3).
    kind
        ``dng`` (LinearRaw) or ``tiff``.
    iso, exposure_s, make, model, extras
        As in `write_tiff`; a DNG keeps neutral and colour matrix too.

    """
    extras = extras or DngExtras()
    if kind == "dng":
        named = camera_fields(cfa="RGGB", make=make or "unknown", model=model or "unknown camera", extras=extras)
        levels = [long(Tag.WHITE_LEVEL, *(2**_BITS - 1,) * 3)]
        fields = [*_stored_fields(rgb, photometric=Photometric.LINEAR_RAW), *levels, *named]
    else:
        named = _named_fields(make=make, model=model, orientation=extras.orientation)
        fields = [*_stored_fields(rgb, photometric=Photometric.RGB), *named]
    exif = exif_fields(iso=iso, exposure_s=exposure_s, temperature_c=extras.temperature_c)
    write_whole(path, tiff_parts(fields, exif, [_bytes(rgb)]))


def _stored_fields(samples: NDArray[np.uint16], *, photometric: int) -> list[Field]:
    height, width, *colours = samples.shape
    planes = colours[0] if colours else 1
    return [
        long(Tag.NEW_SUBFILE_TYPE, 0),
        long(Tag.IMAGE_WIDTH, width),
        long(Tag.IMAGE_LENGTH, height),
        short(Tag.BITS_PER_SAMPLE, *(_BITS,) * planes),
        short(Tag.COMPRESSION, Compression.NONE),
        short(Tag.PHOTOMETRIC, photometric),
        short(Tag.SAMPLES_PER_PIXEL, planes),
        long(Tag.ROWS_PER_STRIP, height),
        short(Tag.PLANAR_CONFIGURATION, 1),
    ]


def _named_fields(*, make: str | None, model: str | None, orientation: int) -> list[Field]:
    named = [(Tag.MAKE, make), (Tag.MODEL, model), (Tag.SOFTWARE, "Fullwell")]
    return [short(Tag.ORIENTATION, orientation), *(text(tag, value) for tag, value in named if value)]


def _bytes(samples: NDArray[np.uint16]) -> memoryview:
    return np.ascontiguousarray(samples, dtype="<u2").data.cast("B")
