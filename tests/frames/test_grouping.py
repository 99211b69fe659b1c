"""Exposures within 0.5 % are one series, in whatever order they come."""

from itertools import pairwise
from random import Random

from hypothesis import given
from hypothesis import strategies as st

from fullwell.frames.grouping import APART_C, conditions, group_exposures, mean

EXPOSURES = st.lists(st.floats(1e-6, 100.0), min_size=1, max_size=30)


@given(EXPOSURES, st.randoms(use_true_random=False))
def test_the_order_of_frames_never_matters(exposures: list[float], random: Random) -> None:
    shuffled = list(exposures)
    random.shuffle(shuffled)
    assert group_exposures(shuffled) == group_exposures(exposures)
    assert mean(sorted(shuffled)) == mean(sorted(exposures))


@given(EXPOSURES)
def test_neighbours_within_half_a_percent_are_linked_and_no_others(exposures: list[float]) -> None:
    groups = group_exposures(exposures)
    assert sorted(exposure for group in groups for exposure in group) == sorted(exposures)
    for group in groups:
        assert all(later <= earlier * 1.005 for earlier, later in pairwise(group))
    for shorter, longer in pairwise(groups):
        assert longer[0] > shorter[-1] * 1.005


@given(st.floats(1e-6, 100.0), st.integers(1, 12))
def test_the_mean_of_equal_exposures_is_that_exposure_to_the_last_bit(exposure: float, n: int) -> None:
    assert mean([exposure] * n) == exposure


@given(st.lists(st.floats(-60.0, 120.0), max_size=20))
def test_conditions_lie_apart_and_hold_every_temperature(temperatures: list[float]) -> None:
    groups = conditions(temperatures)
    assert [celsius for group in groups for celsius in group] == sorted(set(temperatures))
    for group in groups:
        assert all(later - earlier <= APART_C for earlier, later in pairwise(group))
    for colder, warmer in pairwise(groups):
        assert warmer[0] - colder[-1] > APART_C
