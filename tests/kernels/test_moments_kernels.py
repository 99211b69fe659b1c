"""The compiled loops give the same bits as their readable twins."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from sums import assert_same, empty_sums

from fullwell.kernels import moments, moments_reference, moments_summary, moments_summary_reference
from fullwell.kernels.moments_summary import ColumnSums, Maps, SpreadCounts, Surface
from fullwell.kernels.stack import Band, Stack


@st.composite
def stacks(draw: st.DrawFn) -> tuple[Stack, Band, int]:
    """A stack with gaps between its frames in any order, one band of it or a strip, and the frames' height."""
    frames, cell, tile = draw(st.integers(1, 9)), draw(st.sampled_from((1, 2))), draw(st.integers(1, 5))
    height, width = draw(st.integers(cell, 24)), draw(st.integers(cell, 24))
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    gap = draw(st.integers(0, 3))
    low, high = draw(st.sampled_from(((0, 65535), (0, 2), (65534, 65535), (500, 520))))
    codes = rng.integers(low, high, frames * (height * width + gap), dtype=np.uint16, endpoint=True)
    starts = rng.permutation(frames).astype(np.int64) * (height * width + gap)
    step = cell * tile
    top = draw(st.integers(0, (height - 1) // step)) * step
    bottom = min(top + step, height)
    top += draw(st.integers(0, (bottom - top - 1) // cell)) * cell
    codes.flags.writeable = False
    return Stack(codes, starts, width), Band(top, bottom, cell, tile), height


@given(stacks(), st.data())
def test_add_band_equals_its_twin(case: tuple[Stack, Band, int], data: st.DataObject) -> None:
    stack, band, height = case
    fast, slow = empty_sums(stack, band, height), empty_sums(stack, band, height)
    for fresh in data.draw(st.lists(st.booleans(), min_size=1, max_size=3)):
        for series, _ in (fast, slow):
            series.held[:] = 0 if fresh else series.held
        moments.add_band(stack, band, *fast)
        moments_reference.add_band(stack, band, *slow)
    assert_same(fast, slow)


@given(stacks())
def test_a_strip_of_which_nothing_else_is_in_memory(case: tuple[Stack, Band, int]) -> None:
    stack, strip, height = case
    rows = moments_reference.band_of_frames(stack, strip).astype(np.uint16)
    starts = (np.arange(stack.starts.size) * (strip.bottom - strip.top) - strip.top) * stack.width
    codes = rows.reshape(-1)
    codes.flags.writeable = False
    fast, slow = empty_sums(stack, strip, height), empty_sums(stack, strip, height)
    moments.add_band(Stack(codes, starts, stack.width), strip, *fast)
    moments_reference.add_band(stack, strip, *slow)
    assert_same(fast, slow)


@given(stacks())
def test_count_codes_equals_its_twin(case: tuple[Stack, Band, int]) -> None:
    stack, band, _height = case
    fast, slow = np.zeros((2, 2, 2, 65536), np.int64)
    moments.count_codes(stack, band, fast)
    moments_reference.count_codes(stack, band, slow)
    np.testing.assert_array_equal(fast, slow)


def maps_of(stack: Stack, height: int) -> Maps:
    frames = [
        stack.codes[start:][: height * stack.width].reshape(height, -1).astype(np.uint64) for start in stack.starts
    ]
    codes, squares = np.sum(frames, axis=0), np.sum([frame * frame for frame in frames], axis=0)
    narrow = squares.max() < 2**32
    return Maps(codes.astype(np.uint32), squares.astype(np.uint32 if narrow else np.uint64), len(frames))


@given(stacks(), st.integers(0, 40), st.integers(1, 64))
def test_summaries_equal_their_twins(case: tuple[Stack, Band, int], shift: int, bins: int) -> None:
    stack, band, height = case
    maps = maps_of(stack, height)
    rows = -(-(band.bottom - band.top) // band.cell)
    rng = np.random.default_rng(height * 1000 + stack.width)
    polynomials = rng.integers(-9, 10, (2, band.cell, rows)).astype(np.float64)
    # Whole numbers below 2^53 stay exact in any order of summation, so the twins must agree to the bit.
    reference = rng.integers(0, 1000, (band.cell, stack.width)).astype(np.float64)
    surface = Surface(reference, *polynomials)
    fast_counts, slow_counts = np.zeros((2, band.cell**2, bins), np.int64)
    fast, slow = (
        ColumnSums(*np.zeros((3, *reference.shape), np.uint64), *np.zeros((5, *reference.shape))) for _ in range(2)
    )
    moments_summary.summarize_band(maps, band, surface, fast, SpreadCounts(fast_counts, shift))
    moments_summary_reference.summarize_band(maps, band, surface, slow, SpreadCounts(slow_counts, shift))
    np.testing.assert_array_equal(fast_counts, slow_counts)
    for name, mine, its in zip(fast._fields, fast, slow, strict=True):
        # D^2 has up to 124 bits: each of at most ten additions rounds once.
        tolerance = 16 * np.finfo(np.float64).eps if name == "quartic" else 0.0
        np.testing.assert_allclose(mine, its, rtol=tolerance, atol=0.0)


@given(stacks(), st.integers(0, 2**36), st.integers(0, 2**36))
def test_picking_and_summing_maps_equal_their_twins(case: tuple[Stack, Band, int], least: int, more: int) -> None:
    stack, band, height = case
    maps = maps_of(stack, height)
    bounds = np.array([(least, least + more), (more, 2 * more)][: band.cell], np.uint64)
    for phase in range(band.cell):
        picked, n = moments_summary.pick_spreads(maps, phase, bounds)
        its, of_its = moments_summary_reference.pick_spreads(maps, phase, bounds)
        np.testing.assert_array_equal(n, of_its)
        for column, count in enumerate(n):
            np.testing.assert_array_equal(picked[column, :count], its[column, :count])
    fast, slow = moments_summary.sum_maps(maps, band.cell), moments_summary_reference.sum_maps(maps, band.cell)
    np.testing.assert_array_equal(np.array(fast), np.array(slow))


@given(stacks())
def test_burst_maps_equal_their_twin(case: tuple[Stack, Band, int]) -> None:
    stack, band, height = case
    fast, slow = np.zeros((2, 2, height, stack.width), np.float32)
    moments_summary.map_rows(stack, (band.top, band.bottom), *fast)
    moments_summary_reference.map_rows(stack, (band.top, band.bottom), *slow)
    np.testing.assert_array_equal(fast, slow)


@pytest.mark.parametrize("codes", [(0, 65535), (65535, 65535), (65534, 65535)])
def test_spread_is_exact_for_the_largest_series(codes: tuple[int, int]) -> None:
    # 65536 frames, half at each of two codes: neither L Q nor S^2 is ever larger than here.
    half, (low, high) = 32768, codes
    total, squares = half * (low + high), half * (low**2 + high**2)
    maps = Maps(np.full((2, 2), total, np.uint32), np.full((2, 2), squares, np.uint64), 65536)
    expected = 65536 * squares - total**2
    picked, n = moments_summary.pick_spreads(maps, 0, np.array([[expected, expected + 1]], np.uint64))
    assert picked[0, : n[0]].tolist() == [expected] * 4
