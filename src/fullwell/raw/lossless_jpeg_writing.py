"""Lossless JPEG (ITU-T T.81, process 14) for the DNG files that Fullwell writes: one Huffman table, made to measure."""

import heapq
import struct

import numpy as np
from numpy.typing import NDArray


def encode_lossless(samples: NDArray[np.uint16], *, precision: int, predictor: int) -> bytes:
    """Return samples as a lossless JPEG stream with one Huffman table.

    Parameters
    ----------
    samples
        Shape (lines, columns, components), at most 65535 lines and columns, codes below 2^precision.
    precision
        Bits per sample.
    predictor
        1 (left) or 7 (half left and half above; the better where noise dominates).

    """
    from fullwell.kernels import lossless_jpeg_encoding as kernel  # noqa: PLC0415 - loads the JIT when used

    lines, columns, components = samples.shape
    start_value = 1 << (precision - 1)
    counts = kernel.count_categories(samples, start_value=start_value, predictor=predictor)
    lengths = code_lengths(counts.tolist())
    order = sorted((length, category) for category, length in enumerate(lengths) if length)
    coded = kernel.encode_scan(
        samples,
        codes=_codes(order),
        lengths=np.array(lengths, dtype=np.int64),
        size_bits=int((counts * (lengths + np.arange(17) % 16)).sum()),
        start_value=start_value,
        predictor=predictor,
    )
    identifiers = range(1, components + 1)
    frame = b"".join(bytes((identifier, 0x11, 0)) for identifier in identifiers)
    scan = bytes(byte for identifier in identifiers for byte in (identifier, 0))
    return b"".join(
        (
            bytes((0xFF, 0xD8)),
            _segment(0xC3, struct.pack(">BHHB", precision, lines, columns, components) + frame),
            _segment(0xC4, _huffman_table(order)),
            _segment(0xDA, bytes((components, *scan, predictor, 0, 0))),
            coded,
            bytes((0xFF, 0xD9)),
        )
    )


def _segment(marker: int, payload: bytes) -> bytes:
    return struct.pack(">BBH", 0xFF, marker, len(payload) + 2) + payload


def code_lengths(counts: list[int]) -> list[int]:
    """Return the Huffman code length of each category, 0 where it does not occur, at most 16 bits.

    One more code than there are categories is made and left unused: none may be all ones (T.81, C). No weight is less
    than 1/1024 of the whole: a code of n bits needs weights that grow like Fibonacci numbers, and
    F(17) = 1597 > 1024 + 17.
    """
    floor = -(-sum(counts) // 1024)
    heap: list[tuple[int, int, tuple[int, ...]]]
    heap = [(max(count, floor), category, (category,)) for category, count in enumerate(counts) if count]
    heap.append((0, len(counts), (len(counts),)))
    heapq.heapify(heap)
    lengths = [0] * (len(counts) + 1)
    while len(heap) > 1:
        first, second = heapq.heappop(heap), heapq.heappop(heap)
        merged = first[2] + second[2]
        for category in merged:
            lengths[category] += 1
        heapq.heappush(heap, (first[0] + second[0], min(first[1], second[1]), merged))
    return lengths[:-1]


def _codes(order: list[tuple[int, int]]) -> NDArray[np.int64]:
    """Return the code of each category: codes count up through lengths and categories in order (T.81, C.2)."""
    codes = np.zeros(17, dtype=np.int64)
    code = previous = 0
    for length, category in order:
        code <<= length - previous
        codes[category] = code
        code, previous = code + 1, length
    return codes


def _huffman_table(order: list[tuple[int, int]]) -> bytes:
    """Return the payload of a DHT marker for table 0."""
    counts = [sum(1 for length, _category in order if length == bits) for bits in range(1, 17)]
    return bytes((0, *counts, *(category for _length, category in order)))
