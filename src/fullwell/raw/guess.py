"""How a headerless file may be stored, found from its size, from how its rows repeat, and from its pixels.

A geometry is as good as neighbours foretell each other under it: read the right way, a pixel is much like those of
its colour to the left and above, and few bits of it remain to be told. Every other width, packing or byte order
leaves more bits per byte of the file. Where a frame has no content to tell by, such as a dark one, sizes that many
sensors have and the file's own name decide, and the reason says so.
"""

import itertools
import math
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

from fullwell.raw.headerless import unpacked
from fullwell.raw.headerless_fit import COMMON_SIZES, STORED_AS
from fullwell.raw.headerless_format import BYTE, WORD, HeaderlessFormat, packed_bytes
from fullwell.raw.name_hints import NameHints, hints_in
from fullwell.raw.periodicity import RowPeriod, row_periods
from fullwell.raw.predictability import Predictability, bits_to_tell, greens_of

STRONG_PERIOD: Final = 15.0
"""Row periods that stand out this far are there for certain [standard deviations of all lags]."""
_CLEARLY: Final = 0.25
"""Fewer bits left for each byte of a file by so many are no chance [bit]."""
_LARGEST_HEADER: Final = 1 << 16
_LONGEST_PADDING: Final = 256
_TYPICAL_SHAPE: Final = 1.4
_SHAPES: Final = (0.3, 6.0)
_NARROWEST: Final = 16


@dataclass(frozen=True, slots=True, kw_only=True)
class Guess:
    """A way to read a file, and why it is likely.

    Parameters
    ----------
    stated
        The geometry. Its CFA is known only where the name says it, or where all pixels are alike (``mono``).
    bits_left
        What neighbours of the same colour leave to be told of a pixel [bit].
    score
        Bits left for each byte of the file, and what speaks for or against the geometry besides; smaller is better.
    reason
        A sentence for people.

    """

    stated: HeaderlessFormat
    bits_left: float
    score: float
    reason: str


def guess_formats(data: bytes | bytearray | memoryview, *, name: str = "", most: int = 8) -> tuple[Guess, ...]:
    """Return the likeliest ways to read a headerless file, the best first.

    Parameters
    ----------
    data
        The whole file.
    name
        The file's name: a hint, used only among what the content allows.
    most
        How many guesses to return at most.

    Returns
    -------
    tuple of Guess
        Empty where the file is too small to hold a picture.

    """
    view = memoryview(data).cast("B")
    stored = np.frombuffer(view, dtype=np.uint8)
    periods, hints = row_periods(stored), hints_in(name)
    candidates = _candidates(stored, periods=periods, hints=hints)
    return _best(candidates, view, periods=periods, hints=hints, most=most)


def _best(
    candidates: Iterable[HeaderlessFormat],
    view: memoryview,
    *,
    periods: Iterable[RowPeriod],
    hints: NameHints,
    most: int,
) -> tuple[Guess, ...]:
    stored = np.frombuffer(view, dtype=np.uint8)
    found: list[tuple[float, HeaderlessFormat, Predictability]] = []
    for stated in dict.fromkeys(candidates):
        told = bits_to_tell(stated, view)
        per_byte = told.bits * stated.width * stated.height / stored.size + _unexplained(stated, stored)
        found.append((per_byte + _against(stated, periods=periods, hints=hints), stated, told))
    ranked = sorted(found, key=lambda one: (one[0], str(one[1])))
    chosen = _different(ranked, most=most)
    return tuple(_told(score, stated, told, view=view, periods=periods, hints=hints) for score, stated, told in chosen)


def better_geometry(stated: HeaderlessFormat, data: bytes | bytearray | memoryview) -> Guess | None:
    """Return the geometry that the content speaks for, where it speaks clearly against the stated one.

    Rows that repeat after another number of bytes, or that are foretold better in another packing or byte order, give
    rise to doubt; a frame without content does not.
    """
    if stated.width < _NARROWEST or stated.height < 2:
        return None
    view = memoryview(data).cast("B")
    stored = np.frombuffer(view, dtype=np.uint8)
    periods, hints = row_periods(stored), NameHints()
    if any(period.stride in {stated.stride, 2 * stated.stride} for period in periods):
        candidates = _of_same_rows(stated)
    elif any(period.strength >= STRONG_PERIOD for period in periods):
        candidates = _candidates(stored, periods=periods, hints=hints)
    else:
        alike = _of_length(stored.size, container=stated.container, bits=stated.bits)
        candidates = itertools.chain(_of_same_rows(stated), alike)
    best = next(iter(_best(candidates, view, periods=periods, hints=hints, most=1)), None)
    return best if best is not None and _per_byte(best.stated, view) < _per_byte(stated, view) - _CLEARLY else None


def _per_byte(stated: HeaderlessFormat, view: memoryview) -> float:
    """Return what neighbours leave to be told, for each byte of the file [bit]."""
    return bits_to_tell(stated, view).bits * stated.width * stated.height / len(view)


def _of_same_rows(stated: HeaderlessFormat) -> Iterator[HeaderlessFormat]:
    """Return the other ways to read rows of the same length."""
    for container, bits in STORED_AS:
        width = stated.stride * 8 // (16 if container == WORD else bits)
        if packed_bytes(width, bits=bits, container=container) == stated.stride:
            same = replace(stated, width=width, bits=bits, container=container, byte_order="little", row_stride=0)
            yield from (other for other in _orders(same) if other != stated)


def _candidates(
    stored: NDArray[np.uint8], *, periods: Iterable[RowPeriod], hints: NameHints
) -> Iterator[HeaderlessFormat]:
    """Return the geometries worth a look: rows that repeat, sizes that are common, sizes that the length allows."""
    size = stored.size
    strides = [stride for period in periods for stride in (period.stride, period.stride // 2) if stride]
    for container, bits in STORED_AS:
        for stride in dict.fromkeys(strides):
            yield from _of_stride(stored, stride=stride, container=container, bits=bits)
        turned = [(height, width) for width, height in COMMON_SIZES]
        for width, height in (*((hints.size,) if hints.size else ()), *COMMON_SIZES, *turned):
            yield from _of_size(size, width=width, height=height, container=container, bits=bits)
        if not any(period.strength >= STRONG_PERIOD for period in periods):
            yield from _of_length(size, container=container, bits=bits)


def _of_stride(stored: NDArray[np.uint8], *, stride: int, container: str, bits: int) -> Iterator[HeaderlessFormat]:
    """Return geometries whose rows take so many bytes, those that pad them to it included."""
    height, rest = divmod(stored.size, stride)
    if height < 2 or rest > _LARGEST_HEADER:
        return
    padding = _constant_tail(stored[: height * stride].reshape(height, stride))
    for width in _widths(stride, padding=padding, container=container, bits=bits):
        used = packed_bytes(width, bits=bits, container=container)
        for offset, trailer in dict.fromkeys([(rest, 0), (0, rest)]):
            yield from _orders(
                HeaderlessFormat(
                    width=width,
                    height=height,
                    bits=bits,
                    container=container,
                    offset=offset,
                    trailer=trailer,
                    row_stride=0 if used == stride else stride,
                )
            )


def _widths(stride: int, *, padding: int, container: str, bits: int) -> Iterator[int]:
    per_row = stride * 8 // (16 if container == WORD else bits)
    if packed_bytes(per_row, bits=bits, container=container) == stride:
        yield per_row
    shorter = (stride - padding) * 8 // (16 if container == WORD else bits) // 4 * 4
    if padding and shorter >= _NARROWEST and packed_bytes(shorter, bits=bits, container=container) <= stride:
        yield shorter
    for width in dict.fromkeys(side for sides in COMMON_SIZES for side in sides):
        left = stride - packed_bytes(width, bits=bits, container=container)
        if 0 < left <= _LONGEST_PADDING and stride % 4 == 0 and left < 64 + padding:
            yield width


def _constant_tail(rows: NDArray[np.uint8]) -> int:
    """Return how many bytes at the end of every row are the same in all rows [byte]."""
    tail = rows[:, -_LONGEST_PADDING:]
    varying = np.flatnonzero(tail.min(axis=0) != tail.max(axis=0))
    return tail.shape[1] - 1 - int(varying[-1]) if varying.size else 0


def _unexplained(stated: HeaderlessFormat, stored: NDArray[np.uint8]) -> float:
    """Return what bytes cost that a geometry calls no pixels, each 8 bits unless it pads all rows alike [bit per byte].

    A geometry that throws away what is hard to foretell must not look better for it.
    """
    idle = stated.stride - stated.row_bytes
    if idle:
        rows = stored[stated.offset : stated.offset + stated.stride * stated.height].reshape(-1, stated.stride)
        tail = rows[:, -idle:]
        idle = int(np.count_nonzero(tail.min(axis=0) != tail.max(axis=0)))
    return 8.0 * (idle * stated.height + stated.offset + stated.trailer) / stored.size


def _of_size(size: int, *, width: int, height: int, container: str, bits: int) -> Iterator[HeaderlessFormat]:
    stated = HeaderlessFormat(width=width, height=height, bits=bits, container=container)
    if size == stated.file_sizes[0]:
        yield from _orders(stated)


def _of_length(size: int, *, container: str, bits: int) -> Iterator[HeaderlessFormat]:
    """Return the shapes whose pixels take exactly the file."""
    per_pixel = 16 if container == WORD else bits
    pixels, rest = divmod(size * 8, per_pixel)
    if rest:
        return
    for height in range(2, math.isqrt(round(pixels / _SHAPES[0])) + 1, 2):
        width, rest = divmod(pixels, height)
        if rest == 0 and width % 2 == 0 and width >= _NARROWEST and _SHAPES[0] <= width / height <= _SHAPES[1]:
            yield from _of_size(size, width=width, height=height, container=container, bits=bits)


def _orders(stated: HeaderlessFormat) -> Iterator[HeaderlessFormat]:
    if stated.width < _NARROWEST or stated.height < 2:
        return
    yield stated
    if stated.container == WORD:
        yield replace(stated, byte_order="big")


def _against(stated: HeaderlessFormat, *, periods: Iterable[RowPeriod], hints: NameHints) -> float:
    """Return what speaks against a geometry besides its pixels [bit per byte]; content outweighs all of it."""
    shape = abs(math.log(stated.width / stated.height / _TYPICAL_SHAPE))
    against = 0.05 * max(0.0, shape - 0.4)
    against += 0.1 * (stated.width % 2) + 0.05 * (stated.height % 2)
    against += 0.02 * (not _is_common(stated)) + 0.02 * bool(stated.offset or stated.trailer)
    against += 0.01 * bool(stated.offset) + 0.01 * bool(stated.row_stride)
    against -= 0.02 * min(_strength(stated, periods) / STRONG_PERIOD, 1.0)
    if hints.size is not None:
        against -= 0.1 * ((stated.width, stated.height) == hints.size)
    if hints.bits is not None:
        against -= 0.02 * (hints.bits <= 8 if stated.container == BYTE else stated.bits in {16, hints.bits})
    return against


def _is_common(stated: HeaderlessFormat) -> bool:
    size = (stated.width, stated.height)
    return size in COMMON_SIZES or size[::-1] in COMMON_SIZES


def _strength(stated: HeaderlessFormat, periods: Iterable[RowPeriod]) -> float:
    """Return how far a geometry's rows, or pairs of them, stand out [standard deviations of all lags]."""
    wanted = {stated.stride, 2 * stated.stride}
    return max((period.strength for period in periods if period.stride in wanted), default=0.0)


def _different(
    ranked: Iterable[tuple[float, HeaderlessFormat, Predictability]], *, most: int
) -> list[tuple[float, HeaderlessFormat, Predictability]]:
    """Return the best, each length of rows in each packing once."""
    chosen: dict[tuple[int, str, int, str], tuple[float, HeaderlessFormat, Predictability]] = {}
    for one in ranked:
        stated = one[1]
        key = (stated.stride, stated.container, stated.bits, stated.byte_order)
        chosen.setdefault(key, one)
    return list(chosen.values())[:most]


def _told(
    score: float,
    stated: HeaderlessFormat,
    told: Predictability,
    *,
    view: memoryview,
    periods: Iterable[RowPeriod],
    hints: NameHints,
) -> Guess:
    """Return a guess with the bits that its codes need and the reasons that speak for it."""
    mosaic = unpacked(stated, view)
    bits, reasons = _bits(stated, mosaic, hints=hints)
    reasons.insert(0, f"neighbours leave {told.bits:.2f} bits of a pixel to be told")
    strength = _strength(stated, periods)
    if strength >= STRONG_PERIOD / 2:
        reasons.append(f"rows repeat every {stated.stride} bytes ({strength:.0f} sigma)")
    if hints.size == (stated.width, stated.height):
        reasons.append("the name says this size")
    elif _is_common(stated):
        reasons.append("many sensors have this size")
    if stated.row_stride:
        reasons.append(f"{stated.row_stride - stated.row_bytes} bytes pad each row")
    cfa, colours = _colours(mosaic, told=told, hints=hints)
    final = replace(stated, bits=bits, cfa=cfa)
    return Guess(stated=final, bits_left=told.bits, score=score, reason="; ".join([*reasons, *colours]))


def _bits(stated: HeaderlessFormat, mosaic: NDArray[np.uint16], *, hints: NameHints) -> tuple[int, list[str]]:
    if stated.container != WORD:
        return stated.bits, []
    highest = int(mosaic.max())
    needed = max(highest.bit_length(), 1)
    bits = next(usual for usual in (10, 12, 14, 16) if usual >= needed)
    if hints.bits is not None and needed <= hints.bits <= 16:
        return hints.bits, [f"the name says {hints.bits} bits"]
    together = int(np.bitwise_or.reduce(mosaic, axis=None))
    unused = (together & -together).bit_length() - 1 if together else 0
    if bits == 16 and unused:
        return bits, [f"every code is a multiple of {2**unused}: {16 - unused} bits in the high end of a word"]
    return bits, [f"the highest code is {highest}, so bits may be more than {bits}"]


def _colours(mosaic: NDArray[np.uint16], *, told: Predictability, hints: NameHints) -> tuple[str | None, list[str]]:
    """Return the CFA as far as anything tells it."""
    if hints.cfa is not None:
        return hints.cfa, ["the name says the CFA"]
    if told.alike:
        return "mono", ["neighbours of every kind are alike: mono"]
    pair = greens_of(mosaic)
    return None, [f"the CFA is {pair[0]} or {pair[1]}" if pair else "the CFA is for you to say"]
