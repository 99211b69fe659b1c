"""Samples packed as MIPI CSI-2 sends them become words: the high bytes of a group, then the low bits of all of them.

RAW10 puts four samples into five bytes, RAW12 two into three, RAW14 four into seven. The low bits of a group are one
little-endian number, its first sample lowest (MIPI CSI-2, data formats RAW10, RAW12 and RAW14). `unpack_mipi_rows` is
compiled; `unpack_mipi_rows_plain` is its readable twin.
"""

from typing import Final

import numba as nb
import numpy as np
from numpy.typing import NDArray

MIPI_GROUPS: Final = ((10, 4), (12, 2), (14, 4))
"""Bits of a sample, and how many samples make a group."""


def mipi_row_bytes(columns: int, *, bits: int) -> int:
    """Return the bytes of a row, its last group completed.

    Examples
    --------
    >>> mipi_row_bytes(1920, bits=12)
    2880

    """
    samples = _group(bits)
    return -(-columns // samples) * (samples * bits // 8)


def unpack_mipi_rows(packed: NDArray[np.uint8], out: NDArray[np.uint16], *, bits: int, row_bytes: int) -> None:
    """Unpack rows of samples into ``out``.

    Parameters
    ----------
    packed
        Bytes of the rows; those that pad the last row may be missing.
    out
        Array of ``uint16``, shape (rows, columns), C-contiguous, filled [DN].
    bits
        Bits per sample: 10, 12 or 14.
    row_bytes
        Bytes from the beginning of a row to the next.

    Raises
    ------
    ValueError
        Where ``packed`` is too short for ``out``, or samples of so many bits are not packed this way.

    """
    _check(packed, out, bits=bits, row_bytes=row_bytes)
    if bits == 10:
        _unpack_10(packed, row_bytes, out)
    elif bits == 12:
        _unpack_12(packed, row_bytes, out)
    else:
        _unpack_14(packed, row_bytes, out)


def unpack_mipi_rows_plain(packed: NDArray[np.uint8], out: NDArray[np.uint16], *, bits: int, row_bytes: int) -> None:
    """Do what `unpack_mipi_rows` does, one array expression for each sample of a group."""
    _check(packed, out, bits=bits, row_bytes=row_bytes)
    rows, columns = out.shape
    samples = _group(bits)
    group_bytes, extra, used = samples * bits // 8, bits - 8, mipi_row_bytes(columns, bits=bits)
    lines = np.lib.stride_tricks.as_strided(packed, (rows, used), (row_bytes * packed.strides[0], packed.strides[0]))
    low = np.zeros((rows, used // group_bytes), dtype=np.uint32)
    for byte in range(group_bytes - samples):
        low |= lines[:, samples + byte :: group_bytes].astype(np.uint32) << (8 * byte)
    for sample in range(min(samples, columns)):
        count = len(range(sample, columns, samples))
        high = lines[:, sample::group_bytes][:, :count].astype(np.uint16) << extra
        out[:, sample::samples] = high | (low[:, :count] >> (extra * sample) & (2**extra - 1)).astype(np.uint16)


def _group(bits: int) -> int:
    """Return how many samples make a group."""
    for known, samples in MIPI_GROUPS:
        if bits == known:
            return samples
    raise ValueError(f"MIPI packs samples of 10, 12 or 14 bits, not of {bits}")


def _check(packed: NDArray[np.uint8], out: NDArray[np.uint16], *, bits: int, row_bytes: int) -> None:
    rows, columns = out.shape
    used = mipi_row_bytes(columns, bits=bits)
    if used > row_bytes:
        raise ValueError(f"rows of {row_bytes} bytes do not hold {columns} samples of {bits} bits")
    if rows and (rows - 1) * row_bytes + used > packed.size:
        raise ValueError(f"{packed.size} bytes do not hold {rows} rows of {row_bytes} bytes")


@nb.njit(cache=True, nogil=True)
def _unpack_10(packed: NDArray[np.uint8], row_bytes: int, out: NDArray[np.uint16]) -> None:
    rows, columns = out.shape
    whole = columns // 4
    for row in range(rows):
        line, target = packed[row * row_bytes :], out[row]
        for group in range(whole):
            low = np.uint32(line[5 * group + 4])
            target[4 * group] = np.uint32(line[5 * group]) << 2 | low & 3
            target[4 * group + 1] = np.uint32(line[5 * group + 1]) << 2 | low >> 2 & 3
            target[4 * group + 2] = np.uint32(line[5 * group + 2]) << 2 | low >> 4 & 3
            target[4 * group + 3] = np.uint32(line[5 * group + 3]) << 2 | low >> 6
        for sample in range(columns - 4 * whole):
            low = np.uint32(line[5 * whole + 4]) >> np.uint32(2 * sample)
            target[4 * whole + sample] = np.uint32(line[5 * whole + sample]) << 2 | low & 3


@nb.njit(cache=True, nogil=True)
def _unpack_12(packed: NDArray[np.uint8], row_bytes: int, out: NDArray[np.uint16]) -> None:
    rows, columns = out.shape
    whole = columns // 2
    for row in range(rows):
        line, target = packed[row * row_bytes :], out[row]
        for group in range(whole):
            low = np.uint32(line[3 * group + 2])
            target[2 * group] = np.uint32(line[3 * group]) << 4 | low & 15
            target[2 * group + 1] = np.uint32(line[3 * group + 1]) << 4 | low >> 4
        if columns % 2:
            target[2 * whole] = np.uint32(line[3 * whole]) << 4 | np.uint32(line[3 * whole + 2]) & 15


@nb.njit(cache=True, nogil=True)
def _unpack_14(packed: NDArray[np.uint8], row_bytes: int, out: NDArray[np.uint16]) -> None:
    rows, columns = out.shape
    whole = columns // 4
    for row in range(rows):
        line, target = packed[row * row_bytes :], out[row]
        for group in range(-(-columns // 4)):
            first = 7 * group
            low = np.uint32(line[first + 4]) | np.uint32(line[first + 5]) << 8 | np.uint32(line[first + 6]) << 16
            for sample in range(4 if group < whole else columns - 4 * whole):
                target[4 * group + sample] = np.uint32(line[first + sample]) << 6 | low & 63
                low >>= 6
