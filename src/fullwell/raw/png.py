"""Greyscale PNG files: a mosaic of 8 or 16 bits, without levels or CFA."""

import struct
import threading
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
_PIXELS: Final = b"IDAT"
_INTERLACE: Final = 28
"""Where the file says whether it is interlaced."""
_GREY: Final = 0
_MAX_EXPANSION: Final = 1100
"""Deflate packs at most about 1030 bytes into one."""
_OWN: Final = threading.local()


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


def decode_png(header: RawHeader, data: memoryview, *, out: NDArray[np.uint16] | None = None) -> NDArray[np.uint16]:
    """Return the visible mosaic of a PNG file, shape (height, width) [DN]; in ``out`` where that fits.

    Raises
    ------
    UnreadableFileError
        ``file-truncated`` or ``file-damaged``.

    """
    packed = _pixels_packed(data)
    shape, area = (header.raw_height, header.raw_width), header.active_area
    whole = (area.top, area.left, area.bottom, area.right) == (0, 0, *shape)
    pixels = out if out is not None and whole else np.empty(shape, np.uint16)
    if data[_INTERLACE]:
        ask("png", data, out=pixels, shape=list(shape))
    else:
        _unpack(packed, pixels, size=header.bit_depth // 8)
    visible = pixels[area.top : area.bottom, area.left : area.right]
    return np.ascontiguousarray(visible)


def _unpack(packed: bytes, pixels: NDArray[np.uint16], *, size: int) -> None:
    """Write the pixels of a file that is not interlaced, of ``size`` bytes each."""
    from imagecodecs import DeflateError, deflate_decode  # noqa: PLC0415 - loads when used

    from fullwell.kernels.png_rows import undo_filters  # noqa: PLC0415 - loads the JIT when used

    rows, columns = pixels.shape
    lines = _memory(rows * (1 + size * columns))
    try:
        found = deflate_decode(packed, out=lines.data)
    except DeflateError as error:
        raise UnreadableFileError("file-damaged", "the PNG pixels are damaged; copy the file again") from error
    if len(found) != lines.size or not undo_filters(lines.reshape(rows, -1), pixels, size):
        raise UnreadableFileError("file-damaged", "the PNG pixels are damaged; copy the file again")


def _memory(size: int) -> NDArray[np.uint8]:
    """Return memory that a thread uses again for every file of a size: new memory costs more than what it is for."""
    kept: NDArray[np.uint8] | None = getattr(_OWN, "lines", None)
    if kept is None or kept.size != size:
        kept = _OWN.lines = np.empty(size, np.uint8)
    return kept


def _pixels_packed(data: memoryview) -> bytes:
    """Return what the pixels are packed in, after refusing a file whose chunks are damaged or cut."""
    from imagecodecs import deflate_crc32  # noqa: PLC0415 - loads when used

    position = len(SIGNATURE)
    name = b""
    packed: list[memoryview] = []
    while name != _END:
        if position + 12 > len(data):
            raise UnreadableFileError("file-truncated", "the PNG file ends before its pixels do; copy it again")
        (length,) = struct.unpack_from(">I", data, position)
        name = bytes(data[position + 4 : position + 8])
        checked = position + 8 + length
        if checked + 4 > len(data):
            raise UnreadableFileError("file-truncated", "the PNG file ends before its pixels do; copy it again")
        chunk = data[position + 4 : checked]
        if deflate_crc32(bytes(chunk)) != struct.unpack_from(">I", data, checked)[0]:
            raise UnreadableFileError("file-damaged", "the PNG pixels are damaged (checksum); copy the file again")
        if name == _PIXELS:
            packed.append(chunk[4:])
        position = checked + 4
    return b"".join(packed)
