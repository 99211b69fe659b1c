"""A TIFF file's directories as plain values: the door to tifffile's tag reader.

Only the tags of `fullwell.raw.tags` are read, from the first directory, its SubIFDs and its EXIF directory. Frames of a
series often say the same, byte for byte: what was read last is kept, and stands for files of the same bytes there.
"""

import errno
import logging
import math
import struct
from collections import deque
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, BinaryIO, Final, cast

import numpy as np

from fullwell.errors import UnreadableFileError
from fullwell.raw.tags import Tag

if TYPE_CHECKING:
    from tifffile import TiffFile, TiffPage, TiffTag

_RATIONAL_TYPES: Final = (5, 10)
_MOST_PAGES: Final = 100_000
_EXIF_NAMES: Final = (
    ("ExposureTime", Tag.EXPOSURE_TIME),
    ("ISOSpeedRatings", Tag.ISO_SPEED_RATINGS),
    ("PhotographicSensitivity", Tag.ISO_SPEED_RATINGS),
    ("StandardOutputSensitivity", Tag.STANDARD_OUTPUT_SENSITIVITY),
    ("RecommendedExposureIndex", Tag.RECOMMENDED_EXPOSURE_INDEX),
    ("ISOSpeed", Tag.ISO_SPEED),
    ("Temperature", Tag.TEMPERATURE),
)
_RATIONAL_EXIF: Final = (Tag.EXPOSURE_TIME, Tag.TEMPERATURE)

logging.getLogger("tifffile").addHandler(logging.NullHandler())  # damage becomes an exception, not a line on stderr


@dataclass(frozen=True, slots=True, kw_only=True)
class Directory:
    """The tags of one image file directory: numbers as floats (rationals divided, n/0 is NaN), text as str."""

    values: Mapping[Tag, tuple[float, ...] | str]

    def __contains__(self, tag: Tag) -> bool:
        """Return whether the directory has the tag."""
        return tag in self.values

    def numbers(self, tag: Tag) -> tuple[float, ...]:
        """Return every value of a numeric tag; empty where it is absent or text."""
        value = self.values.get(tag, ())
        return () if isinstance(value, str) else value

    def number(self, tag: Tag) -> float | None:
        """Return the first value of a numeric tag; None where it is absent or not finite."""
        values = self.numbers(tag)
        return values[0] if values and math.isfinite(values[0]) else None

    def integers(self, tag: Tag) -> tuple[int, ...]:
        """Return every value of an integer tag; empty where it is absent or holds what is no integer."""
        values = self.numbers(tag)
        return tuple(int(value) for value in values) if all(math.isfinite(value) for value in values) else ()

    def integer(self, tag: Tag, default: int) -> int:
        """Return the first value of an integer tag, or what the specification says of its absence."""
        values = self.integers(tag)
        return values[0] if values else default

    def text(self, tag: Tag) -> str | None:
        """Return a text tag without blanks at its ends; None where it is absent or empty."""
        value = self.values.get(tag)
        return value.strip(" \0") or None if isinstance(value, str) else None


@dataclass(frozen=True, slots=True, kw_only=True)
class Directories:
    """What a TIFF file's directories say.

    Parameters
    ----------
    byte_order
        ``<`` or ``>``.
    size
        Bytes of the file.
    first
        The first directory.
    subs
        Its SubIFDs, in order.
    exif
        The EXIF directory; empty where there is none.
    following
        The directories that the first is followed by, of a TIFF that is no DNG.

    """

    byte_order: str
    size: int
    first: Directory
    subs: tuple[Directory, ...]
    exif: Directory
    following: tuple[Directory, ...] = ()

    def lookup(self, tag: Tag, image: Directory) -> Directory:
        """Return the directory that holds a tag: the image's own, the first, or EXIF, in this order."""
        for directory in (image, self.first):
            if tag in directory:
                return directory
        return self.exif


_LATEST: Final = deque[tuple[Directories, Mapping[int, bytes]]](maxlen=2)
"""The directories read last, and all the bytes of their files that they were made of."""


def read_directories(path: Path) -> Directories:
    """Return the directories of a TIFF or DNG file.

    Raises
    ------
    UnreadableFileError
        ``file-damaged`` where the directories cannot be parsed.
    OSError
        Where the file cannot be read at all.

    """
    from tifffile import TiffFile  # noqa: PLC0415 - loads when used

    try:
        with path.open("rb") as file:
            known = next((one for one, seen in tuple(_LATEST) if _holds(file, seen, size=one.size)), None)
            if known is not None:
                return known
            file.seek(0)
            watched = _Watched(file)
            with TiffFile(cast("BinaryIO", watched), _multifile=False) as tiff:
                found = _directories(tiff)
            _LATEST.append((found, watched.seen))
            return found
    except UnreadableFileError:
        raise
    except Exception as error:  # a damaged directory may fail anywhere inside tifffile, with any exception
        if isinstance(error, OSError) and error.errno != errno.EINVAL:  # which a position before the file's start gives
            raise
        raise UnreadableFileError(
            "file-damaged", f"the TIFF directories are damaged ({type(error).__name__}); copy the file again"
        ) from error


class _Watched:
    """A file that remembers what was read of it, by position."""

    def __init__(self, file: BinaryIO) -> None:
        self._file = file
        self.seen: dict[int, bytes] = {}

    def read(self, size: int = -1) -> bytes:
        """Read on."""
        at = self._file.tell()
        data = self._file.read(size)
        self.seen[at] = max(data, self.seen.get(at, b""), key=len)
        return data

    def seek(self, offset: int, whence: int = 0) -> int:
        """Go elsewhere."""
        return self._file.seek(offset, whence)

    def tell(self) -> int:
        """Return where the file stands."""
        return self._file.tell()


def _holds(file: BinaryIO, seen: Mapping[int, bytes], *, size: int) -> bool:
    """Tell whether a file has this size, and the same bytes in these places."""
    if file.seek(0, 2) != size:
        return False
    for at, data in seen.items():
        file.seek(at)
        if file.read(len(data)) != data:
            return False
    return True


def _directories(tiff: "TiffFile") -> Directories:
    from tifffile import TiffFrame  # noqa: PLC0415 - loads when used

    first = tiff.pages.first
    subs = [page for page in first.pages or () if not isinstance(page, TiffFrame)]
    for page in (first, *subs):
        _require_whole(tiff, page)
    plain = _directory(first)
    return Directories(
        byte_order=str(tiff.byteorder),
        size=int(tiff.filehandle.size),
        first=plain,
        subs=tuple(_directory(page) for page in subs),
        exif=_exif(first),
        following=() if Tag.DNG_VERSION in plain else _following(tiff, first),
    )


def _following(tiff: "TiffFile", first: "TiffPage") -> tuple[Directory, ...]:
    """Return the directories behind the first, as far as the chain leads without going in circles."""
    from tifffile import TiffPage  # noqa: PLC0415 - loads when used

    form, file = tiff.tiff, tiff.filehandle
    found: list[Directory] = []
    seen = {first.offset}
    at = first.offset
    while len(found) < _MOST_PAGES:
        file.seek(at)
        (count,) = struct.unpack(form.tagnoformat, file.read(form.tagnosize))
        file.seek(at + form.tagnosize + count * form.tagsize)
        (at,) = struct.unpack(form.offsetformat, file.read(form.offsetsize))
        if at == 0 or at in seen:
            break
        seen.add(at)
        file.seek(at)
        page = TiffPage(tiff, index=len(seen) - 1)
        _require_whole(tiff, page)
        found.append(_directory(page))
    return tuple(found)


def _directory(page: "TiffPage") -> Directory:
    values = {tag: _plain(page.tags[tag]) for tag in Tag if tag in page.tags and tag is not Tag.EXIF_IFD}
    return Directory(values=values)


def _require_whole(tiff: "TiffFile", page: "TiffPage") -> None:
    """Refuse a directory some of whose tags tifffile left out because their values lie beyond the end of the file."""
    form, file = tiff.tiff, tiff.filehandle
    file.seek(page.offset)
    (count,) = struct.unpack(form.tagnoformat, file.read(form.tagnosize))
    entries = file.read(count * form.tagsize)
    codes = {struct.unpack_from(f"{form.byteorder}H", entries, index * form.tagsize)[0] for index in range(count)}
    lost = [tag for tag in Tag if tag in codes and tag not in page.tags]
    if lost:
        names = ", ".join(tag.name for tag in lost)
        raise UnreadableFileError("file-damaged", f"tags are damaged or cut off ({names}); copy the file again")


def _exif(page: "TiffPage") -> Directory:
    raw = page.tags[Tag.EXIF_IFD].value if Tag.EXIF_IFD in page.tags else None
    if not isinstance(raw, dict):
        return Directory(values={})
    named = {tag: _numbers(raw[name], rational=tag in _RATIONAL_EXIF) for name, tag in _EXIF_NAMES if name in raw}
    return Directory(values=named)


def _plain(tag: "TiffTag") -> tuple[float, ...] | str:
    if isinstance(tag.value, str):
        return tag.value
    return _numbers(tag.value, rational=tag.dtype in _RATIONAL_TYPES)


def _numbers(value: object, *, rational: bool) -> tuple[float, ...]:
    if isinstance(value, bytes):
        return tuple(float(byte) for byte in value)
    flat = np.atleast_1d(np.asarray(value, dtype=np.float64)).ravel()
    if not rational:
        return tuple(flat.tolist())
    numerator, denominator = flat[0::2], flat[1::2]
    with np.errstate(divide="ignore", invalid="ignore"):
        return tuple(np.where(denominator == 0.0, np.nan, numerator / denominator).tolist())
