"""Portable grey maps (PGM, binary or text): a mosaic of 8 or 16 bits, without levels or CFA."""

import re
from pathlib import Path
from typing import Final

import numpy as np
from numpy.typing import NDArray

from fullwell.errors import UnreadableFileError, UnsuitableFileError
from fullwell.findings import Finding, Severity
from fullwell.raw.image import Area, RawHeader
from fullwell.raw.segments import MAX_PIXELS

SIGNATURES: Final = (b"P5", b"P6", b"P2", b"P3")
HEAD_BYTES: Final = 4096
_TEXT: Final = "text"
_PLAIN: Final = re.compile(rb"[\d\s]*")
_COMMENT: Final = re.compile(rb"#[^\n]*")
_TOKEN: Final = re.compile(rb"\s*(?:#[^\n]*\n\s*)*(\d{1,9})")


def read_netpbm_header(path: Path, size: int) -> RawHeader:
    """Return the header of a PGM file of ``size`` bytes.

    Raises
    ------
    UnsuitableFileError
        ``processed-rgb`` where it is in colour.
    UnreadableFileError
        ``file-truncated`` or ``file-damaged``.

    """
    with path.open("rb") as file:
        head = file.read(HEAD_BYTES)
    if head.startswith((b"P6", b"P3")):
        raise UnsuitableFileError(
            "processed-rgb", "the netpbm image is in colour, not a mosaic; use raw frames instead"
        )
    (width, height, highest), offset = _numbers(head)
    if not (0 < width * height <= MAX_PIXELS and 0 < highest <= 65535):
        raise UnreadableFileError("file-damaged", "the PGM header gives no possible size; copy the file again")
    name = _TEXT if head.startswith(b"P2") else ">u2" if highest > 255 else "u1"
    end = offset + (2 * width * height - 1 if name == _TEXT else width * height * np.dtype(name).itemsize)
    if end > size:
        raise _cut_short()
    return RawHeader(
        path=path,
        format="pgm",
        raw_width=width,
        raw_height=height,
        active_area=Area(0, 0, height, width),
        cfa=None,
        bit_depth=highest.bit_length(),
        layout=(offset, name),
        findings=() if name == _TEXT else _others(path, end),
    )


def decode_netpbm(header: RawHeader, data: memoryview) -> NDArray[np.uint16]:
    """Return the visible mosaic of a PGM file, shape (height, width) [DN].

    Raises
    ------
    UnreadableFileError
        ``file-truncated``; ``file-damaged`` where text holds anything but numbers up to its highest.

    """
    if not isinstance(header.layout, tuple):
        raise TypeError("the header is not that of a PGM file")
    offset, name = header.layout
    count = header.raw_width * header.raw_height
    if name == _TEXT:
        codes = _written(data[offset:], highest=2**header.bit_depth - 1)
    else:
        codes = np.frombuffer(data[offset:], name, min(count, (len(data) - offset) // np.dtype(name).itemsize))
    if len(codes) < count:
        raise _cut_short()
    stored = codes[:count].reshape(header.raw_height, header.raw_width)
    area = header.active_area
    return np.ascontiguousarray(stored[area.top : area.bottom, area.left : area.right], dtype=np.uint16)


def _written(data: memoryview, *, highest: int) -> NDArray[np.integer]:
    """Return the codes of a PGM that is written as text."""
    text = _COMMENT.sub(b"", data)
    if _PLAIN.fullmatch(text) is None:
        raise UnreadableFileError("file-damaged", "the PGM holds more than numbers; copy the file again")
    codes = np.fromstring(text.decode("ascii"), dtype=np.int64, sep=" ")
    if codes.size and not 0 <= int(codes.min()) <= int(codes.max()) <= highest:
        raise UnreadableFileError("file-damaged", f"the PGM holds codes above {highest} DN, its highest")
    return codes


def _others(path: Path, end: int) -> tuple[Finding, ...]:
    """Return a warning where another image follows the first."""
    with path.open("rb") as file:
        file.seek(end)
        if not file.read(16).lstrip().startswith((b"P5", b"P2")):
            return ()
    message = "The first image of several in the PGM file is read; split the file where the others count."
    return (Finding(code="images-left-out", severity=Severity.WARNING, message=message),)


def _cut_short() -> UnreadableFileError:
    return UnreadableFileError("file-truncated", "the PGM file ends before its pixels do; copy it again")


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
