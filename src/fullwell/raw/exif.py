"""The tags of makers' raw files: the door to exifread, which walks their directories and some of their maker notes.

exifread is pure Python, under a licence as free as ours, and kept up; the bindings to exiv2 are under the GPL. It is
run where decoders run (`fullwell.raw.isolation`) and its reads are counted, since a hostile count of values would keep
it busy for hours.
"""

import io
import logging
import math
import struct
from collections.abc import Iterator, Mapping
from contextlib import suppress
from dataclasses import dataclass
from typing import Any, Final

from fullwell.raw.embedded import exif_blocks

logging.getLogger("exifread").addHandler(logging.NullHandler())
logging.getLogger("exifread").propagate = False

_MOST_READS: Final = 300_000
_MOST_BYTES: Final = 200_000_000
_MOST_VALUES: Final = 64
COLOR_DATA: Final = 0x4001
"""Canon's table of levels and white balances: longer than exifread reads values, and the one long table of use."""
_MOST_COLOR_DATA: Final = 8192
CAMERA_TEMPERATURE: Final = 0
"""Stands for what exifread makes of Canon's ShotInfo: text such as ``31 C``."""
_CANON_TEMPERATURE: Final = "MakerNote CameraTemperature"

Values = tuple[float, ...] | str


@dataclass(frozen=True, slots=True, kw_only=True)
class ExifTags:
    """The tags of a file, in its order; empty where none can be read.

    Parameters
    ----------
    entries
        The directory a tag stands in as exifread calls it (``Image``, ``EXIF``, ``EXIF SubIFD0``, ``MakerNote``), its
        number, and numbers (rationals divided) or text.

    """

    entries: tuple[tuple[str, int, Values], ...]

    def find(self, number: int, *directories: str) -> Values | None:
        """Return the values of a tag in the first directory that has it; a name stands for those that begin so."""
        for directory in directories:
            for place, code, values in self.entries:
                if code == number and place.startswith(directory) and values:
                    return values
        return None

    def numbers(self, number: int, *directories: str) -> tuple[float, ...]:
        """Return the values of a tag of numbers; empty where it is absent or text."""
        values = self.find(number, *directories)
        return () if values is None or isinstance(values, str) else values

    def number(self, number: int, *directories: str) -> float | None:
        """Return the first value of a tag of numbers; None where it is absent or not finite."""
        values = self.numbers(number, *directories)
        return values[0] if values and math.isfinite(values[0]) else None

    def text(self, number: int, *directories: str) -> str | None:
        """Return a text tag without blanks at its ends; None where it is absent or empty."""
        value = self.find(number, *directories)
        return value.strip(" \0") or None if isinstance(value, str) else None


class _Counted(io.BytesIO):
    """Bytes that end where somebody has read more of them than any honest file asks for."""

    reads = 0
    taken = 0

    def read(self, size: int | None = -1, /) -> bytes:
        self.reads += 1
        found = super().read(size)
        self.taken += len(found)
        if self.reads > _MOST_READS or self.taken > _MOST_BYTES:
            raise EOFError("too many tags")
        return found


def read_exif(data: bytes) -> list[tuple[str, int, Values]]:
    """Return every short tag of a maker's raw file as directory, number and values; what is damaged is left out."""
    found: list[tuple[str, int, Values]] = []
    for block, renamed in exif_blocks(data):
        with suppress(Exception):  # whatever stops exifread, what it found before counts
            found += _tags(block, renamed)
    return found


def _tags(block: bytes, renamed: str | None) -> Iterator[tuple[str, int, Values]]:
    from exifread import process_file  # noqa: PLC0415 - loads when used

    tags: Mapping[str, Any] = process_file(_Counted(block), details=True, extract_thumbnail=False)
    order = ">" if block[:1] == b"M" else "<"
    for name, tag in tags.items():
        number, values = getattr(tag, "tag", 0), getattr(tag, "values", None)
        if name == _CANON_TEMPERATURE:
            yield "MakerNote", CAMERA_TEMPERATURE, str(tag)
        if not number or values is None:
            continue
        directory = renamed or (name.partition(" Tag ")[0] if " Tag 0x" in name else name.rpartition(" ")[0])
        if number == COLOR_DATA and directory == "MakerNote":
            values = _words(block, order, tag)
        plain = _plain(values)
        if plain and (isinstance(plain, str) or len(plain) <= _MOST_VALUES or number == COLOR_DATA):
            yield directory, number, plain


def _words(block: bytes, order: str, tag: Any) -> list[int]:  # noqa: ANN401 - exifread's own type
    """Return a table of 16-bit numbers, where exifread found it."""
    count = min(int(tag.field_length) // 2, _MOST_COLOR_DATA)
    return list(struct.unpack_from(f"{order}{count}H", block, int(tag.field_offset)))


def _plain(values: object) -> Values:
    if isinstance(values, (str, bytes)):
        return values if isinstance(values, str) else values.decode("ascii", "replace")
    numbers: list[float] = []
    for value in values if isinstance(values, (list, tuple)) else []:
        numbers += value if isinstance(value, tuple) else [_ratio(value)]
    return tuple(numbers)


def _ratio(value: Any) -> float:  # noqa: ANN401 - exifread's own type
    try:
        return float(value)
    except (TypeError, ValueError, ZeroDivisionError):
        return math.nan
