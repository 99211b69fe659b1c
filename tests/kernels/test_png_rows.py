"""Rows of PNG files are undone as their readable twin and another library do."""

import io
import struct
import zlib

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray
from PIL import Image

from fullwell.kernels.png_rows import undo_filters, undo_filters_plain


@st.composite
def stored_rows(draw: st.DrawFn) -> tuple[NDArray[np.uint8], int]:
    """Return rows of any bytes, which are rows of some picture whatever they are, and the size of a pixel."""
    rows, columns, size = draw(st.integers(1, 9)), draw(st.integers(1, 20)), draw(st.sampled_from((1, 2)))
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    lines = rng.integers(0, 256, (rows, 1 + size * columns)).astype(np.uint8)
    lines[:, 0] = rng.integers(0, 5, rows)
    return lines, size


def as_file(lines: NDArray[np.uint8], size: int) -> bytes:
    def chunk(name: bytes, data: bytes) -> bytes:
        return struct.pack(">I", len(data)) + name + data + struct.pack(">I", zlib.crc32(name + data))

    head = struct.pack(">IIBBBBB", (lines.shape[1] - 1) // size, lines.shape[0], 8 * size, 0, 0, 0, 0)
    packed = zlib.compress(lines.tobytes())
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", head) + chunk(b"IDAT", packed) + chunk(b"IEND", b"")


@given(stored_rows())
def test_rows_are_undone_as_their_twin_and_pillow_do(case: tuple[NDArray[np.uint8], int]) -> None:
    lines, size = case
    expected = np.asarray(Image.open(io.BytesIO(as_file(lines, size))))
    for undo in (undo_filters, undo_filters_plain):
        out = np.zeros(expected.shape, np.uint16)
        assert undo(lines.copy(), out, size)
        np.testing.assert_array_equal(out, expected)


def test_an_unknown_filter_is_told() -> None:
    lines = np.array([[0, 1, 2], [5, 3, 4]], np.uint8)
    for undo in (undo_filters, undo_filters_plain):
        assert not undo(lines.copy(), np.zeros((2, 2), np.uint16), 1)
