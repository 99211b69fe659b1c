"""How the pixels of a headerless file are stored, as somebody must say it (RESULTS 5).

Which function: `parse_format` for the text of ``--headerless``, `format_from` for keys and values of a preset or a
manifest, `checked` for a format put together elsewhere.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, fields
from typing import Final

from fullwell.errors import UsageError
from fullwell.raw.cfa import BAYER, MONO

BYTE: Final = "8"
WORD: Final = "16"
MIPI: Final = "packed-mipi"
LSB: Final = "packed-lsb"
MSB: Final = "packed-msb"
CONTAINERS: Final = (BYTE, WORD, MIPI, LSB, MSB)
BYTE_ORDERS: Final = ("little", "big")
MIPI_SAMPLES: Final = ((10, 4), (12, 2), (14, 4))
"""Bits of a sample as MIPI CSI-2 packs it, and how many samples make a group of whole bytes."""
EXAMPLE: Final = "width=1920,height=1080,bits=12,container=16,byte_order=little,cfa=BGGR"
_LARGEST_SIDE: Final = 1_000_000
_LARGEST_SKIP: Final = 2**40


@dataclass(frozen=True, slots=True, kw_only=True)
class HeaderlessFormat:
    """How the pixels of a headerless file are stored.

    Parameters
    ----------
    width, height
        [pixel].
    bits
        Bits of a sample, 1 to 16.
    container
        ``8``, ``16`` (one sample in one or two bytes, in their low bits), ``packed-mipi`` (RAW10, RAW12, RAW14 of MIPI
        CSI-2), ``packed-lsb`` (first sample in the lowest bits: GenICam's Mono12p), ``packed-msb`` (in the highest).
    byte_order
        ``little`` or ``big``, of 16-bit containers.
    offset
        Bytes before the first row.
    row_stride
        Bytes from the beginning of a row to the next; 0 where rows follow each other without padding.
    trailer
        Bytes after the last row.
    cfa
        Order at the first pixel, or ``mono``; None where it is not said.

    """

    width: int
    height: int
    bits: int
    container: str = WORD
    byte_order: str = "little"
    offset: int = 0
    row_stride: int = 0
    trailer: int = 0
    cfa: str | None = None

    def __str__(self) -> str:
        """Return the format as ``--headerless`` takes it, without what goes without saying."""
        shown = [f"width={self.width}", f"height={self.height}", f"bits={self.bits}", f"container={self.container}"]
        if self.container == WORD:
            shown.append(f"byte_order={self.byte_order}")
        shown += [f"{name}={value}" for name, value in _skips(self) if value]
        return ",".join([*shown, f"cfa={self.cfa}"] if self.cfa else shown)

    @property
    def row_bytes(self) -> int:
        """Bytes that the samples of one row take, without padding."""
        return packed_bytes(self.width, bits=self.bits, container=self.container)

    @property
    def stride(self) -> int:
        """Bytes from the beginning of a row to the next."""
        return self.row_stride or self.row_bytes

    @property
    def file_sizes(self) -> tuple[int, int]:
        """Bytes of a file, with and without the padding of its last row."""
        rows = self.stride * (self.height - 1)
        return (
            self.offset + rows + self.stride + self.trailer,
            self.offset + rows + self.row_bytes + self.trailer,
        )


def packed_bytes(samples: int, *, bits: int, container: str) -> int:
    """Return the bytes that the samples of a row take.

    Examples
    --------
    >>> [packed_bytes(1922, bits=10, container=one) for one in CONTAINERS]
    [1922, 3844, 2405, 2403, 2403]

    """
    if container == BYTE:
        return samples
    if container == WORD:
        return 2 * samples
    if container == MIPI:
        group = dict(MIPI_SAMPLES)[bits]
        return -(-samples // group) * (group * bits // 8)
    return (samples * bits + 7) // 8


def checked(stated: HeaderlessFormat, *, where: str) -> HeaderlessFormat:
    """Return a format that makes sense.

    Parameters
    ----------
    stated
        The format.
    where
        What sentences call the place it stands in, for example ``--headerless``.

    Raises
    ------
    UsageError
        Where it does not; the sentence says what is allowed.

    """
    for problem in _problems(stated):
        raise UsageError(f"{where}: {problem}.")
    return stated


def _problems(stated: HeaderlessFormat) -> Iterator[str]:
    """Say what is wrong, the first first: what comes later may not make sense after it."""
    if not (1 <= stated.width <= _LARGEST_SIDE and 1 <= stated.height <= _LARGEST_SIDE):
        yield f"{stated.width} x {stated.height} pixels cannot be right; give 1 to {_LARGEST_SIDE} a side"
    if stated.container not in CONTAINERS:
        yield f"container={stated.container} is not known; give one of {', '.join(CONTAINERS)}"
    if stated.byte_order not in BYTE_ORDERS:
        yield f"byte_order={stated.byte_order} is not known; give little or big"
    if stated.cfa is not None and stated.cfa not in (*BAYER, MONO):
        yield f"cfa={stated.cfa} is not known; give one of {', '.join((*BAYER, MONO))}"
    mipi = [bits for bits, _samples in MIPI_SAMPLES]
    most = 8 if stated.container == BYTE else 16
    if stated.container == MIPI and stated.bits not in mipi:
        yield f"bits={stated.bits} is not packed by MIPI this way; give {', '.join(map(str, mipi))}"
    if not 1 <= stated.bits <= most:
        yield f"bits={stated.bits} does not go with container={stated.container}; give 1 to {most}"
    for name, value in _skips(stated):
        if not 0 <= value <= _LARGEST_SKIP:
            yield f"{name}={value} cannot be right; give bytes, 0 or more"
    if 0 < stated.row_stride < stated.row_bytes:
        yield f"row_stride={stated.row_stride} is too short: a row takes {stated.row_bytes} bytes"


def _skips(stated: HeaderlessFormat) -> tuple[tuple[str, int], ...]:
    return (("offset", stated.offset), ("row_stride", stated.row_stride), ("trailer", stated.trailer))


def parse_format(text: str, *, where: str = "--headerless") -> HeaderlessFormat:
    """Return the format a text states, for example ``width=1920,height=1080,bits=12,container=16,cfa=BGGR``.

    Without ``container``, samples of at most 8 bits stand in one byte each and others in two; without ``bits``, they
    fill their container.

    Raises
    ------
    UsageError
        Where the text says something that is not known or not allowed, or lacks width or height.

    Examples
    --------
    >>> str(parse_format("width=768,height=512,bits=14,cfa=rggb"))
    'width=768,height=512,bits=14,container=16,byte_order=little,cfa=RGGB'

    """
    values: dict[str, str] = {}
    for item in filter(None, (part.strip() for part in text.split(","))):
        key, separator, value = (part.strip() for part in item.partition("="))
        if not separator or not value:
            raise UsageError(f"{where}: {item!r} is not of the form key=value; for example {EXAMPLE}.")
        if key.lower() in values:
            raise UsageError(f"{where}: {key} is given twice.")
        values[key.lower()] = value
    return format_from(values, where=where)


def format_from(values: Mapping[str, object], *, where: str) -> HeaderlessFormat:
    """Return the format that keys and values state; numbers may be written as text.

    Raises
    ------
    UsageError
        As `parse_format`.

    """
    known = [field.name for field in fields(HeaderlessFormat)]
    for key in values:
        if key not in known:
            raise UsageError(f"{where}: {key} is not known; the keys are {', '.join(known)}.")
    for key in ("width", "height"):
        if key not in values:
            raise UsageError(f"{where}: {key} is missing; for example {EXAMPLE}.")
    numbers = {
        key: _whole(values[key], key=key, where=where)
        for key in ("width", "height", "bits", "offset", "row_stride", "trailer")
        if key in values
    }
    texts = {key: str(values[key]).lower() for key in ("container", "byte_order") if key in values}
    container = texts.get("container", BYTE if numbers.get("bits", 16) <= 8 else WORD)
    if "bits" not in numbers and container not in {BYTE, WORD}:
        raise UsageError(f"{where}: bits is missing; packed samples do not say how many they have.")
    stated = HeaderlessFormat(
        width=numbers["width"],
        height=numbers["height"],
        bits=numbers.get("bits", 8 if container == BYTE else 16),
        container=container,
        byte_order=texts.get("byte_order", "little"),
        offset=numbers.get("offset", 0),
        row_stride=numbers.get("row_stride", 0),
        trailer=numbers.get("trailer", 0),
        cfa=_cfa(values.get("cfa")),
    )
    return checked(stated, where=where)


def _whole(value: object, *, key: str, where: str) -> int:
    try:
        return int("" if isinstance(value, bool) else str(value))
    except ValueError as error:
        raise UsageError(f"{where}: {key}={value} is not a whole number.") from error


def _cfa(value: object) -> str | None:
    if value is None:
        return None
    known = {name.casefold(): name for name in (*BAYER, MONO)}
    return known.get(str(value).casefold(), str(value))


def format_lines(stated: HeaderlessFormat) -> list[str]:
    """Return a format as the keys of a TOML table, without those that say nothing."""
    values = [(field.name, getattr(stated, field.name), field.default) for field in fields(stated)]
    return [
        f'{name} = "{value}"' if isinstance(value, str) else f"{name} = {value}"
        for name, value, default in values
        if value != default or name in {"container", "byte_order"}
    ]
