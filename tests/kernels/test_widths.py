"""No sum overflows: 65 535 is the largest code, a series holds 65 536 frames, a mosaic 65 536 rows and columns."""

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from fullwell.kernels import moments, moments_reference
from fullwell.kernels.moments_rows import frames_in_32_bits, rows_in_16_bits
from fullwell.kernels.stack import Band, FrameSums, SeriesSums, Stack
from fullwell.statistics.moments import CODES, LARGEST_SIDE, LARGEST_TILE, MOST_FRAMES

FRESH = True

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


def _sums(shape: tuple[int, int], frames: int, band: Band) -> tuple[SeriesSums, FrameSums]:
    height, width = shape
    grid = band.cell**2, 1, -(-width // (band.cell * band.tile))
    return (
        SeriesSums(
            codes=np.zeros(shape, np.uint32),
            squares=np.zeros(shape, np.uint64),
            lowest=np.full(grid, 65535, np.uint16),
            highest=np.zeros(grid, np.uint16),
            n_lowest=np.zeros(grid, np.int64),
            n_highest=np.zeros(grid, np.int64),
        ),
        FrameSums(
            rows=np.zeros((frames, height, band.cell), np.uint64),
            columns=np.zeros((frames, band.cell, width), np.uint64),
            tiles=np.zeros((frames, *grid), np.uint64),
        ),
    )


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
    fast, slow = _sums((height, width), frames, band), _sums((height, width), frames, band)
    moments.add_band(stack, band, *fast, FRESH)
    moments_reference.add_band(stack, band, *slow, FRESH)
    for mine, its in zip((*fast[0], *fast[1]), (*slow[0], *slow[1]), strict=True):
        np.testing.assert_array_equal(mine, its)


@pytest.mark.parametrize("frames", [9, 300])
def test_a_stack_of_the_largest_codes_is_exact(frames: int) -> None:
    stack = Stack(np.full(frames * 8, 65535, np.uint16), np.arange(frames) * 8, 4)
    band = Band(0, 2, 2, 8)
    series, sums = _sums((2, 4), frames, band)
    moments.add_band(stack, band, series, sums, FRESH)
    assert (series.codes == frames * 65535).all()
    assert (series.squares == frames * 65535**2).all()
    assert series.n_highest.sum() == 8 * frames
