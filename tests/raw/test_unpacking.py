import numpy as np
import pytest
from dng_builder import packed
from hypothesis import given, settings
from hypothesis import strategies as st

from fullwell.kernels.unpacking import unpack_rows, unpack_rows_plain


@settings(deadline=None)  # the first example waits for the compiler
@given(
    bits=st.integers(1, 16),
    rows=st.integers(1, 5),
    columns=st.integers(1, 40),
    skip=st.integers(0, 39),
    seed=st.integers(0, 2**32 - 1),
)
def test_kernel_and_twin_recover_what_was_packed(bits: int, rows: int, columns: int, skip: int, seed: int) -> None:
    skip = min(skip, columns - 1)
    mosaic = np.random.default_rng(seed).integers(0, 1 << bits, (rows, columns), dtype=np.uint16)
    stored = np.frombuffer(packed(mosaic, bits), dtype=np.uint8)
    row_bytes = (columns * bits + 7) // 8
    for unpack in (unpack_rows, unpack_rows_plain):
        out = np.zeros((rows, columns - skip), dtype=np.uint16)
        unpack(stored, out, bits=bits, row_bytes=row_bytes, first_column=skip)
        np.testing.assert_array_equal(out, mosaic[:, skip:])


@pytest.mark.parametrize("unpack", [unpack_rows, unpack_rows_plain])
def test_nothing_is_read_beyond_the_bytes(unpack: object) -> None:
    out = np.zeros((2, 4), dtype=np.uint16)
    with pytest.raises(ValueError, match="13 bytes do not hold 2 rows"):
        unpack(np.zeros(13, dtype=np.uint8), out, bits=14, row_bytes=7)
    with pytest.raises(ValueError, match="do not hold 5 samples"):
        unpack(np.zeros(14, dtype=np.uint8), out, bits=14, row_bytes=7, first_column=1)
