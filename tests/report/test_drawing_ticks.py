"""Ticks: round numbers, between the ends, at least two, in words that tell them apart."""

import math
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import assume, example, given
from hypothesis import strategies as st

from fullwell.report.drawing.axis import Axis
from fullwell.report.drawing.text import width
from fullwell.report.drawing.ticks import linear_ticks, linear_words, log_ticks, log_words, small_log_ticks

ENDS = st.floats(-1e6, 1e6).map(lambda value: round(value, 6))
POSITIVE = st.floats(1e-9, 1e9)


@given(ENDS, ENDS, st.integers(3, 9))
def test_linear_ticks_are_round_inside_and_as_many_as_allowed(one, other, most):
    low, high = sorted((one, other))
    assume(high - low > 1e-9 * max(abs(low), abs(high), 1.0))
    places = linear_ticks(low, high, most=most)
    step = places[1] - places[0]
    assert 2 <= len(places) <= most + 1
    assert all(low - 1e-6 * (high - low) <= place <= high + 1e-6 * (high - low) for place in places)
    mantissa = step / 10.0 ** math.floor(math.log10(step) + 1e-9)
    assert min(abs(mantissa - nice) for nice in (1.0, 2.0, 2.5, 5.0, 10.0)) < 1e-4
    assert len(set(linear_words(places))) == len(places)


@given(st.integers(-1000, 1000), st.integers(2, 2000), st.integers(3, 9))
def test_whole_ticks_are_whole(low, length, most):
    assert all(place == round(place) for place in linear_ticks(low, low + length, most=most, whole=True))


@given(POSITIVE, st.floats(0.001, 18.0))
def test_log_ticks_are_inside_and_at_least_two(low, decades):
    high = low * 10.0**decades
    places = log_ticks(low, high, most=7)
    assert 2 <= len(places) <= 8
    assert places == sorted(places)
    assert all(low * (1.0 - 1e-6) <= place <= high * (1.0 + 1e-6) for place in places)
    assert all(low <= place <= high for place in small_log_ticks(low, high))


@given(POSITIVE, st.floats(100.0, 1e12))
def test_over_decades_only_decades_are_marked(low, ratio):
    for place in log_ticks(low, low * ratio, most=7):
        assert math.log10(place) == pytest.approx(round(math.log10(place)), abs=1e-9)


@given(
    st.one_of(st.tuples(st.just("linear"), ENDS, ENDS), st.tuples(st.just("log"), POSITIVE, POSITIVE)),
    st.floats(90.0, 600.0),
)
@example(("linear", -1.0, -241663.0), 90.0)
def test_words_along_an_axis_do_not_touch(ends, length):
    scale, one, other = ends
    low, high = sorted((one, other))
    assume(high > low + 1e-6 * max(abs(low), abs(high), 1e-6))
    axis = Axis(across=True, scale=scale, low=low, high=high)
    marks = axis.marks(length)
    places = axis.scaled().share(np.array(marks.places)) * length
    written = [(place, width(word, 8.0)) for place, word in zip(places, marks.words, strict=True) if word]
    for (left, wide), (right, wider) in pairwise(written):
        assert right - left > (wide + wider) / 2.0


def test_words_beyond_a_million_and_below_a_ten_thousandth_have_powers():
    assert linear_words([0.0, 5e6]) == ["0", "5·10^{6}"]
    assert linear_words([-2e-5, 0.0]) == ["\N{MINUS SIGN}2·10^{\N{MINUS SIGN}5}", "0"]
    assert log_words([1e-4, 1e-3, 9999.0, 1e4]) == ["10^{\N{MINUS SIGN}4}", "0.001", "9999", "10^{4}"]


@pytest.mark.parametrize("scale", ["linear", "log", "powers"])
def test_an_axis_with_nothing_drawn_has_ends_and_ticks(scale):
    axis = Axis(across=True, scale=scale)
    low, high = axis.ends()
    assert low < high
    assert len(axis.marks(200.0).places) >= 2


@pytest.mark.parametrize(
    "ends", [(0.0, 0.0), (math.nan, 1.0), (-1.0, math.inf), (2.0, 2.0), (2.0, 2.0 + 1e-15), (None, -5.0)]
)
@pytest.mark.parametrize("scale", ["linear", "log"])
def test_ends_that_cannot_be_are_mended(scale, ends):
    axis = Axis(across=False, scale=scale, low=ends[0], high=ends[1])
    axis.see(np.array([1.0, 3.0]))
    low, high = axis.ends()
    assert math.isfinite(low)
    assert math.isfinite(high)
    assert abs(high - low) > 1e-12 * abs(high)
    assert len(axis.marks(100.0).places) >= 2


def test_a_single_value_stands_in_the_middle():
    for value, scale in ((0.0, "linear"), (-3.0, "linear"), (1e9, "linear"), (7.0, "log")):
        axis = Axis(across=True, scale=scale)
        axis.see(np.array([value]))
        assert float(axis.scaled().share(np.array(value))) == pytest.approx(0.5)
