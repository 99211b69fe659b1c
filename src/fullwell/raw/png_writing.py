"""PNG without filters: 16-bit greyscale files, as readers of EMVA 1288 descriptors expect them, and flat colours."""

import struct
import zlib
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from fullwell.raw.png import SIGNATURE

_GREY, _COLOR_AND_OPACITY = 0, 6
"""Kinds of pixels."""
_QUICK, _SMALL = 1, 6
"""Levels of compression."""


def write_png(path: Path, mosaic: NDArray[np.uint16]) -> None:
    """Write a mosaic as a PNG file of 16 bits.

    Parameters
    ----------
    path
        The file.
    mosaic
        Shape (height, width) [DN].

    """
    height, width = mosaic.shape
    rows = np.zeros((height, 1 + 2 * width), np.uint8)
    rows[:, 1:] = np.ascontiguousarray(mosaic).astype(">u2").view(np.uint8).reshape(height, 2 * width)
    path.write_bytes(_packed(rows, width, bits=16, kind=_GREY, level=_QUICK))


def flat_png(image: NDArray[np.uint8]) -> bytes:
    """Return colours with opacity as a PNG: small where neighbours are alike, since no row is told by its differences.

    Parameters
    ----------
    image
        Red, green, blue and opacity, shape (height, width, 4).

    """
    height, width = image.shape[:2]
    rows = np.zeros((height, 1 + 4 * width), np.uint8)
    rows[:, 1:] = image.reshape(height, 4 * width)
    return _packed(rows, width, bits=8, kind=_COLOR_AND_OPACITY, level=_SMALL)


def _packed(rows: NDArray[np.uint8], width: int, *, bits: int, kind: int, level: int) -> bytes:
    """Return the file of rows, each behind the number of its filter."""
    header = struct.pack(">IIBBBBB", width, len(rows), bits, kind, 0, 0, 0)
    chunks = ((b"IHDR", header), (b"IDAT", zlib.compress(rows.tobytes(), level)), (b"IEND", b""))
    return SIGNATURE + b"".join(_chunk(name, content) for name, content in chunks)


def _chunk(name: bytes, content: bytes) -> bytes:
    checksum = zlib.crc32(name + content)
    return struct.pack(">I", len(content)) + name + content + struct.pack(">I", checksum)
