"""16-bit greyscale PNG files: what readers of EMVA 1288 descriptors expect."""

import struct
import zlib
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from fullwell.raw.png import SIGNATURE

_BITS = 16
_LEVEL = 1


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
    header = struct.pack(">IIBBBBB", width, height, _BITS, 0, 0, 0, 0)
    chunks = ((b"IHDR", header), (b"IDAT", zlib.compress(rows.tobytes(), _LEVEL)), (b"IEND", b""))
    path.write_bytes(SIGNATURE + b"".join(_chunk(name, content) for name, content in chunks))


def _chunk(name: bytes, content: bytes) -> bytes:
    checksum = zlib.crc32(name + content)
    return struct.pack(">I", len(content)) + name + content + struct.pack(">I", checksum)
