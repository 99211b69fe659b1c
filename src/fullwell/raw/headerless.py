"""Headerless raw files: nothing but pixels (RESULTS 5).

The size of a file must be exactly that of its pixels: a wrong geometry is called wrong, with what would fit.
"""

import sys
from pathlib import Path
from typing import Final

import numpy as np
from numpy.typing import NDArray

from fullwell.errors import UnreadableFileError
from fullwell.findings import Finding, Severity
from fullwell.raw.headerless_format import BYTE, LSB, MIPI, WORD, HeaderlessFormat
from fullwell.raw.image import Area, RawHeader

_NATIVE: Final = sys.byteorder
MOST_STUCK: Final = 1e-3
"""Share of pixels that may be stuck at a code that the bits do not allow."""


def read_headerless_header(path: Path, stated: HeaderlessFormat, *, size: int, source: str) -> RawHeader:
    """Return the header of a file without one.

    Parameters
    ----------
    path
        The file.
    stated
        How its pixels are stored.
    size
        Its length [byte].
    source
        Who says so, for the finding.

    Raises
    ------
    UnreadableFileError
        ``geometry-mismatch`` where the file's size is another; the sentence says what would fit.

    """
    if size not in stated.file_sizes:
        from fullwell.raw.headerless_fit import mismatch  # noqa: PLC0415 - needed for bad news only

        raise UnreadableFileError("geometry-mismatch", mismatch(stated, size=size))
    return RawHeader(
        path=path,
        format="headerless",
        raw_width=stated.width,
        raw_height=stated.height,
        active_area=Area(0, 0, stated.height, stated.width),
        cfa=stated.cfa,
        bit_depth=stated.bits,
        compression="none" if stated.container in {BYTE, WORD} else stated.container,
        layout=stated,
        findings=(
            Finding(
                code="headerless",
                severity=Severity.INFO,
                message=f"The file has no header; it is read as {stated} (from {source}).",
            ),
        ),
    )


def decode_headerless(
    stated: HeaderlessFormat, data: memoryview, *, out: NDArray[np.uint16] | None = None
) -> NDArray[np.uint16]:
    """Return the mosaic of a headerless file.

    Parameters
    ----------
    stated
        How its pixels are stored.
    data
        The whole file.
    out
        Memory for the mosaic where it is not a view of ``data``; None takes new memory.

    Returns
    -------
    ndarray
        Shape (stated.height, stated.width), C-contiguous; a view of ``data`` where that is possible [DN].

    Raises
    ------
    UnreadableFileError
        ``geometry-mismatch`` where the file's size is another, ``geometry-wrong`` where codes are higher than so many
        bits allow, and are not a few pixels that are stuck far above.

    """
    if len(data) not in stated.file_sizes:
        from fullwell.raw.headerless_fit import mismatch  # noqa: PLC0415 - needed for bad news only

        raise UnreadableFileError("geometry-mismatch", mismatch(stated, size=len(data)))
    mosaic = unpacked(stated, data, out=out)
    spare = stated.container in {BYTE, WORD} and stated.bits < int(stated.container)
    if spare and int(mosaic.max()) >= 2**stated.bits and not _stuck_alone(mosaic, 2**stated.bits):
        from fullwell.raw.headerless_fit import too_high  # noqa: PLC0415 - as above

        raise UnreadableFileError("geometry-wrong", too_high(stated, mosaic))
    return mosaic


def _stuck_alone(mosaic: NDArray[np.uint16], limit: int) -> bool:
    """Tell a few stuck pixels from light that goes on beyond the limit: nothing lies in the next bit's range."""
    above = mosaic[mosaic >= limit]
    return above.size <= MOST_STUCK * mosaic.size and int(above.min()) >= 2 * limit


def unpacked(
    stated: HeaderlessFormat, data: memoryview, *, out: NDArray[np.uint16] | None = None
) -> NDArray[np.uint16]:
    """Return the mosaic as `decode_headerless` does, its codes as they come; the bytes must be there."""
    shape = (stated.height, stated.width)
    stored = np.frombuffer(data, dtype=np.uint8)[stated.offset :]
    if stated.container == WORD:
        words = _rows(stored, stated, np.dtype("<u2" if stated.byte_order == "little" else ">u2"))
        if stated.byte_order == _NATIVE and words.flags.c_contiguous and words.flags.aligned:
            return words.view(np.uint16)
    mosaic = np.empty(shape, dtype=np.uint16) if out is None or out.shape != shape else out
    if stated.container == WORD:
        mosaic[...] = _rows(stored, stated, np.dtype("<u2" if stated.byte_order == "little" else ">u2"))
    elif stated.container == BYTE:
        mosaic[...] = _rows(stored, stated, np.dtype(np.uint8))
    elif stated.container == MIPI:
        from fullwell.kernels.unpacking_mipi import unpack_mipi_rows  # noqa: PLC0415 - loads the JIT when used

        unpack_mipi_rows(stored, mosaic, bits=stated.bits, row_bytes=stated.stride)
    elif stated.container == LSB:
        from fullwell.kernels.unpacking_lsb import unpack_lsb_rows  # noqa: PLC0415 - loads the JIT when used

        unpack_lsb_rows(stored, mosaic, bits=stated.bits, row_bytes=stated.stride)
    else:
        from fullwell.kernels.unpacking import unpack_rows  # noqa: PLC0415 - loads the JIT when used

        unpack_rows(stored, mosaic, bits=stated.bits, row_bytes=stated.stride)
    return mosaic


def _rows(stored: NDArray[np.uint8], stated: HeaderlessFormat, kind: np.dtype) -> NDArray[np.generic]:
    """Return the samples as a view of the bytes, shape (height, width)."""
    return np.ndarray((stated.height, stated.width), kind, buffer=stored.data, strides=(stated.stride, kind.itemsize))
