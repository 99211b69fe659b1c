"""TIFF and DNG files put together: fields, an EXIF directory and segments of pixels become a file.

Which function: `short`, `long` and `exif_fields` make fields, `tiff_parts` the
file, `write_whole` puts it where it belongs.
"""

import struct
import uuid
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Final

from fullwell.raw.fields import Field, FieldType, directory_length, encode_directory
from fullwell.raw.tags import ISO_IN_OTHER_TAG, Tag

_ALIGNMENT: Final = 64
_LARGEST_FILE: Final = 1 << 32
_HIGHEST_SHORT_ISO: Final = 65534
_HIGHEST_ISO: Final = 2**32 - 1
_RECOMMENDED_EXPOSURE_INDEX: Final = 2
"""SensitivityType: which of those tags it is."""


def exif_fields(*, iso: float | None, exposure_s: float | None, temperature_c: float | None) -> list[Field]:
    """Return the fields of an EXIF directory; what is None is left out.

    Parameters
    ----------
    iso
        A whole number: EXIF has no other.
    exposure_s, temperature_c
        [s, deg C].

    Raises
    ------
    ValueError
        Where the ISO speed is no whole number above 0.

    """
    fields: list[Field] = []
    if iso is not None:
        if iso != int(iso) or not 0 < iso <= _HIGHEST_ISO:
            raise ValueError(f"EXIF has whole ISO speeds from 1 to {_HIGHEST_ISO}, not {iso}")
        fields.append(short(Tag.ISO_SPEED_RATINGS, int(iso) if iso <= _HIGHEST_SHORT_ISO else ISO_IN_OTHER_TAG))
        if iso > _HIGHEST_SHORT_ISO:
            fields.append(short(Tag.SENSITIVITY_TYPE, _RECOMMENDED_EXPOSURE_INDEX))
            fields.append(long(Tag.RECOMMENDED_EXPOSURE_INDEX, int(iso)))
    if exposure_s is not None:
        fields.append(Field(tag=Tag.EXPOSURE_TIME, type=FieldType.RATIONAL, values=(exposure_s,)))
    if temperature_c is not None:
        fields.append(Field(tag=Tag.TEMPERATURE, type=FieldType.SRATIONAL, values=(temperature_c,)))
    return fields


def tiff_parts(
    fields: Sequence[Field], exif: Sequence[Field], segments: Sequence[bytes | memoryview]
) -> tuple[bytes | memoryview, ...]:
    """Return a little-endian TIFF file of one image, in parts.

    Parameters
    ----------
    fields
        Those of its directory, but for what tells where segments and EXIF lie.
    exif
        Those of its EXIF directory; empty for none.
    segments
        Strips, or tiles where the fields have a TileWidth, in order.

    Raises
    ------
    ValueError
        Where the file would be 4 GiB or larger.

    """
    counts = [len(segment) for segment in segments]
    tiled = any(field.tag == Tag.TILE_WIDTH for field in fields)
    offsets_tag = Tag.TILE_OFFSETS if tiled else Tag.STRIP_OFFSETS
    counts_tag = Tag.TILE_BYTE_COUNTS if tiled else Tag.STRIP_BYTE_COUNTS
    draft = [*fields, long(offsets_tag, *counts), long(counts_tag, *counts), *([long(Tag.EXIF_IFD, 0)] if exif else [])]
    exif_start = 8 + directory_length(draft)
    end = exif_start + (directory_length(exif) if exif else 0)
    pixels_start = -(-end // _ALIGNMENT) * _ALIGNMENT
    if pixels_start + sum(counts) >= _LARGEST_FILE:
        raise ValueError("a TIFF file cannot be larger than 4 GiB")
    offsets = [pixels_start + sum(counts[:index]) for index in range(len(counts))]
    final = [*fields, long(offsets_tag, *offsets), long(counts_tag, *counts)]
    final += [long(Tag.EXIF_IFD, exif_start)] if exif else []
    head = struct.pack("<2sHI", b"II", 42, 8) + encode_directory(final, start=8, byte_order="<")
    if exif:
        head += encode_directory(exif, start=exif_start, byte_order="<")
    return (head.ljust(pixels_start, b"\0"), *segments)


def write_whole(path: Path, parts: Iterable[bytes | memoryview]) -> None:
    """Write a file beside its target first and rename it then, so that no half file is ever seen."""
    part = path.with_name(f".{path.name}.{uuid.uuid4().hex}.part")
    try:
        with part.open("xb") as file:
            file.writelines(parts)
        part.replace(path)
    finally:
        part.unlink(missing_ok=True)


def short(tag: Tag, *values: int) -> Field:
    """Return a field of 16-bit numbers."""
    return Field(tag=tag, type=FieldType.SHORT, values=values)


def long(tag: Tag, *values: int) -> Field:
    """Return a field of 32-bit numbers."""
    return Field(tag=tag, type=FieldType.LONG, values=values)
