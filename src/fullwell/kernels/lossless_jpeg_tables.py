"""Huffman tables of lossless JPEG (ITU-T T.81, annex C), as its decoder looks codes up in them."""

from typing import Final

import numba as nb
import numpy as np
from numpy.typing import NDArray

PEEK: Final = 12
"""Bits looked up at once: 16 KiB a table, which stays in the first-level cache."""
UNRESOLVED: Final = 255
FIRST: Final = 1 << PEEK
COUNT: Final = FIRST + 17
OFFSET: Final = COUNT + 17
CATEGORY: Final = OFFSET + 17
TABLE_LENGTH: Final = CATEGORY + 256


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
        One row per component, or one for all where they are alike. First, for every value the next 12 bits can have,
        ``difference << 16 | category << 8 | bits to take``: category 0 means that the difference is complete, 255 that
        the code is longer than 12 bits. Then, by code length 0 to 16, the first code, the number of codes, and where
        their categories begin; then the categories.

    """
    different = tables if len(set(tables)) > 1 else tables[:1]
    built = np.zeros((len(different), TABLE_LENGTH), dtype=np.int32)
    for row, (counts, categories) in zip(built, different, strict=True):
        row[:FIRST] = UNRESOLVED << 8
        row[COUNT + 1 : OFFSET] = counts
        row[CATEGORY : CATEGORY + len(categories)] = categories
        _fill(row)
    return built


@nb.njit(cache=True, nogil=True)
def _fill(table: NDArray[np.int32]) -> None:
    code = 0
    offset = 0
    for length in range(1, 17):
        table[FIRST + length] = code
        table[OFFSET + length] = offset
        count = table[COUNT + length]
        if length <= PEEK:
            for index in range(count):
                _enter(table, code + index, length, table[CATEGORY + offset + index])
        offset += count
        code = (code + count) << 1


@nb.njit(cache=True, nogil=True)
def _enter(table: NDArray[np.int32], code: int, length: int, category: np.int32) -> None:
    """Enter one code of at most 12 bits, with its difference where that fits into the 12 bits too."""
    spare = PEEK - length
    start = code << spare
    if 0 < category <= spare:
        width = 1 << (spare - category)
        for bits in range(1 << category):
            difference = bits if bits >= 1 << (category - 1) else bits - (1 << category) + 1
            table[start + bits * width : start + (bits + 1) * width] = (difference << 16) | (length + category)
    else:
        table[start : start + (1 << spare)] = (category << 8) | length


@nb.njit(cache=True, nogil=True)
def long_code(window: np.int64, table: NDArray[np.int32]) -> tuple[np.int64, np.int64]:
    """Return length and category of a code longer than 12 bits at the head of 16; length 0 where there is none."""
    for length in range(PEEK + 1, 17):
        index = (window >> (16 - length)) - np.int64(table[FIRST + length])
        if 0 <= index < table[COUNT + length]:
            return np.int64(length), np.int64(table[CATEGORY + table[OFFSET + length] + index])
    return np.int64(0), np.int64(0)
