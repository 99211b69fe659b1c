"""Greyscale PNG files: a mosaic of 8 or 16 bits, without levels or CFA."""

import struct
import zlib
from pathlib import Path
from typing import Final

import numpy as np
from numpy.typing import NDArray

from fullwell.errors import UnreadableFileError, UnsuitableFileError
from fullwell.raw.image import Area, RawHeader
from fullwell.raw.isolation import ask
from fullwell.raw.segments import MAX_PIXELS

SIGNATURE: Final = b"\x89PNG\r\n\x1a\n"
_HEADER_BYTES: Final = 33
_END: Final = b"IEND"
_GREY: Final = 0
_MAX_EXPANSION: Final = 1100
"""Deflate packs at most about 1030 bytes into one."""


def read_png_header(path: Path, head: bytes, size: int) -> RawHeader:
    """Return the header of a PNG file.

    Parameters
    ----------
    path
        The file.
    head
        Its first bytes, at least 33 of them.
    size
        Its length [byte].

    Raises
    ------
    UnsuitableFileError
        ``processed-rgb`` where it is in colour, ``unsupported-sample-format`` where it has less than 8 bits.
    UnreadableFileError
        ``file-truncated`` or ``file-damaged``.

    """
    if len(head) < _HEADER_BYTES:
        raise UnreadableFileError("file-truncated", "the PNG file ends within its header; copy it again")
    name, width, height, bits, colour = struct.unpack_from(">4sIIBB", head, len(SIGNATURE) + 4)
    if name != b"IHDR" or not (width > 0 and height > 0 and width * height <= MAX_PIXELS):
        raise UnreadableFileError("file-damaged", "the PNG header is damaged; copy the file again")
    if colour != _GREY:
        raise UnsuitableFileError("processed-rgb", "the PNG is in colour, not a mosaic; use raw frames instead")
    if bits not in {8, 16}:
        raise UnsuitableFileError("unsupported-sample-format", f"the PNG has {bits} bits per pixel, not 8 or 16")
    if width * height > _MAX_EXPANSION * size:
        raise UnreadableFileError("file-truncated", "the PNG file is too short for its pixels; copy it again")
    return RawHeader(
        path=path,
        format="png",
        raw_width=width,
        raw_height=height,
        active_area=Area(0, 0, height, width),
        cfa=None,
        bit_depth=bits,
        compression="deflate",
    )


def decode_png(header: RawHeader, data: memoryview) -> NDArray[np.uint16]:
    """Return the visible mosaic of a PNG file, shape (height, width) [DN].

    Raises
    ------
    UnreadableFileError
        ``file-truncated`` or ``file-damaged``.

    """
    _check_chunks(data)
    pixels = np.empty((header.raw_height, header.raw_width), np.uint16)
    ask("png", data, out=pixels, shape=list(pixels.shape))
    area = header.active_area
    visible = pixels[area.top : area.bottom, area.left : area.right]
    return np.ascontiguousarray(visible)


def _check_chunks(data: memoryview) -> None:
    """Refuse a file whose chunks are damaged or cut: libpng would warn on stderr and hand out what it has."""
    position = len(SIGNATURE)
    name = b""
    while name != _END:
        if position + 12 > len(data):
            raise UnreadableFileError("file-truncated", "the PNG file ends before its pixels do; copy it again")
        (length,) = struct.unpack_from(">I", data, position)
        name = bytes(data[position + 4 : position + 8])
        checked = position + 8 + length
        if checked + 4 > len(data):
            raise UnreadableFileError("file-truncated", "the PNG file ends before its pixels do; copy it again")
        if zlib.crc32(data[position + 4 : checked]) != struct.unpack_from(">I", data, checked)[0]:
            raise UnreadableFileError("file-damaged", "the PNG pixels are damaged (checksum); copy the file again")
        position = checked + 4
