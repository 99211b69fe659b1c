"""Moments are exact, merge in any order, and hold the extremes of what they promise to hold."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from fullwell.statistics.exact import sum_of_squares, total_of
from fullwell.statistics.moments import MOST_FRAMES, Layout, Moments, stack_of

WORDS = st.integers(0, 2**64 - 1)


def frames_of(seed: int, *, frames: int, layout: Layout) -> NDArray[np.uint16]:
    rng = np.random.default_rng(seed)
    return rng.integers(0, 65536, (frames, layout.height, layout.width), dtype=np.uint16)


def moments_of(layout: Layout, frames: NDArray[np.uint16], which: list[int], *, every: bool) -> Moments:
    moments = Moments(layout, every_histogram=every)
    if which:
        moments.add([f"{k:03d}" for k in which], stack_of([frames[k] for k in which]))
    return moments


def assert_same(a: Moments, b: Moments) -> None:
    assert a.frame_sums == b.frame_sums
    assert (a.row_squares, a.column_squares) == (b.row_squares, b.column_squares)
    assert a.histogram_frames == b.histogram_frames
    for name in set(a.maps._fields) - {"squares", "wide", "held"}:
        np.testing.assert_array_equal(getattr(a.maps, name), getattr(b.maps, name), err_msg=name)
    np.testing.assert_array_equal(a.finished().squares, b.finished().squares)
    for name in ("row_sums", "column_sums", "tile_sums", "tile_squares", "histogram"):
        np.testing.assert_array_equal(getattr(a, name), getattr(b, name), err_msg=name)


@settings(max_examples=40)
@given(st.data())
def test_any_split_and_any_order_give_the_same_bits(data: st.DataObject) -> None:
    layout = Layout(height=9, width=14, cfa=data.draw(st.sampled_from(("mono", "RGGB"))), tile=3)
    count, every = data.draw(st.integers(1, 12)), data.draw(st.booleans())
    frames = frames_of(data.draw(st.integers(0, 2**32 - 1)), frames=count, layout=layout)
    order = data.draw(st.permutations(range(count)))
    cuts = sorted(data.draw(st.lists(st.integers(0, count), max_size=4)))
    parts = [order[a:b] for a, b in zip([0, *cuts], [*cuts, count], strict=True)]
    whole = moments_of(layout, frames, list(range(count)), every=every)
    left = Moments(layout, every_histogram=every)
    for part in parts:  # ((a + b) + c) ...
        left.merge(moments_of(layout, frames, list(part), every=every))
    right = Moments(layout, every_histogram=every)
    for part in reversed(parts):  # a + (b + (c ...)), begun at the other end
        merged = moments_of(layout, frames, list(part), every=every)
        merged.merge(right)
        right = merged
    streamed = Moments(layout, every_histogram=every)
    for k in order:
        streamed.add([f"{k:03d}"], stack_of([frames[k]]))
    for other in (left, right, streamed):
        assert_same(whole, other)


def test_sums_are_those_of_numpy() -> None:
    layout = Layout(height=10, width=13, cfa="GRBG", tile=2)
    x = frames_of(1, frames=7, layout=layout)
    moments = moments_of(layout, x, list(range(7)), every=True)
    wide = x.astype(object)
    assert (moments.maps.codes == wide.sum(0)).all()
    assert (moments.finished().squares == (wide**2).sum(0)).all()
    for site in range(4):
        plane = wide[:, site // 2 :: 2, site % 2 :: 2]
        assert moments.row_squares[site] == (plane.sum(2) ** 2).sum()
        assert moments.column_squares[site] == (plane.sum(1) ** 2).sum()
        assert [sums[site] for _, sums in sorted(moments.frame_sums.items())] == list(plane.sum((1, 2)))
        assert moments.histogram[site].sum() == plane.size
    step = 2 * layout.tile
    corner = wide[:, :step:2, :step:2].sum((1, 2))
    low, high = (int(part[0, 0, 0]) for part in moments.tile_squares)
    assert low + (high << 32) == (corner**2).sum()


@given(st.lists(WORDS, max_size=20))
def test_exact_sums_equal_python_integers(words: list[int]) -> None:
    array = np.array(words, dtype=np.uint64)
    assert sum_of_squares(array) == sum(word**2 for word in words)
    assert total_of(array) == sum(words)


def test_exact_sums_hold_the_largest_series() -> None:
    # 65536 rows of the largest code in 65536 columns and 65536 frames: no margin is larger.
    largest = 65535 * 65536 * 65536
    rows = np.full(65536, largest, np.uint64)
    assert sum_of_squares(rows) == 65536 * largest**2
    assert total_of(np.full(65536, 2**64 - 1, np.uint64)) == 65536 * (2**64 - 1)


def test_the_largest_series_fits_the_maps() -> None:
    # Doubling a saturated frame 16 times by merging reaches 65536 frames without adding them one by one.
    layout = Layout(height=2, width=2, cfa="mono", tile=1)
    moments = Moments(layout)
    moments.add(["0"], stack_of([np.full((2, 2), 65535, np.uint16)]))
    while len(moments.frame_sums) < MOST_FRAMES:
        twin = Moments(layout)
        twin.merge(moments)
        twin.frame_sums = {f"{name}+{len(moments.frame_sums)}": sums for name, sums in twin.frame_sums.items()}
        moments.merge(twin)
    assert (moments.maps.codes == 65535 * 65536).all()
    assert (moments.finished().squares == 65535**2 * 65536).all()
    assert (moments.maps.n_highest == 65536).all()
    low, high = (part.astype(object) for part in moments.tile_squares)
    assert (low + high * 2**32 == 65535**2 * 65536).all()
    with pytest.raises(ValueError, match="at most 65536 frames"):
        moments.add(["one more"], stack_of([np.zeros((2, 2), np.uint16)]))


def test_misuse_is_refused() -> None:
    layout = Layout(height=4, width=4, cfa="mono")
    moments = Moments(layout)
    frame = np.zeros((4, 4), np.uint16)
    moments.add(["a"], stack_of([frame]))
    with pytest.raises(ValueError, match="twice"):
        moments.add(["a"], stack_of([frame]))
    with pytest.raises(ValueError, match="do not match"):
        moments.add(["b"], stack_of([frame[:, :2]]))
    with pytest.raises(ValueError, match="outside"):
        moments.add(["b"], stack_of([frame[:3]]))
    with pytest.raises(ValueError, match="different layouts"):
        moments.merge(Moments(Layout(height=4, width=4, cfa="mono", tile=8)))
    with pytest.raises(ValueError, match="rows and columns"):
        Layout(height=1, width=4, cfa="RGGB")
    with pytest.raises(ValueError, match="edge"):
        Layout(height=4, width=4, cfa="mono", tile=257)
