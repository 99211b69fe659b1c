"""A DNG file with its opcodes changed, everything else byte for byte as it was.

The raw image's directory is written anew behind the end of the file and the one pointer to it is redirected; values,
pixels and other directories stay where they are, so that tags nobody here knows survive.
"""

import struct
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from fullwell.errors import UnreadableFileError, UnsuitableFileError
from fullwell.raw.directory import Directories, Directory
from fullwell.raw.dng import raw_image
from fullwell.raw.fields import FieldType
from fullwell.raw.opcodes import GainMap, Opcode, OpcodeList, opcode_bytes, parse_opcodes
from fullwell.raw.tags import Tag
from fullwell.raw.tiff_file import write_whole

_ENTRY: Final = 12
_INLINE: Final = 4
_RANKED: Final = (Tag.NEW_SUBFILE_TYPE, Tag.PHOTOMETRIC, Tag.IMAGE_WIDTH, Tag.IMAGE_LENGTH)
"""Tags that tell the raw image from its previews."""
_FORMATS: Final[Mapping[int, str]] = dict(
    enumerate(["B", "B", "H", "I", "Q", "b", "B", "h", "i", "q", "f", "d", "I"], 1)
)
"""A format of each TIFF type's size; rationals are eight bytes."""


@dataclass(frozen=True, slots=True, kw_only=True)
class _Tiff:
    """A classic TIFF file in memory.

    Parameters
    ----------
    data
        All of it.
    order
        ``<`` or ``>``.

    """

    data: bytes
    order: str

    def numbers(self, form: str, position: int) -> tuple[int, ...]:
        return struct.unpack_from(f"{self.order}{form}", self.data, position)


@dataclass(frozen=True, slots=True, kw_only=True)
class _Place:
    """Where a directory is.

    Parameters
    ----------
    pointer
        Where in the file the position of this directory is written.
    entries
        Position of each of its entries.
    following
        Position of the next directory of the chain, or 0.

    """

    pointer: int
    entries: tuple[int, ...]
    following: int


def read_opcodes(path: Path) -> Mapping[OpcodeList, tuple[Opcode | GainMap, ...]]:
    """Return the opcode lists of a DNG file's raw image; a list that it lacks is empty.

    Raises
    ------
    UnreadableFileError
        ``file-damaged`` where the file is no TIFF, or a list is damaged.
    UnsuitableFileError
        ``unsupported-tiff`` where it is a BigTIFF.

    """
    tiff = _opened(path)
    raw = _raw_directory(tiff)
    return {one: parse_opcodes(_value(tiff, raw, one)) for one in OpcodeList}


def copy_with_gain_maps(source: Path, target: Path, maps: tuple[GainMap, ...]) -> int:
    """Write a copy of a DNG file whose OpcodeList2 ends in gain maps; every other tag and every pixel stay.

    Parameters
    ----------
    source
        A DNG file.
    target
        The copy; one that exists is replaced.
    maps
        One per CFA site. Gain maps that the list held already are left out: they correct the same shading.

    Returns
    -------
    int
        How many gain maps were left out.

    Raises
    ------
    UnreadableFileError, UnsuitableFileError
        As `read_opcodes`.

    """
    tiff = _opened(source)
    raw = _raw_directory(tiff)
    listed = parse_opcodes(_value(tiff, raw, OpcodeList.OPCODE_LIST_2))
    others = tuple(one for one in listed if isinstance(one, Opcode))
    write_whole(target, _rewritten(tiff, raw, OpcodeList.OPCODE_LIST_2, opcode_bytes((*others, *maps))))
    return len(listed) - len(others)


def _rewritten(tiff: _Tiff, directory: _Place, tag: int, value: bytes) -> tuple[bytes, ...]:
    """Return the file, in parts, with a tag of type UNDEFINED set in one directory."""
    data, order = tiff.data, tiff.order
    value_at = len(data) + len(data) % 2
    start = value_at + len(value) + len(value) % 2
    inline = value.ljust(_INLINE, b"\0") if len(value) <= _INLINE else struct.pack(f"{order}I", value_at)
    entry = struct.pack(f"{order}HHI", tag, FieldType.UNDEFINED, len(value)) + inline
    kept = [data[place : place + _ENTRY] for place in directory.entries if tiff.numbers("H", place) != (tag,)]
    entries = sorted([*kept, entry], key=lambda one: struct.unpack_from(f"{order}H", one))
    table = struct.pack(f"{order}H", len(entries)) + b"".join(entries) + struct.pack(f"{order}I", directory.following)
    if start + len(table) >= 1 << 32:
        raise UnsuitableFileError("unsupported-tiff", "with gain maps the file would be larger than 4 GiB")
    before, after = data[: directory.pointer], data[directory.pointer + 4 :]
    padded = value + b"\0" * (len(value) % 2)
    return (before, struct.pack(f"{order}I", start), after, b"\0" * (len(data) % 2), padded, table)


def _opened(path: Path) -> _Tiff:
    data = path.read_bytes()
    orders = {b"II*\0": "<", b"MM\0*": ">"}
    if data[:4] in {b"II+\0", b"MM\0+"}:
        raise UnsuitableFileError("unsupported-tiff", "the file is a BigTIFF, whose opcodes are not read or written")
    if data[:4] not in orders:
        raise UnreadableFileError("file-damaged", "the file is no TIFF or DNG")
    return _Tiff(data=data, order=orders[data[:4]])


def _raw_directory(tiff: _Tiff) -> _Place:
    """Return the directory of the main image, chosen as the reader chooses it."""
    try:
        first = _directory(tiff, pointer=4)
        subs = [_directory(tiff, pointer=pointer) for pointer in _sub_pointers(tiff, first)]
        plain = [_ranked(tiff, one) for one in (first, *subs)]
    except struct.error as error:
        raise _damaged() from error
    nothing = Directory(values={})
    directories = Directories(
        byte_order=tiff.order, size=len(tiff.data), first=plain[0], subs=tuple(plain[1:]), exif=nothing
    )
    chosen = raw_image(directories)
    return (first, *subs)[next(index for index, one in enumerate(plain) if one is chosen)]


def _directory(tiff: _Tiff, *, pointer: int) -> _Place:
    (start,) = tiff.numbers("I", pointer)
    (count,) = tiff.numbers("H", start)
    end = start + 2 + _ENTRY * count
    (following,) = tiff.numbers("I", end)
    return _Place(pointer=pointer, entries=tuple(range(start + 2, end, _ENTRY)), following=following)


def _sub_pointers(tiff: _Tiff, first: _Place) -> list[int]:
    """Return where the positions of the SubIFDs are written."""
    where = _located(tiff, first, Tag.SUB_IFDS)
    return [] if where is None else list(range(where[1], where[1] + where[2], 4))


def _located(tiff: _Tiff, directory: _Place, tag: int) -> tuple[str, int, int] | None:
    """Return format, position and length of a tag's value; None where the directory lacks it [-, byte, byte]."""
    for place in directory.entries:
        code, kind = tiff.numbers("HH", place)
        if code == tag and kind in _FORMATS:
            (count,) = tiff.numbers("I", place + 4)
            length = count * struct.calcsize(f"={_FORMATS[kind]}")
            position = place + 8 if length <= _INLINE else tiff.numbers("I", place + 8)[0]
            return _FORMATS[kind], position, length
    return None


def _value(tiff: _Tiff, directory: _Place, tag: int) -> bytes:
    """Return a tag's value as the file has it; empty where the directory lacks it."""
    where = _located(tiff, directory, tag)
    if where is None:
        return b""
    _form, position, length = where
    if position + length > len(tiff.data):
        raise _damaged()
    return tiff.data[position : position + length]


def _ranked(tiff: _Tiff, directory: _Place) -> Directory:
    """Return the tags of a directory that tell whether it is the raw image's."""
    located = {tag: _located(tiff, directory, tag) for tag in _RANKED}
    values = {tag: (float(tiff.numbers(one[0], one[1])[0]),) for tag, one in located.items() if one and one[2]}
    return Directory(values=values)


def _damaged() -> UnreadableFileError:
    return UnreadableFileError("file-damaged", "the TIFF directories are damaged; copy the file again")
