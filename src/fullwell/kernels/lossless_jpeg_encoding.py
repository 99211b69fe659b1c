"""Coding of a lossless JPEG scan (ITU-T T.81, annex H): compiled loops and their readable twin.

Which function: `count_categories` first, from whose counts a Huffman table is made, then `encode_scan` with that table;
`encode_scan_plain` to understand and to test.
"""

from typing import Final

import numba as nb
import numpy as np
from numpy.typing import NDArray


def count_categories(samples: NDArray[np.uint16], *, start_value: int, predictor: int) -> NDArray[np.int64]:
    """Return how often each category of differences occurs, shape (17,).

    Parameters
    ----------
    samples
        Shape (lines, columns, components).
    start_value
        Prediction of the very first sample.
    predictor
        1 or 7 (T.81, table H.1): from the left, or half left and half above.

    """
    return _count(samples, start_value, predictor, _CATEGORIES)


def encode_scan(
    samples: NDArray[np.uint16],
    *,
    codes: NDArray[np.int64],
    lengths: NDArray[np.int64],
    size_bits: int,
    start_value: int,
    predictor: int,
) -> bytes:
    """Return the coded bits of a scan, zero bytes stuffed behind 0xFF, padded with ones.

    Parameters
    ----------
    samples, start_value, predictor
        As `count_categories`.
    codes, lengths
        Huffman code of each category and its length [bit], shape (17,).
    size_bits
        What the counts and lengths sum up to: bits before stuffing.

    """
    out = np.empty(2 * (size_bits // 8 + 1), dtype=np.uint8)
    table = np.stack((codes, lengths))
    written = _encode(samples, table, _CATEGORIES, (start_value, predictor), out)
    return out[:written].tobytes()


def encode_scan_plain(
    samples: NDArray[np.uint16],
    *,
    codes: NDArray[np.int64],
    lengths: NDArray[np.int64],
    start_value: int,
    predictor: int,
) -> bytes:
    """Do what `encode_scan` does, one array expression for each step but the last."""
    wide = samples.astype(np.int64)
    predicted = np.empty_like(wide)
    predicted[0, 0] = start_value
    predicted[0, 1:] = wide[0, :-1]
    predicted[1:, 0] = wide[:-1, 0]
    left, above = wide[1:, :-1], wide[:-1, 1:]
    predicted[1:, 1:] = left if predictor == 1 else (left + above) >> 1
    differences = (wide - predicted + 32768) % 65536 - 32768
    bits: list[str] = []
    for difference in differences.ravel().tolist():
        category = abs(difference).bit_length()
        bits.append(f"{codes[category]:0{lengths[category]}b}")
        if 0 < category < 16:
            additional = difference if difference > 0 else difference + (1 << category) - 1
            bits.append(f"{additional:0{category}b}")
    joined = "".join(bits)
    joined += "1" * (-len(joined) % 8)
    return int(joined, 2).to_bytes(len(joined) // 8, "big").replace(b"\xff", b"\xff\0")


_CATEGORIES: Final = np.array([abs(value - 32768).bit_length() for value in range(65536)], dtype=np.uint8)
"""Category of each difference, from -32768 up: the bits its magnitude takes (T.81, table H.2)."""


@nb.njit(cache=True, nogil=True)
def _differences(
    samples: NDArray[np.uint16], line: int, start_value: int, predictor: int, out: NDArray[np.int64]
) -> None:
    """Fill one line's differences, from -32768 to 32767, shape (columns, components)."""
    columns, components = out.shape
    for column in range(columns):
        for component in range(components):
            if line == 0:
                predicted = np.int64(start_value) if column == 0 else np.int64(samples[0, column - 1, component])
            elif column == 0:
                predicted = np.int64(samples[line - 1, 0, component])
            else:
                predicted = np.int64(samples[line, column - 1, component])
                if predictor == 7:
                    predicted = (predicted + np.int64(samples[line - 1, column, component])) >> 1
            difference = np.int64(samples[line, column, component]) - predicted
            out[column, component] = ((difference + 32768) & 0xFFFF) - 32768


@nb.njit(cache=True, nogil=True)
def _count(
    samples: NDArray[np.uint16], start_value: int, predictor: int, categories: NDArray[np.uint8]
) -> NDArray[np.int64]:
    lines, columns, components = samples.shape
    counts = np.zeros(17, dtype=np.int64)
    differences = np.empty((columns, components), dtype=np.int64)
    for line in range(lines):
        _differences(samples, line, start_value, predictor, differences)
        for difference in differences.flat:
            counts[categories[difference + 32768]] += 1
    return counts


@nb.njit(cache=True, nogil=True)
def _encode(
    samples: NDArray[np.uint16],
    table: NDArray[np.int64],
    categories: NDArray[np.uint8],
    prediction: tuple[int, int],
    out: NDArray[np.uint8],
) -> int:
    start_value, predictor = prediction
    lines, columns, components = samples.shape
    differences = np.empty((columns, components), dtype=np.int64)
    buffer = np.uint64(0)
    held = written = 0
    for line in range(lines):
        _differences(samples, line, start_value, predictor, differences)
        for difference in differences.flat:
            category = np.int64(categories[difference + 32768])
            length = table[1, category]
            buffer = (buffer << np.uint64(length)) | np.uint64(table[0, category])
            held += length
            if 0 < category < 16:
                additional = difference if difference > 0 else difference + (1 << category) - 1
                buffer = (buffer << np.uint64(category)) | np.uint64(additional)
                held += category
            while held >= 8:
                held -= 8
                written = _put(out, written, (buffer >> np.uint64(held)) & np.uint64(0xFF))
    if held > 0:
        ones = np.uint64((1 << (8 - held)) - 1)
        written = _put(out, written, ((buffer << np.uint64(8 - held)) | ones) & np.uint64(0xFF))
    return written


@nb.njit(cache=True, nogil=True)
def _put(out: NDArray[np.uint8], written: int, byte: np.uint64) -> int:
    out[written] = byte
    if byte == 0xFF:
        out[written + 1] = 0
        return written + 2
    return written + 1
