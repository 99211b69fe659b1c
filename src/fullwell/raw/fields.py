"""TIFF fields and directories as bytes: the small half of TIFF that writing needs."""

import struct
from collections.abc import Sequence
from dataclasses import dataclass
from enum import IntEnum
from fractions import Fraction
from typing import Final


class FieldType(IntEnum):
    """Types of TIFF 6.0 fields."""

    BYTE = 1
    ASCII = 2
    SHORT = 3
    LONG = 4
    RATIONAL = 5
    UNDEFINED = 7
    SRATIONAL = 10
    DOUBLE = 12


_FORMATS: Final = "BBHIIbBhiifd"
"""struct format of each type, counted from type 1 at index 0; rationals are pairs."""
_RATIONAL: Final = (FieldType.RATIONAL, FieldType.SRATIONAL)
_UINT32_MAX: Final = 2**32 - 1


@dataclass(frozen=True, slots=True, kw_only=True)
class Field:
    """One field of a directory; text is given as its bytes, with a zero at the end."""

    tag: int
    type: FieldType
    values: Sequence[float | Fraction]

    def encoded(self, byte_order: str) -> bytes:
        """Return the values as the file has them."""
        flat: list[float] = []
        for value in self.values:
            if self.type in _RATIONAL:
                flat += as_ratio(value, signed=self.type is FieldType.SRATIONAL)
            else:
                flat.append(float(value) if self.type is FieldType.DOUBLE else int(value))
        return struct.pack(f"{byte_order}{len(flat)}{_format(self.type)}", *flat)


def text(tag: int, value: str) -> Field:
    """Return a text field; what ASCII lacks is replaced."""
    return Field(tag=tag, type=FieldType.ASCII, values=tuple(value.encode("ascii", "replace") + b"\0"))


def as_ratio(value: float | Fraction, *, signed: bool) -> tuple[int, int]:
    """Return numerator and denominator: exact where 32 bits allow it, the nearest pair otherwise.

    Examples
    --------
    >>> as_ratio(0.002867, signed=False)
    (2867, 1000000)

    """
    limit = _UINT32_MAX // 2 if signed else _UINT32_MAX
    exact = value if isinstance(value, Fraction) else Fraction(repr(float(value)))
    if abs(exact) > limit or (exact < 0 and not signed):
        raise ValueError(f"{value} does not fit a TIFF rational")
    largest = limit if abs(exact) <= 1 else int(limit / abs(exact))
    ratio = exact.limit_denominator(max(largest, 1))
    return ratio.numerator, ratio.denominator


def directory_length(fields: Sequence[Field]) -> int:
    """Return the bytes of a directory with the values that follow it."""
    return len(encode_directory(fields, start=0, byte_order="<"))


def encode_directory(fields: Sequence[Field], *, start: int, byte_order: str) -> bytes:
    """Return a directory as bytes, its longer values directly behind it.

    Parameters
    ----------
    fields
        Any order; a directory is sorted by tag.
    start
        Position of the directory in the file, even.
    byte_order
        ``<`` or ``>``.

    """
    ordered = sorted(fields, key=lambda field: field.tag)
    table = struct.pack(f"{byte_order}H", len(ordered))
    behind = b""
    values_start = start + 2 + 12 * len(ordered) + 4
    for field in ordered:
        encoded = field.encoded(byte_order)
        count = len(encoded) // struct.calcsize(f"={_format(field.type)}")
        count = count // 2 if field.type in _RATIONAL else count
        table += struct.pack(f"{byte_order}HHI", field.tag, field.type, count)
        if len(encoded) <= 4:
            table += encoded.ljust(4, b"\0")
        else:
            table += struct.pack(f"{byte_order}I", values_start + len(behind))
            behind += encoded + b"\0" * (len(encoded) % 2)
    return table + struct.pack(f"{byte_order}I", 0) + behind


def _format(field_type: FieldType) -> str:
    return _FORMATS[field_type - 1]
