"""Portable grey maps (PGM, binary): a mosaic of 8 or 16 bits, without levels or CFA."""

import re
from pathlib import Path
from typing import Final

import numpy as np
from numpy.typing import NDArray

from fullwell.errors import UnreadableFileError, UnsuitableFileError
from fullwell.raw.image import Area, RawHeader
from fullwell.raw.segments import MAX_PIXELS

SIGNATURES: Final = (b"P5", b"P6", b"P2", b"P3")
HEAD_BYTES: Final = 4096
_TOKEN: Final = re.compile(rb"\s*(?:#[^\n]*\n\s*)*(\d{1,9})")


def read_netpbm_header(path: Path, size: int) -> RawHeader:
    """Return the header of a binary PGM file of ``size`` bytes.

    Raises
    ------
    UnsuitableFileError
        ``processed-rgb`` where it is in colour, ``unsupported-sample-format`` where it is written as text.
    UnreadableFileError
        ``file-truncated`` or ``file-damaged``.

    """
    with path.open("rb") as file:
        head = file.read(HEAD_BYTES)
    if head.startswith((b"P6", b"P3")):
        raise UnsuitableFileError(
            "processed-rgb", "the netpbm image is in colour, not a mosaic; use raw frames instead"
        )
    if head.startswith(b"P2"):
        raise UnsuitableFileError("unsupported-sample-format", "the PGM is written as text; make it binary (P5)")
    (width, height, highest), offset = _numbers(head)
    if not (0 < width * height <= MAX_PIXELS and 0 < highest <= 65535):
        raise UnreadableFileError("file-damaged", "the PGM header gives no possible size; copy the file again")
    if offset + width * height * (2 if highest > 255 else 1) > size:
        raise UnreadableFileError("file-truncated", "the PGM file ends before its pixels do; copy it again")
    return RawHeader(
        path=path,
        format="pgm",
        raw_width=width,
        raw_height=height,
        active_area=Area(0, 0, height, width),
        cfa=None,
        bit_depth=highest.bit_length(),
        layout=(offset, ">u2" if highest > 255 else "u1"),
    )


def decode_netpbm(header: RawHeader, data: memoryview) -> NDArray[np.uint16]:
    """Return the visible mosaic of a PGM file, shape (height, width) [DN].

    Raises
    ------
    UnreadableFileError
        ``file-truncated``.

    """
    if not isinstance(header.layout, tuple):
        raise TypeError("the header is not that of a PGM file")
    offset, name = header.layout
    dtype, count = np.dtype(name), header.raw_width * header.raw_height
    if offset + count * dtype.itemsize > len(data):
        raise UnreadableFileError("file-truncated", "the PGM file ends before its pixels do; copy it again")
    stored = np.frombuffer(data, dtype, count, offset).reshape(header.raw_height, header.raw_width)
    area = header.active_area
    return np.ascontiguousarray(stored[area.top : area.bottom, area.left : area.right], dtype=np.uint16)


def _numbers(head: bytes) -> tuple[tuple[int, int, int], int]:
    """Return width, height and highest value, and where the pixels begin [byte]."""
    numbers: list[int] = []
    at = len(b"P5")
    while len(numbers) < 3:
        found = _TOKEN.match(head, at)
        if found is None:
            raise UnreadableFileError("file-damaged", "the PGM header is damaged; copy the file again")
        numbers.append(int(found.group(1)))
        at = found.end()
    return (numbers[0], numbers[1], numbers[2]), at + 1
