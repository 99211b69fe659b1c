"""Packed samples become words: the first sample in the lowest bits, as GenICam's Mono10p and Mono12p have it.

Rows begin at whole bytes. `unpack_lsb_rows` is compiled; `unpack_lsb_rows_plain` is its readable twin.
"""

import numba as nb
import numpy as np
from numpy.typing import NDArray


def unpack_lsb_rows(packed: NDArray[np.uint8], out: NDArray[np.uint16], *, bits: int, row_bytes: int) -> None:
    """Unpack rows of samples into ``out``.

    Parameters
    ----------
    packed
        Bytes of the rows; those that pad the last row may be missing.
    out
        Array of ``uint16``, shape (rows, columns), filled [DN].
    bits
        Bits per sample, 1 to 16.
    row_bytes
        Bytes from the beginning of a row to the next.

    Raises
    ------
    ValueError
        Where ``packed`` is too short for ``out``.

    """
    _check(packed, out, bits=bits, row_bytes=row_bytes)
    _unpack(packed, bits, row_bytes, out)


def unpack_lsb_rows_plain(packed: NDArray[np.uint8], out: NDArray[np.uint16], *, bits: int, row_bytes: int) -> None:
    """Do what `unpack_lsb_rows` does, one array expression for each step."""
    _check(packed, out, bits=bits, row_bytes=row_bytes)
    rows, columns = out.shape
    used = (columns * bits + 7) // 8
    lines = np.lib.stride_tricks.as_strided(packed, (rows, used), (row_bytes * packed.strides[0], packed.strides[0]))
    single = np.unpackbits(np.ascontiguousarray(lines), axis=1, bitorder="little")
    wanted = single[:, : columns * bits].reshape(rows, columns, bits)
    out[...] = (wanted * (1 << np.arange(bits)).astype(np.uint16)).sum(axis=2, dtype=np.uint16)


def _check(packed: NDArray[np.uint8], out: NDArray[np.uint16], *, bits: int, row_bytes: int) -> None:
    rows, columns = out.shape
    used = (columns * bits + 7) // 8
    if not 1 <= bits <= 16 or used > row_bytes:
        raise ValueError(f"rows of {row_bytes} bytes do not hold {columns} samples of {bits} bits")
    if rows and (rows - 1) * row_bytes + used > packed.size:
        raise ValueError(f"{packed.size} bytes do not hold {rows} rows of {row_bytes} bytes")


@nb.njit(cache=True, nogil=True)
def _unpack(packed: NDArray[np.uint8], bits: int, row_bytes: int, out: NDArray[np.uint16]) -> None:
    rows, columns = out.shape
    mask = np.uint64((1 << bits) - 1)
    for row in range(rows):
        position = row * row_bytes
        held = 0
        buffer = np.uint64(0)
        for column in range(columns):
            while held < bits:
                buffer |= np.uint64(packed[position]) << np.uint64(held)
                position += 1
                held += 8
            out[row, column] = np.uint16(buffer & mask)
            buffer >>= np.uint64(bits)
            held -= bits
