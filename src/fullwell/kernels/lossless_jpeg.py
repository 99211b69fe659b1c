"""Samples of a lossless JPEG scan (ITU-T T.81, annex H): a compiled decoder and its readable twin.

Which function: `decode_scan` to decode, `decode_scan_plain` to understand and to test.

Written for speed and for safety: whatever the bytes are, nothing outside the arrays is read or written, and a scan
that ends early or holds an impossible code is reported. Decoders that trust their input end the process instead.
"""

from typing import Final

import numba as nb
import numpy as np
from numpy.typing import NDArray

_PEEK: Final = 12
"""Bits looked up at once: 16 KiB a table, which stays in the first-level cache."""
_UNRESOLVED: Final = 255
_FIRST: Final = 1 << _PEEK
_COUNT: Final = _FIRST + 17
_OFFSET: Final = _COUNT + 17
_CATEGORY: Final = _OFFSET + 17
_TABLE_LENGTH: Final = _CATEGORY + 256

COMPLETE: Final = 0
ENDED_EARLY: Final = 1
IMPOSSIBLE_CODE: Final = 2


def decoding_tables(tables: tuple[tuple[tuple[int, ...], tuple[int, ...]], ...]) -> NDArray[np.int32]:
    """Return the decoder's view of Huffman tables.

    Parameters
    ----------
    tables
        For each component: codes of each length 1 to 16, and the categories in the order of their codes (T.81, C.2).
        Categories are at most 16, and no more codes than their lengths allow.

    Returns
    -------
    ndarray
        One row per component. First, for every value the next 12 bits can have, ``difference << 16 | category << 8 |
        bits to take``: category 0 means that the difference is complete, 255 that the code is longer than 12 bits.
        Then, by code length 0 to 16, the first code, the number of codes, and where their categories begin; then the
        categories. One array, because handing over several costs more than the decoding.

    """
    built = np.zeros((len(tables), _TABLE_LENGTH), dtype=np.int32)
    for row, (counts, categories) in zip(built, tables, strict=True):
        row[:_FIRST] = _UNRESOLVED << 8
        row[_COUNT + 1 : _OFFSET] = counts
        row[_CATEGORY : _CATEGORY + len(categories)] = categories
        _fill(row)
    return built


@nb.njit(cache=True, nogil=True)
def _fill(table: NDArray[np.int32]) -> None:
    code = 0
    offset = 0
    for length in range(1, 17):
        table[_FIRST + length] = code
        table[_OFFSET + length] = offset
        count = table[_COUNT + length]
        if length <= _PEEK:
            for index in range(count):
                _enter(table, code + index, length, table[_CATEGORY + offset + index])
        offset += count
        code = (code + count) << 1


@nb.njit(cache=True, nogil=True)
def _enter(table: NDArray[np.int32], code: int, length: int, category: np.int32) -> None:
    """Enter one code of at most 12 bits, with its difference where that fits into the 12 bits too."""
    spare = _PEEK - length
    start = code << spare
    if 0 < category <= spare:
        width = 1 << (spare - category)
        for bits in range(1 << category):
            difference = bits if bits >= 1 << (category - 1) else bits - (1 << category) + 1
            table[start + bits * width : start + (bits + 1) * width] = (difference << 16) | (length + category)
    else:
        table[start : start + (1 << spare)] = (category << 8) | length


def decode_scan(
    data: NDArray[np.uint8],
    tables: NDArray[np.int32],
    *,
    width: int,
    height: int,
    start_value: int,
    predictor: int,
    shift: int,
    out: NDArray[np.uint16] | None = None,
) -> tuple[int, NDArray[np.uint16]]:
    """Decode the samples of one scan.

    Parameters
    ----------
    data
        The coded bytes, from the first byte after the scan header.
    tables
        `decoding_tables` of the interleaved components.
    width, height
        Samples per line and component; lines.
    start_value
        Prediction of the very first sample: 2^(precision - shift - 1).
    predictor
        1 to 7 (T.81, table H.1).
    shift
        Point transform: samples are multiplied by 2^shift at the end.
    out
        Memory for as many samples, in row order; None takes new memory.

    Returns
    -------
    outcome, samples
        ``COMPLETE``, ``ENDED_EARLY`` or ``IMPOSSIBLE_CODE``; and the samples as ``uint16`` of shape
        (height, width * components), components interleaved. Valid where the outcome is ``COMPLETE``.

    """
    shape = (height, width * len(tables))
    samples = np.empty(shape, dtype=np.uint16) if out is None else out.reshape(shape)
    outcome = _decode(data, tables, (start_value, predictor, 0), new_state(), samples)
    if shift:
        samples <<= np.uint16(shift)
    return int(outcome), samples


def new_state() -> NDArray[np.int64]:
    """Return where a decoder stands that has not begun: the next byte, bits in its buffer, padded ones, the buffer."""
    return np.zeros(4, np.int64)


def decode_lines(
    data: NDArray[np.uint8],
    tables: NDArray[np.int32],
    state: NDArray[np.int64],
    out: NDArray[np.uint16],
    *,
    start_value: int,
    predictor: int,
    above: bool,
) -> int:
    """Decode the next lines of a scan, without its point transform.

    Parameters
    ----------
    data, tables, start_value, predictor
        As `decode_scan`.
    state
        Where the decoder stands; moved on.
    out
        The lines, components interleaved, shape (lines, samples of a line).
    above
        Whether the first line is the one above, which is known; only the very first lines have none.

    Returns
    -------
    int
        ``COMPLETE``, ``ENDED_EARLY`` or ``IMPOSSIBLE_CODE``.

    """
    return int(_decode(data, tables, (start_value, predictor, int(above)), state, out))


def decode_scan_plain(
    data: bytes,
    tables: tuple[tuple[tuple[int, ...], tuple[int, ...]], ...],
    *,
    width: int,
    height: int,
    start_value: int,
    predictor: int,
    shift: int,
) -> NDArray[np.uint16]:
    """Do what `decode_scan` does, as annex H of T.81 tells it, one sample at a time; for whole scans only."""
    coded = data.replace(b"\xff\x00", b"\xff")
    bits = "".join(f"{byte:08b}" for byte in coded)
    codes = [_codes(counts, categories) for counts, categories in tables]
    samples = np.zeros((height, width, len(tables)), dtype=np.int64)
    position = 0
    for line, column, component in np.ndindex(*samples.shape):
        length = next(n for n in range(1, 17) if bits[position : position + n] in codes[component])
        category = codes[component][bits[position : position + length]]
        position += length
        additional = bits[position : position + category] if category < 16 else ""
        position += len(additional)
        difference = _extended(additional) if category < 16 else 32768
        seen = samples[:, :, component]
        if line == 0:
            predicted = start_value if column == 0 else seen[0, column - 1]
        elif column == 0:
            predicted = seen[line - 1, 0]
        else:
            left, above, corner = seen[line, column - 1], seen[line - 1, column], seen[line - 1, column - 1]
            predicted = (
                left,
                above,
                corner,
                left + above - corner,
                left + ((above - corner) >> 1),
                above + ((left - corner) >> 1),
                (left + above) >> 1,
            )[predictor - 1]
        samples[line, column, component] = (predicted + difference) % 65536
    return (samples << shift).astype(np.uint16).reshape(height, -1)


def _codes(counts: tuple[int, ...], categories: tuple[int, ...]) -> dict[str, int]:
    """Return the category of each code, codes written as text (T.81, C.2)."""
    remaining = iter(categories)
    codes: dict[str, int] = {}
    code = 0
    for length, count in enumerate(counts, start=1):
        for _ in range(count):
            codes[f"{code:0{length}b}"] = next(remaining)
            code += 1
        code <<= 1
    return codes


def _extended(bits: str) -> int:
    """Return the difference that additional bits stand for (T.81, F.2.2.1 EXTEND).

    Examples
    --------
    >>> [_extended(bits) for bits in ("", "00", "01", "10", "11")]
    [0, -3, -2, 2, 3]

    """
    if not bits:
        return 0
    return int(bits, 2) if bits[0] == "1" else int(bits, 2) - (1 << len(bits)) + 1


@nb.njit(cache=True, nogil=True)
def _decode(
    data: NDArray[np.uint8],
    tables: NDArray[np.int32],
    prediction: tuple[int, int, int],
    state: NDArray[np.int64],
    out: NDArray[np.uint16],
) -> int:
    lines, line_samples = out.shape
    components = tables.shape[0]
    start_value, predictor, first = prediction
    position, held, padded = state[0], state[1], state[2]
    buffer = np.uint64(state[3])
    for line in range(first, lines):
        for sample in range(line_samples):
            if held < 32:
                position, buffer, held, padded = _refill(data, position, buffer, held, padded)
            component = sample % components if components > 1 else 0
            entry = np.int64(tables[component, (buffer >> np.uint64(held - _PEEK)) & np.uint64(_FIRST - 1)])
            held -= entry & 0xFF
            difference = entry >> 16
            if entry & 0xFF00:
                difference, held = _difference(buffer, held, component, tables, (entry >> 8) & 0xFF)
                if held < 0:
                    return IMPOSSIBLE_CODE
            if line == 0:
                predicted = np.int64(start_value) if sample < components else np.int64(out[0, sample - components])
            else:
                predicted = _prediction(out, line, sample, components, predictor)
            out[line, sample] = (predicted + difference) & 0xFFFF
        if held < padded:
            return ENDED_EARLY
    state[0], state[1], state[2], state[3] = position, held, padded, np.int64(buffer)
    return COMPLETE


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
def _difference(
    buffer: np.uint64, held: int, component: int, tables: NDArray[np.int32], category: np.int64
) -> tuple[np.int64, int]:
    """Return the difference of a category and the bits then left in the buffer; -1 where the code is impossible."""
    if category == _UNRESOLVED:
        length, category = _long_code(np.int64((buffer >> np.uint64(held - 16)) & np.uint64(0xFFFF)), component, tables)
        if length == 0:
            return np.int64(0), -1
        held -= length
    if category == 0:
        return np.int64(0), held
    if category == 16:  # the one difference without additional bits (T.81, H.1.2.2)
        return np.int64(32768), held
    held -= int(category)
    bits = np.int64((buffer >> np.uint64(held)) & np.uint64((1 << category) - 1))
    return (bits if bits >= 1 << (category - 1) else bits - (1 << category) + 1), held


@nb.njit(cache=True, nogil=True)
def _long_code(window: np.int64, component: int, tables: NDArray[np.int32]) -> tuple[int, np.int64]:
    """Return length and category of a code longer than 12 bits at the head of 16; length 0 where there is none."""
    for length in range(_PEEK + 1, 17):
        index = (window >> (16 - length)) - np.int64(tables[component, _FIRST + length])
        if 0 <= index < tables[component, _COUNT + length]:
            return length, np.int64(tables[component, _CATEGORY + tables[component, _OFFSET + length] + index])
    return 0, np.int64(0)


@nb.njit(cache=True, nogil=True)
def _prediction(out: NDArray[np.uint16], line: int, sample: int, components: int, predictor: int) -> np.int64:
    """Return the prediction from left, above and corner, below the first line (T.81, table H.1)."""
    above = np.int64(out[line - 1, sample])
    if sample < components:
        return above
    left = np.int64(out[line, sample - components])
    corner = np.int64(out[line - 1, sample - components])
    if predictor == 1:
        predicted = left
    elif predictor == 2:
        predicted = above
    elif predictor == 3:
        predicted = corner
    elif predictor == 4:
        predicted = left + above - corner
    elif predictor == 5:
        predicted = left + ((above - corner) >> 1)
    elif predictor == 6:
        predicted = above + ((left - corner) >> 1)
    else:
        predicted = (left + above) >> 1
    return predicted
