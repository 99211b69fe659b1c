"""NumPy's ``.npy``: a mosaic, or frames one behind the other, as an array of whole numbers, without levels or CFA."""

import io
from pathlib import Path
from typing import Any, BinaryIO, Final

import numpy as np
from numpy.lib import format as npy
from numpy.typing import NDArray

from fullwell.errors import UnreadableFileError, UnsuitableFileError
from fullwell.raw.image import Area, RawHeader
from fullwell.raw.pages import MAX_FRAMES, paged
from fullwell.raw.segments import MAX_PIXELS

SIGNATURE: Final = b"\x93NUMPY"
_COLOURS: Final = (3, 4)


def read_numpy_headers(path: Path, size: int) -> tuple[RawHeader, ...]:
    """Return the header of every frame of an ``.npy`` file of ``size`` bytes; an array of (n, h, w) holds n of them.

    Raises
    ------
    UnsuitableFileError
        ``processed-rgb`` where the array has neither two dimensions nor three that cannot be colours,
        ``unsupported-sample-format`` where its numbers are not unsigned integers of 8 or 16 bits.
    UnreadableFileError
        ``file-truncated`` or ``file-damaged``.

    """
    with path.open("rb") as file:
        shape, fortran_order, dtype = _described(file)
        offset = file.tell()
    if not 2 <= len(shape) <= 3:
        raise UnsuitableFileError("processed-rgb", f"the array has {len(shape)} dimensions; a mosaic has two")
    if len(shape) == 3 and shape[2] in _COLOURS:
        raise UnsuitableFileError("processed-rgb", f"the array holds {shape[2]} colours for every pixel, not a mosaic")
    if dtype.kind != "u" or dtype.itemsize > 2 or fortran_order:
        raise UnsuitableFileError(
            "unsupported-sample-format", f"the array holds {dtype}; save it row by row as uint8 or uint16"
        )
    frames, height, width = shape if len(shape) == 3 else (1, *shape)
    if not 0 < width * height <= MAX_PIXELS or not 0 < frames <= MAX_FRAMES:
        raise UnreadableFileError("file-damaged", "the array has no possible size; copy the file again")
    length = width * height * dtype.itemsize
    if offset + frames * length > size:
        raise UnreadableFileError("file-truncated", "the array ends before its header says; copy the file again")
    whole = RawHeader(
        path=path,
        format="npy",
        raw_width=width,
        raw_height=height,
        active_area=Area(0, 0, height, width),
        cfa=None,
        bit_depth=8 * dtype.itemsize,
        layout=(offset, dtype.str),
    )
    return paged(whole, frames=frames, offset=offset, length=length, layout=(0, dtype.str))


def decode_numpy(header: RawHeader, data: memoryview) -> NDArray[np.uint16]:
    """Return the visible mosaic of an ``.npy`` file, shape (height, width) [DN].

    Raises
    ------
    UnreadableFileError
        ``file-truncated``.

    """
    if not isinstance(header.layout, tuple):
        raise TypeError("the header is not that of an array")
    offset, name = header.layout
    dtype, count = np.dtype(name), header.raw_width * header.raw_height
    if offset + count * dtype.itemsize > len(data):
        raise UnreadableFileError("file-truncated", "the array ends before its header says; copy the file again")
    stored = np.frombuffer(data, dtype, count, offset).reshape(header.raw_height, header.raw_width)
    area = header.active_area
    return np.ascontiguousarray(stored[area.top : area.bottom, area.left : area.right], dtype=np.uint16)


def _described(file: BinaryIO) -> tuple[tuple[int, ...], bool, np.dtype[Any]]:
    """Return shape, order and type; nothing is unpickled."""
    try:
        version = npy.read_magic(file)
        head = io.BytesIO(file.read(1 << 16)) if version not in {(1, 0), (2, 0)} else file
        reader = npy.read_array_header_1_0 if version == (1, 0) else npy.read_array_header_2_0
        return reader(head)
    except Exception as error:  # NumPy's message is all there is, whatever its class
        raise UnreadableFileError("file-damaged", f"the header of the array is damaged ({error})") from error
