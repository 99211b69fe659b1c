"""Samples of a lossless JPEG scan (ITU-T T.81, annex H): a compiled decoder and its readable twin.

Written for speed and for safety: whatever the bytes are, nothing outside the arrays is read or written, and a scan
that ends early or holds an impossible code is reported. Decoders that trust their input end the process instead.
"""

from dataclasses import dataclass
from typing import Final

import numba as nb
import numpy as np
from numpy.typing import NDArray

_PEEK: Final = 12
"""Bits looked up at once: 16 KiB a table, which stays in the first-level cache."""
_UNRESOLVED: Final = 255

COMPLETE: Final = 0
ENDED_EARLY: Final = 1
IMPOSSIBLE_CODE: Final = 2


@dataclass(frozen=True, slots=True, kw_only=True)
class DecodingTables:
    """Huffman tables of the components, laid out for the compiled decoder.

    Parameters
    ----------
    fast
        Shape (components, 4096): what the next 12 bits begin with: difference << 16 | category << 8 | bits to take.
        Category 0 means that the difference is complete, 255 that the code is longer than 12 bits.
    first, counts, offsets
        Shape (components, 17): by code length, the first code, how many there are, where their categories begin.
    categories
        Shape (components, 256).

    """

    fast: NDArray[np.int32]
    first: NDArray[np.int32]
    counts: NDArray[np.int32]
    offsets: NDArray[np.int32]
    categories: NDArray[np.uint8]


def decoding_tables(tables: tuple[tuple[tuple[int, ...], tuple[int, ...]], ...]) -> DecodingTables:
    """Return the decoder's view of Huffman tables.

    Parameters
    ----------
    tables
        For each component: codes of each length 1 to 16, and the categories in the order of their codes (T.81, C.2).

    """
    components = len(tables)
    built = DecodingTables(
        fast=np.full((components, 1 << _PEEK), _UNRESOLVED << 8, dtype=np.int32),
        first=np.zeros((components, 17), dtype=np.int32),
        counts=np.zeros((components, 17), dtype=np.int32),
        offsets=np.zeros((components, 17), dtype=np.int32),
        categories=np.zeros((components, 256), dtype=np.uint8),
    )
    for component, (counts, categories) in enumerate(tables):
        built.categories[component, : len(categories)] = categories
        code = offset = 0
        for length, count in enumerate(counts, start=1):
            built.first[component, length] = code
            built.counts[component, length] = count
            built.offsets[component, length] = offset
            if length <= _PEEK:
                for index in range(count):
                    _fill(built.fast[component], code=code + index, length=length, category=categories[offset + index])
            offset += count
            code = (code + count) << 1
    return built


def _fill(fast: NDArray[np.int32], *, code: int, length: int, category: int) -> None:
    """Enter one code of at most 12 bits, with its difference where that fits into the 12 bits too."""
    spare = _PEEK - length
    start = code << spare
    if category == 0:
        fast[start : start + (1 << spare)] = length
    elif category <= spare:
        width = 1 << (spare - category)
        for bits in range(1 << category):
            difference = _extended(bits, category)
            fast[start + bits * width : start + (bits + 1) * width] = (difference << 16) | (length + category)
    else:
        fast[start : start + (1 << spare)] = (category << 8) | length


def _extended(bits: int, category: int) -> int:
    """Return the difference that ``category`` additional bits stand for (T.81, F.2.2.1 EXTEND).

    Examples
    --------
    >>> [_extended(bits, 2) for bits in range(4)]
    [-3, -2, 2, 3]

    """
    return bits if bits >= 1 << (category - 1) else bits - (1 << category) + 1


def decode_scan(
    data: NDArray[np.uint8],
    tables: DecodingTables,
    *,
    width: int,
    height: int,
    start_value: int,
    predictor: int,
    shift: int,
) -> tuple[int, NDArray[np.uint16]]:
    """Decode the samples of one scan.

    Parameters
    ----------
    data
        The coded bytes, from the first byte after the scan header.
    tables
        Huffman tables of the interleaved components.
    width, height
        Samples per line and component; lines.
    start_value
        Prediction of the very first sample: 2^(precision - shift - 1).
    predictor
        1 to 7 (T.81, table H.1).
    shift
        Point transform: samples are multiplied by 2^shift at the end.

    Returns
    -------
    outcome, samples
        ``COMPLETE``, ``ENDED_EARLY`` or ``IMPOSSIBLE_CODE``; and the samples as ``uint16`` of shape
        (height, width * components), components interleaved. Valid where the outcome is ``COMPLETE``.

    """
    samples = np.empty((height, width * tables.fast.shape[0]), dtype=np.uint16)
    outcome = _decode(
        data,
        tables.fast,
        tables.first,
        tables.counts,
        tables.offsets,
        tables.categories,
        start_value,
        predictor,
        samples,
    )
    if shift:
        samples <<= np.uint16(shift)
    return int(outcome), samples


@nb.njit(cache=True, nogil=True)
def _decode(
    data: NDArray[np.uint8],
    fast: NDArray[np.int32],
    first: NDArray[np.int32],
    counts: NDArray[np.int32],
    offsets: NDArray[np.int32],
    categories: NDArray[np.uint8],
    start_value: int,
    predictor: int,
    out: NDArray[np.uint16],
) -> int:
    lines, line_samples = out.shape
    components = fast.shape[0]
    buffer = np.uint64(0)
    held = padded = position = 0
    for line in range(lines):
        for sample in range(line_samples):
            component = sample % components if components > 1 else 0
            if held < 32:
                position, buffer, held, padded = _refill(data, position, buffer, held, padded)
            entry = fast[component, (buffer >> np.uint64(held - 12)) & np.uint64(0xFFF)]
            held -= entry & 0xFF
            category = (entry >> 8) & 0xFF
            difference = np.int64(entry >> 16)
            if category != 0:
                if category == 255:
                    window = np.int64((buffer >> np.uint64(held - 16)) & np.uint64(0xFFFF))
                    length, category = _long_code(window, component, first, counts, offsets, categories)
                    if length == 0:
                        return 2
                    held -= length
                difference, held = _difference(buffer, held, category)
            if line > 0 and sample >= components and predictor == 1:
                predicted = np.int64(out[line, sample - components])
            else:
                predicted = _prediction(out, line, sample, components, predictor, start_value)
            out[line, sample] = np.uint16((predicted + difference) & 0xFFFF)
        if held < padded:
            return 1
    return 0


@nb.njit(cache=True, nogil=True)
def _refill(
    data: NDArray[np.uint8], position: int, buffer: np.uint64, held: int, padded: int
) -> tuple[int, np.uint64, int, int]:
    """Fill the buffer to at least 49 bits; a zero stuffed behind 0xFF is skipped, a marker is followed by zeros."""
    size = data.size
    while held <= 48:
        byte = np.uint64(0)
        if position < size and (data[position] != 0xFF or (position + 1 < size and data[position + 1] == 0)):
            byte = np.uint64(data[position])
            position += 2 if data[position] == 0xFF else 1
        else:
            padded += 8
        buffer = (buffer << np.uint64(8)) | byte
        held += 8
    return position, buffer, held, padded


@nb.njit(cache=True, nogil=True)
def _long_code(
    window: int,
    component: int,
    first: NDArray[np.int32],
    counts: NDArray[np.int32],
    offsets: NDArray[np.int32],
    categories: NDArray[np.uint8],
) -> tuple[int, int]:
    """Return length and category of a code longer than 12 bits at the head of 16; length 0 where there is none."""
    for length in range(13, 17):
        index = (window >> (16 - length)) - first[component, length]
        if 0 <= index < counts[component, length]:
            return length, np.int64(categories[component, (offsets[component, length] + index) & 255])
    return 0, 0


@nb.njit(cache=True, nogil=True)
def _difference(buffer: np.uint64, held: int, category: int) -> tuple[int, int]:
    """Return the difference whose additional bits come next, and the bits then left; category 16 has none (H.1.2.2)."""
    if category == 16:
        return 32768, held
    if category == 0:
        return 0, held
    held -= category
    bits = np.int64((buffer >> np.uint64(held)) & np.uint64((1 << category) - 1))
    return (bits if bits >= 1 << (category - 1) else bits - (1 << category) + 1), held


@nb.njit(cache=True, nogil=True)
def _prediction(
    out: NDArray[np.uint16], line: int, sample: int, components: int, predictor: int, start_value: int
) -> int:
    """Return the prediction from left, above and corner (T.81, H.1.2.1 and table H.1)."""
    if line == 0:
        return start_value if sample < components else np.int64(out[0, sample - components])
    above = np.int64(out[line - 1, sample])
    if sample < components or predictor == 2:
        return above
    left = np.int64(out[line, sample - components])
    corner = np.int64(out[line - 1, sample - components])
    if predictor == 1:
        return left
    if predictor == 3:
        return corner
    if predictor == 4:
        return left + above - corner
    if predictor == 5:
        return left + ((above - corner) >> 1)
    if predictor == 6:
        return above + ((left - corner) >> 1)
    return (left + above) >> 1
