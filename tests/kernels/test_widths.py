"""No sum overflows: 65 535 is the largest code, a series holds 65 536 frames, a mosaic 65 536 rows and columns."""

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st
from sums import assert_same, empty_sums

from fullwell.kernels import moments, moments_reference
from fullwell.kernels.moments_rows import frames_in_32_bits, rows_in_16_bits
from fullwell.kernels.stack import Band, Stack
from fullwell.statistics.moments import CODES, LARGEST_SIDE, LARGEST_TILE, MOST_FRAMES

codes = st.integers(0, 65535)


@given(codes, st.integers(1, 65536))
@example(65535, 65536)
@example(23170, 8)
@example(23171, 8)
@example(32767, 4)
@example(32768, 4)
def test_sums_of_squares_in_32_bits_hold_as_many_frames_as_they_are_given(highest: int, frames: int) -> None:
    room = frames_in_32_bits(highest, frames)
    assert 1 <= room <= frames
    assert room * highest**2 < 2**32
    assert room * highest < 2**32
    assert room == frames or (room + 1) * highest**2 >= 2**32
    # Where four frames are added at once the loops multiply in 16 bits with a sign.
    assert room < 4 or frames < 4 or highest <= 32767


@given(codes, st.integers(1, 65536))
@example(65535, 65536)
@example(1023, 64)
@example(1024, 64)
def test_column_sums_in_16_bits_hold_as_many_rows_as_they_are_given(highest: int, rows: int) -> None:
    room = rows_in_16_bits(highest, rows)
    assert 1 <= room <= rows
    assert room * highest < 2**16
    assert room == rows or (room + 1) * highest >= 2**16


def test_what_a_series_may_hold_fits_its_sums() -> None:
    largest = CODES - 1
    assert largest * MOST_FRAMES < 2**32  # maps of codes
    assert largest**2 * MOST_FRAMES < 2**64  # maps of squares
    assert MOST_FRAMES * (largest**2 * MOST_FRAMES) < 2**64  # L Q, of which D = L Q - S^2 is made
    assert largest * LARGEST_SIDE < 2**32  # columns of one frame
    assert largest * (LARGEST_SIDE // 2) < 2**32  # rows of one frame, by phase of the column
    assert largest * LARGEST_SIDE * MOST_FRAMES < 2**64  # rows and columns of all frames
    assert (largest * LARGEST_TILE**2) ** 2 < 2**64  # a tile of one frame, squared


@given(
    st.one_of(st.sampled_from((0, 1, 1023, 1024, 16383, 16384, 23170, 23171, 32767, 32768, 65534, 65535)), codes),
    st.integers(1, 19),
    st.integers(1, 70),
    st.sampled_from((1, 2)),
    st.integers(0, 2**32 - 1),
)
def test_bright_bands_equal_their_twin_at_every_width(
    highest: int, frames: int, rows: int, cell: int, seed: int
) -> None:
    """Most codes are the largest one, so that every sum comes as close to its limit as it can."""
    rng = np.random.default_rng(seed)
    height, width = max(rows, cell), cell * 9 + 1
    x = np.where(rng.random((frames, height, width)) < 0.9, highest, rng.integers(0, highest + 1)).astype(np.uint16)
    stack = Stack(x.reshape(-1), np.arange(frames) * (height * width), width)
    band = Band(0, height, cell, 64)
    fast, slow = empty_sums(stack, band, height), empty_sums(stack, band, height)
    for _ in range(2):
        moments.add_band(stack, band, *fast)
        moments_reference.add_band(stack, band, *slow)
    assert_same(fast, slow)


@pytest.mark.parametrize("frames", [9, 300])
def test_a_stack_of_the_largest_codes_is_exact(frames: int) -> None:
    stack = Stack(np.full(frames * 8, 65535, np.uint16), np.arange(frames) * 8, 4)
    band = Band(0, 2, 2, 8)
    series, sums = empty_sums(stack, band, 2)
    moments.add_band(stack, band, series, sums)
    assert (series.codes == frames * 65535).all()
    assert (moments_reference.squares_of(series) == frames * 65535**2).all()
    assert series.n_highest.sum() == 8 * frames
