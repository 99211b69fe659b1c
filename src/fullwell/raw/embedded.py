"""Where makers' raw files that are no TIFF keep their EXIF directories: RAF, CR3, MRW, X3F, CRW and their like."""

import struct
from collections.abc import Iterator, Mapping
from typing import Final

_TIFF_LIKE: Final = (b"II", b"MM")
_CIFF: Final = b"HEAPCCDR"
_RAF: Final = b"FUJIFILMCCD-RAW"
_CR3: Final = b"crx "
_MRW: Final = b"\0MRM"
_X3F: Final = b"FOVb"
_JPEG: Final = b"\xff\xd8\xff"
_CANON_UUID: Final = bytes.fromhex("85c0b687820f11e08111f4ce462b6a48")
_CANON_BLOCKS: Final[Mapping[bytes, str | None]] = {b"CMT1": None, b"CMT2": "EXIF", b"CMT3": "MakerNote"}
_MOST_BOXES: Final = 64
_MOST_EMBEDDED: Final = 64_000_000

_RAF_LAYOUT: Final = 0x0130


def exif_blocks(data: bytes) -> Iterator[tuple[bytes, str | None]]:
    """Yield what exifread can read of a file: TIFF or JPEG data, and the name of its only directory if it has one."""
    head = data[:16]
    if head[6:14] == _CIFF:
        return
    if head.startswith(_TIFF_LIKE):
        yield data, None
    elif head.startswith(_RAF):
        yield from _jpeg_at(data, *_unpacked(data, ">II", 84))
    elif head[4:12] == b"ftyp" + _CR3:
        yield from _canon_blocks(data)
    elif head.startswith(_MRW):
        yield from ((body, None) for name, body in _minolta_blocks(data) if name == b"\0TTW")
    elif head.startswith(_X3F):
        start = data.find(_JPEG)
        yield from _jpeg_at(data, max(start, 0), len(data) if start > 0 else 0)


def fuji_is_rotated(data: bytes) -> bool:
    """Return whether a RAF file's own directory says that its pixels stand diagonally (SuperCCD)."""
    layout = _raf_directory(data).get(_RAF_LAYOUT, b"")
    return len(layout) > 1 and not layout[1] & 8


def _raf_directory(data: bytes) -> Mapping[int, bytes]:
    """Return the tags of a RAF file's own directory, by number; empty for any other file."""
    tags: dict[int, bytes] = {}
    if not data.startswith(_RAF):
        return tags
    (start,) = _unpacked(data, ">I", 92)
    (count,) = _unpacked(data, ">I", start)
    at = start + 4
    for _ in range(min(count, 255)):
        number, length = _unpacked(data, ">HH", at)
        tags[number] = data[at + 4 : at + 4 + length]
        at += 4 + length
    return tags


def ciff_names(data: bytes) -> tuple[str | None, str | None]:
    """Return the make and model of a CRW file; None where it is none, or lacks them."""
    if data[6:14] != _CIFF:
        return None, None
    at = data.find(b"Canon\0", 26)
    if at < 0:
        return None, None
    model = data[at + 6 : at + 70].partition(b"\0")[0].decode("ascii", "replace").strip()
    return "Canon", model or None


def wavelet_levels(data: bytes) -> int:
    """Return how many levels of wavelets the pictures of a CR3 file go through: more than 0 means lossy."""
    if data[4:12] != b"ftyp" + _CR3:
        return 0
    levels, at = 0, 0
    for _ in range(_MOST_BOXES):
        at = data.find(b"CMP1", at)
        if at < 0 or at + 31 > len(data):
            break
        levels = max(levels, data[at + 30] & 15)
        at += 4
    return levels


def fuji_is_lossy(data: bytes) -> bool:
    """Return whether a RAF file's pixels are coded with loss, as the head of its coded data says."""
    if not data.startswith(_RAF):
        return False
    (start,) = _unpacked(data, ">I", 100)
    for at in (start, *_tiff_strip(data, start)):
        if data[at : at + 2] == b"IS":
            return data[at + 2] != 1
    return False


def declared_end(data: bytes) -> int:
    """Return where a RAF or CR3 file must end at the earliest by what it says itself; 0 for any other [byte]."""
    if data.startswith(_RAF):
        return sum(_unpacked(data, ">II", 100))
    if data[4:12] != b"ftyp" + _CR3:
        return 0
    at = 0
    for _ in range(_MOST_BOXES):
        (length,) = _unpacked(data, ">I", at)
        if length == 1:
            (length,) = _unpacked(data, ">Q", at + 8)
        at += length
        if length < 8 or at >= len(data):
            break
    return at


def _tiff_strip(data: bytes, start: int) -> Iterator[int]:
    """Yield where the strip of the TIFF within a RAF file begins: its tag 0xf007 counts from the TIFF's head."""
    order = {b"II": "<", b"MM": ">"}.get(data[start : start + 2])
    if order is None:
        return
    at = start + 8
    for _ in range(4):  # directory, its one tag 0xf000, the directory that it points to
        (count,) = _unpacked(data, f"{order}H", at)
        for index in range(min(count, 64)):
            tag, _kind, _count, value = _unpacked(data, f"{order}HHII", at + 2 + 12 * index)
            if tag == 0xF007:
                yield start + value
                return
            if tag == 0xF000:
                at = start + value
                break
        else:
            return


def _jpeg_at(data: bytes, start: int, length: int) -> Iterator[tuple[bytes, None]]:
    if data[start : start + 3] == _JPEG:
        yield data[start : start + min(length, _MOST_EMBEDDED)], None


def _canon_blocks(data: bytes) -> Iterator[tuple[bytes, str | None]]:
    """Yield the TIFF blocks of a CR3 file: moov, its uuid box, and CMT1 to CMT3 in it."""
    for name, body in _boxes(data):
        if name != b"moov":
            continue
        for inner, content in _boxes(body):
            if inner == b"uuid" and content[:16] == _CANON_UUID:
                yield from ((block, _CANON_BLOCKS[cmt]) for cmt, block in _boxes(content[16:]) if cmt in _CANON_BLOCKS)


def _boxes(data: bytes) -> Iterator[tuple[bytes, bytes]]:
    at = 0
    for _ in range(_MOST_BOXES):
        if at + 8 > len(data):
            return
        (length,) = _unpacked(data, ">I", at)
        name, head = data[at + 4 : at + 8], 8
        if length == 1:
            (length,), head = _unpacked(data, ">Q", at + 8), 16
        if length < head:
            return
        yield name, data[at + head : at + length]
        at += length


def _minolta_blocks(data: bytes) -> Iterator[tuple[bytes, bytes]]:
    at = 8
    for _ in range(_MOST_BOXES):
        if at + 8 > len(data):
            return
        (length,) = _unpacked(data, ">I", at + 4)
        yield data[at : at + 4], data[at + 8 : at + 8 + length]
        at += 8 + length


def _unpacked(data: bytes, form: str, at: int) -> tuple[int, ...]:
    """Return numbers from a file; zeros where it ends before."""
    if at + struct.calcsize(form) > len(data):
        return (0,) * len(form.lstrip("<>"))
    return struct.unpack_from(form, data, at)
