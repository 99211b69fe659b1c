"""Packed samples become words: the bit order of TIFF and DNG, first bit highest, rows beginning at whole bytes.

`unpack_rows` is compiled; `unpack_rows_plain` is its readable twin, for the tests and for the reader of this page.
"""

import numba as nb
import numpy as np
from numpy.typing import NDArray


def unpack_rows(
    packed: NDArray[np.uint8], out: NDArray[np.uint16], *, bits: int, row_bytes: int, first_column: int = 0
) -> None:
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
    first_column
        Sample of each row that becomes column 0 of ``out``.

    Raises
    ------
    ValueError
        Where ``packed`` is too short for ``out``.

    """
    _check(packed, out, bits=bits, row_bytes=row_bytes, first_column=first_column)
    _unpack(packed, bits, row_bytes, first_column, out)


def unpack_rows_plain(
    packed: NDArray[np.uint8], out: NDArray[np.uint16], *, bits: int, row_bytes: int, first_column: int = 0
) -> None:
    """Do what `unpack_rows` does, one array expression for each step."""
    _check(packed, out, bits=bits, row_bytes=row_bytes, first_column=first_column)
    rows, columns = out.shape
    used = ((first_column + columns) * bits + 7) // 8
    lines = np.lib.stride_tricks.as_strided(packed, (rows, used), (row_bytes * packed.strides[0], packed.strides[0]))
    single = np.unpackbits(np.ascontiguousarray(lines), axis=1)
    wanted = single[:, first_column * bits : (first_column + columns) * bits].reshape(rows, columns, bits)
    weights = (1 << np.arange(bits - 1, -1, -1)).astype(np.uint16)
    out[...] = (wanted * weights).sum(axis=2, dtype=np.uint16)


def _check(packed: NDArray[np.uint8], out: NDArray[np.uint16], *, bits: int, row_bytes: int, first_column: int) -> None:
    rows, columns = out.shape
    if not 1 <= bits <= 16 or first_column < 0 or (first_column + columns) * bits > 8 * row_bytes:
        raise ValueError(f"rows of {row_bytes} bytes do not hold {first_column + columns} samples of {bits} bits")
    if rows and (rows - 1) * row_bytes + ((first_column + columns) * bits + 7) // 8 > packed.size:
        raise ValueError(f"{packed.size} bytes do not hold {rows} rows of {row_bytes} bytes")


@nb.njit(cache=True, nogil=True)
def _unpack(packed: NDArray[np.uint8], bits: int, row_bytes: int, first_column: int, out: NDArray[np.uint16]) -> None:
    rows, columns = out.shape
    mask = np.uint64((1 << bits) - 1)
    skipped_bits = first_column * bits
    for row in range(rows):
        position = row * row_bytes + skipped_bits // 8
        held = 0
        buffer = np.uint64(0)
        if skipped_bits % 8:
            buffer = np.uint64(packed[position])
            position += 1
            held = 8 - skipped_bits % 8
        for column in range(columns):
            while held < bits:
                buffer = (buffer << np.uint64(8)) | np.uint64(packed[position])
                position += 1
                held += 8
            held -= bits
            out[row, column] = np.uint16((buffer >> np.uint64(held)) & mask)
