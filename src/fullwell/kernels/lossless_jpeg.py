"""Samples of a lossless JPEG scan (ITU-T T.81, annex H): the compiled decoder; its readable twin stands beside it.

Which function: `decode_lines`, for some lines or all, of one scan or of two at a time.

A line's differences are decoded four at a time where the next eight bytes and the table tell that nothing unusual is
among them, else one by one; then its predictions are added. What takes the time is that only a code tells where the
next one begins: two scans that take turns, four samples each, wait at the same time.

Written for speed and for safety: whatever the bytes are, nothing outside the arrays is read or written, and a scan
that ends early or holds an impossible code is reported. Decoders that trust their input end the process instead.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Final, TypeAlias

import numba as nb
import numpy as np
from numpy.typing import NDArray

from fullwell.kernels.lossless_jpeg_tables import PEEK, TABLE_LENGTH, UNRESOLVED, long_code

_UNSEEN: Final = np.uint64(64 - PEEK)
"""Bits of the buffer below those that are looked up."""
_GROUP: Final = 4
"""Differences that a buffer of 56 bits holds whatever they are, as long as each is looked up whole."""
_LOW_BITS: Final = np.uint64(0x0101010101010101)
_HIGH_BITS: Final = np.uint64(0x8080808080808080)

_Bits: TypeAlias = tuple[np.uint64, np.uint64, int, int]
"""The next byte, the buffer, whose highest bits come first, how many of them are read, and how many are padding."""

COMPLETE: Final = 0
ENDED_EARLY: Final = 1
IMPOSSIBLE_CODE: Final = 2


@dataclass(frozen=True, slots=True, kw_only=True)
class CodedScan:
    """A scan, and how far it is decoded.

    Parameters
    ----------
    data
        The coded bytes, from the first byte after the scan header.
    tables
        `lossless_jpeg_tables.decoding_tables` of the interleaved components.
    state
        Where its decoder stands, which moves on: the next byte, the bits in its buffer, padded ones, the buffer.

    """

    data: NDArray[np.uint8]
    tables: NDArray[np.int32]
    state: NDArray[np.int64] = field(default_factory=lambda: np.zeros(4, np.int64))


def decode_lines(
    scans: Sequence[CodedScan],
    out: Sequence[NDArray[np.uint16]],
    *,
    components: int,
    start_value: int,
    predictor: int,
    above: bool = False,
) -> int:
    """Decode the next lines of a scan, or of two of the same shape, without their point transform.

    Parameters
    ----------
    scans
        One, or two with as many tables each.
    out
        The lines of each, components interleaved, C-contiguous, shape (lines, samples of a line).
    components
        How many components are interleaved.
    start_value
        Prediction of the very first sample: 2^(precision - shift - 1).
    predictor
        1 to 7 (T.81, table H.1).
    above
        Whether the first line is the one above, which is known; only the very first lines have none.

    Returns
    -------
    int
        ``COMPLETE``, ``ENDED_EARLY`` or ``IMPOSSIBLE_CODE``; lines are valid where it is ``COMPLETE``.

    """
    one, other = scans[0], scans[-1]
    lines, others = out[0], out[-1] if len(out) > 1 else out[0][:0]
    outcome = _decode(
        (one.data, other.data),
        (one.tables, other.tables),
        (components, start_value, predictor, int(above)),
        (one.state, other.state),
        (lines, others),
    )
    return int(outcome)


@nb.njit(cache=True, nogil=True)
def _decode(
    data: tuple[NDArray[np.uint8], NDArray[np.uint8]],
    tables: tuple[NDArray[np.int32], NDArray[np.int32]],
    scan: tuple[int, int, int, int],
    states: tuple[NDArray[np.int64], NDArray[np.int64]],
    out: tuple[NDArray[np.uint16], NDArray[np.uint16]],
) -> int:
    """Decode the lines of two scans of one shape; the second may have no lines."""
    components, start_value, predictor, first = scan
    both = out[1].shape[0] > 0
    bits, other_bits = _bits_of(states[0]), _bits_of(states[1])
    for line in range(first, out[0].shape[0]):
        rows = out[0][line], out[1][line if both else 0 : line + 1].reshape(-1)
        bits, other_bits = _decode_line(data, tables, components, (bits, other_bits), rows)
        if min(bits[2], other_bits[2]) < 0:
            return IMPOSSIBLE_CODE
        if bits[2] < bits[3] or other_bits[2] < other_bits[3]:
            return ENDED_EARLY
        _add_predictions(out[0], line, components, start_value, predictor)
        if both:
            _add_predictions(out[1], line, components, start_value, predictor)
    _keep(other_bits, states[1])
    _keep(bits, states[0])
    return COMPLETE


@nb.njit(cache=True, nogil=True)
def _decode_line(
    data: tuple[NDArray[np.uint8], NDArray[np.uint8]],
    tables: tuple[NDArray[np.int32], NDArray[np.int32]],
    components: int,
    bits: tuple[_Bits, _Bits],
    rows: tuple[NDArray[np.uint16], NDArray[np.uint16]],
) -> tuple[_Bits, _Bits]:
    """Decode the differences of a line of each scan; the second line may be empty."""
    (data_0, data_1), (row_0, row_1), (bits_0, bits_1) = data, rows, bits
    table_0, table_1 = tables[0].reshape(-1), tables[1].reshape(-1)
    places = _places(components, tables[0].shape[0])
    in_fours = _GROUP % components == 0 and min(data_0.size, data_1.size) >= 8
    grouped = row_0.size // _GROUP * _GROUP if in_fours else 0
    for sample in range(0, grouped, _GROUP):
        usual, after = _four_differences(data_0, table_0, places, bits_0, row_0, np.uint64(sample))
        bits_0 = (
            after if usual else _differences(data_0, tables[0], components, bits_0, row_0, (sample, sample + _GROUP))
        )
        if row_1.size > 0:
            usual, after = _four_differences(data_1, table_1, places, bits_1, row_1, np.uint64(sample))
            bits_1 = (
                after
                if usual
                else _differences(data_1, tables[1], components, bits_1, row_1, (sample, sample + _GROUP))
            )
        if bits_0[2] < 0 or bits_1[2] < 0:
            break
    bits_0 = _differences(data_0, tables[0], components, bits_0, row_0, (grouped, row_0.size))
    bits_1 = _differences(data_1, tables[1], components, bits_1, row_1, (grouped, row_1.size))
    return bits_0, bits_1


@nb.njit(cache=True, nogil=True)
def _places(components: int, rows: int) -> tuple[np.uint64, np.uint64, np.uint64]:
    """Return where the tables of the second to the fourth of four samples begin."""
    return (
        np.uint64(1 % components % rows * TABLE_LENGTH),
        np.uint64(2 % components % rows * TABLE_LENGTH),
        np.uint64(3 % components % rows * TABLE_LENGTH),
    )


@nb.njit(cache=True, nogil=True)
def _bits_of(state: NDArray[np.int64]) -> _Bits:
    return np.uint64(state[0]), np.uint64(state[3]), state[1], state[2]


@nb.njit(cache=True, nogil=True)
def _keep(bits: _Bits, state: NDArray[np.int64]) -> None:
    state[0], state[3], state[1], state[2] = np.int64(bits[0]), np.int64(bits[1]), bits[2], bits[3]


@nb.njit(cache=True, nogil=True)
def _differences(  # noqa: PLR0917 - compiled functions take their arrays by position
    data: NDArray[np.uint8],
    tables: NDArray[np.int32],
    components: int,
    bits: _Bits,
    row: NDArray[np.uint16],
    samples: tuple[int, int],
) -> _Bits:
    """Decode differences one by one, from a sample of the line to another; a code that cannot be leaves -1 bits."""
    for sample in range(samples[0], samples[1]):
        if bits[2] < 0:
            break
        at, buffer, held, padded = _refill(data, bits)
        difference, buffer, held = _difference(tables[sample % components % tables.shape[0]], buffer, held)
        row[sample] = difference & 0xFFFF
        bits = (at, buffer, held, padded)
    return bits


@nb.njit(cache=True, nogil=True)
def _four_differences(  # noqa: PLR0917 - as above
    data: NDArray[np.uint8],
    table: NDArray[np.int32],
    places: tuple[np.uint64, np.uint64, np.uint64],
    bits: _Bits,
    row: NDArray[np.uint16],
    sample: np.uint64,
) -> tuple[bool, _Bits]:
    """Decode four differences of 12 bits or fewer each, in bytes none of which is 0xFF; tell whether they were such."""
    at, buffer, held, padded = bits
    last = np.uint64(data.size - 8)
    word = _word(data, min(at, last))
    buffer |= word >> np.uint64(held)
    first = table[buffer >> _UNSEEN]
    buffer <<= np.uint64(first & 63)
    second = table[places[0] + (buffer >> _UNSEEN)]
    buffer <<= np.uint64(second & 63)
    third = table[places[1] + (buffer >> _UNSEEN)]
    buffer <<= np.uint64(third & 63)
    fourth = table[places[2] + (buffer >> _UNSEEN)]
    buffer <<= np.uint64(fourth & 63)
    row[sample] = first >> 16
    row[sample + np.uint64(1)] = second >> 16
    row[sample + np.uint64(2)] = third >> 16
    row[sample + np.uint64(3)] = fourth >> 16
    stuffed = (~word - _LOW_BITS) & word & _HIGH_BITS  # 0 where no byte is 0xFF
    whole = (first | second | third | fourth) & 0xFF00 == 0
    taken = (first & 63) + (second & 63) + (third & 63) + (fourth & 63)
    usual = (at <= last) & (stuffed == np.uint64(0)) & whole
    return usual, (at + np.uint64((63 - held) >> 3), buffer, (held | 56) - taken, padded)


@nb.njit(cache=True, nogil=True)
def _word(data: NDArray[np.uint8], at: np.uint64) -> np.uint64:
    """Return eight bytes, the first one highest."""
    word = np.uint64(0)
    for index in range(8):
        word |= np.uint64(data[at + np.uint64(index)]) << np.uint64(56 - 8 * index)
    return word


@nb.njit(cache=True, nogil=True)
def _refill(data: NDArray[np.uint8], bits: _Bits) -> _Bits:
    """Fill the buffer to more than 56 bits; a zero stuffed behind 0xFF is skipped, a marker is followed by zeros."""
    at, buffer, held, padded = np.int64(bits[0]), bits[1], bits[2], bits[3]
    size = data.size
    while held <= 56:
        if at < size and (data[at] != 0xFF or (at + 1 < size and data[at + 1] == 0)):
            buffer |= np.uint64(data[at]) << np.uint64(56 - held)
            at += 2 if data[at] == 0xFF else 1
        else:
            padded += 8
        held += 8
    return np.uint64(at), buffer, held, padded


@nb.njit(cache=True, nogil=True)
def _difference(table: NDArray[np.int32], buffer: np.uint64, held: int) -> tuple[np.int64, np.uint64, int]:
    """Return the next difference, what is left in the buffer, and how many bits; -1 where the code is impossible."""
    entry = np.int64(table[buffer >> _UNSEEN])
    length, category = entry & 0xFF, (entry >> 8) & 0xFF
    if category == UNRESOLVED:
        length, category = long_code(np.int64(buffer >> np.uint64(48)), table)
        if length == 0:
            return np.int64(0), buffer, -1
    buffer <<= np.uint64(length)
    left = held - int(length)
    if category == 0:
        return entry >> 16, buffer, left
    if category == 16:  # the one difference without additional bits (T.81, H.1.2.2)
        return np.int64(32768), buffer, left
    bits = np.int64(buffer >> np.uint64(64 - category))
    difference = bits if bits >= 1 << (category - 1) else bits - (1 << category) + 1
    return difference, buffer << np.uint64(category), left - int(category)


@nb.njit(cache=True, nogil=True)
def _add_predictions(out: NDArray[np.uint16], line: int, components: int, start_value: int, predictor: int) -> None:
    """Turn a line of differences into samples, modulo 65536."""
    row = out[line]
    above = out[line - 1] if line > 0 else row
    kind = predictor if line > 0 else 1
    for sample in range(min(components, row.size)):
        row[sample] += np.uint16(above[sample] if line > 0 else start_value)
    if components == 2:
        even, odd = np.int64(row[0]), np.int64(row[1])
        for sample in range(2, row.size - 1, 2):
            even = (_prediction(even, above, sample, 2, kind) + row[sample]) & 0xFFFF
            odd = (_prediction(odd, above, sample + 1, 2, kind) + row[sample + 1]) & 0xFFFF
            row[sample], row[sample + 1] = even, odd
    else:
        for sample in range(components, row.size):
            left = np.int64(row[sample - components])
            row[sample] = (_prediction(left, above, sample, components, kind) + row[sample]) & 0xFFFF


@nb.njit(cache=True, nogil=True)
def _prediction(
    left: np.int64, line_above: NDArray[np.uint16], sample: int, components: int, predictor: int
) -> np.int64:
    """Return the prediction from left, above and corner (T.81, table H.1)."""
    above, corner = np.int64(line_above[sample]), np.int64(line_above[sample - components])
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
