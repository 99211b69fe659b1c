"""The random numbers are the published generators', exact in law, and never depend on who asks for them."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import stats
from scipy.special import ndtr

from fullwell.kernels import random, random_twin
from fullwell.kernels.random import Draws

DRAWS = Draws(seed=2**63 + 12345, stream=3, frame=7, first=11, stride=300)


@pytest.mark.parametrize(
    ("counter", "key", "expected"),
    [
        ((0, 0, 0, 0), (0, 0), "6627e8d5 e169c58d bc57ac4c 9b00dbd8"),
        ((0xFFFFFFFF,) * 4, (0xFFFFFFFF,) * 2, "408f276d 41c83b0e a20bc7c6 6d5451fd"),
        (
            (0x243F6A88, 0x85A308D3, 0x13198A2E, 0x03707344),
            (0xA4093822, 0x299F31D0),
            "d16cfe09 94fdcceb 5001e420 24126ea1",
        ),
    ],
)
def test_blocks_are_those_published_with_philox(
    counter: tuple[int, int, int, int], key: tuple[int, int], expected: str
) -> None:
    assert " ".join(f"{word:08x}" for word in random_twin.philox4x32(counter, key)) == expected


def test_normal_numbers_equal_their_twin() -> None:
    assert np.array_equal(random.normal((40, 150), DRAWS), random_twin.normal((40, 150), DRAWS))


def test_normal_numbers_are_added_as_they_are_made() -> None:
    array = np.linspace(-3.0, 3.0, 40 * 650).reshape(40, 650)
    expected = array + 2.5 * random.normal(array.shape, DRAWS)
    random.add_normal(array, 2.5, DRAWS)
    assert np.array_equal(array, expected)


@pytest.mark.parametrize("mean", [0.0, 0.1, 3.0, 9.999, 10.0, 41.0, 1000.0, 1e5])
def test_poisson_numbers_equal_their_twin(mean: float) -> None:
    means = np.full((16, 150), mean)
    assert np.array_equal(random.poisson(means, DRAWS), random_twin.poisson(means, DRAWS))


def test_poisson_numbers_equal_their_twin_where_methods_meet_within_a_row() -> None:
    means = np.linspace(0.0, 25.0, 3000).reshape(5, 600)[:, ::-1]
    assert np.array_equal(random.poisson(means, DRAWS), random_twin.poisson(means, DRAWS))


@settings(max_examples=25)
@given(
    top=st.integers(0, 20),
    left=st.integers(0, 300),
    rows=st.integers(1, 10),
    columns=st.integers(1, 300),
    mean=st.sampled_from([0.3, 8.0, 40.0, 4000.0]),
)
def test_a_pixel_draws_the_same_numbers_in_any_tile(top: int, left: int, rows: int, columns: int, mean: float) -> None:
    whole = Draws(seed=5, stream=1, stride=600)
    part = Draws(seed=5, stream=1, first=top * 600 + left, stride=600)
    window = np.s_[top : top + rows, left : left + columns]
    assert np.array_equal(random.normal((30, 600), whole)[window], random.normal((rows, columns), part))
    means = np.full((30, 600), mean)
    assert np.array_equal(random.poisson(means, whole)[window], random.poisson(means[window], part))


@pytest.mark.parametrize("mean", [0.1, 0.5, 3.0, 9.9, 10.1, 20.0, 39.0, 41.0, 100.0, 1000.0])
def test_poisson_numbers_pass_a_chi_square_test(mean: float) -> None:
    numbers = random.poisson(np.full((1000, 2000), mean), Draws(seed=20, stream=1, stride=2000)).ravel().astype(int)
    lowest, highest = stats.poisson.ppf([1e-5, 1.0 - 1e-5], mean).astype(int)
    expected = stats.poisson.pmf(np.arange(lowest, highest + 1), mean)
    expected[0] += stats.poisson.cdf(lowest - 1, mean)
    expected[-1] += stats.poisson.sf(highest, mean)
    observed = np.bincount(np.clip(numbers, lowest, highest) - lowest, minlength=expected.size)
    # One test among 10: fails by chance once in 10^5 seeds.
    assert stats.chisquare(observed, numbers.size * expected).pvalue > 1e-6


def test_the_inequalities_that_make_poisson_numbers_exact_hold() -> None:
    """p, the Poisson probability, and f, the rounded normal's, bound each other as algorithm PD needs."""
    for mean in np.concatenate([np.linspace(10.0, 12.0, 101), np.geomspace(12.0, 1e5, 300)]):
        root = np.sqrt(mean)
        count = np.arange(max(0.0, np.floor(mean - 9.0 * root)), np.ceil(mean + 12.0 * root + 10.0))
        near, far = (count - mean) / root, (count + 1.0 - mean) / root
        f = np.where(near < 0.0, ndtr(far) - ndtr(near), ndtr(-near) - ndtr(-far))
        p = stats.poisson.pmf(count, mean)
        at_once = count >= np.floor(mean - 1.1484)
        rounding = 1e-11 * p + 1e-15
        assert np.all(p - f >= -rounding, where=at_once)
        squeezed = ~at_once & (f > 1e-12)
        assert np.all((mean - count[squeezed]) ** 3 >= 6.0 * mean**2 * (1.0 - p[squeezed] / f[squeezed]))
        excess = p - f > 1e-12
        farthest = np.maximum(np.abs(near - 1.8), np.abs(far - 1.8))
        assert np.all(0.1069 / mean * np.exp(-farthest[excess]) >= (p - f)[excess])
        assert np.all(near[excess] > -0.6744)


def test_normal_numbers_follow_the_normal_law_into_the_tails() -> None:
    numbers = random.normal((2000, 2000), Draws(seed=21, stream=1, stride=2000)).ravel()
    edges = np.concatenate([[-np.inf], np.linspace(-5.0, 5.0, 201), [np.inf]])
    observed = np.histogram(numbers, edges)[0]
    expected = numbers.size * np.diff(ndtr(edges))
    merged = expected >= 5.0
    kept_observed = np.append(observed[merged], observed[~merged].sum())
    kept_expected = np.append(expected[merged], expected[~merged].sum())
    assert stats.chisquare(kept_observed, kept_expected).pvalue > 1e-6


def test_streams_frames_seeds_and_neighbours_are_independent() -> None:
    shape, n = (500, 1000), 500_000
    base = random.normal(shape, Draws(seed=1, stream=1, stride=1000))
    others = [
        random.normal(shape, Draws(seed=1, stream=2, stride=1000)),
        random.normal(shape, Draws(seed=1, stream=1, frame=1, stride=1000)),
        random.normal(shape, Draws(seed=2, stream=1, stride=1000)),
        np.roll(base, 1, axis=1),
        np.roll(base, 1, axis=0),
    ]
    for other in others:
        # The mean of n products of independent normal numbers has a standard error of 1 / sqrt(n).
        assert abs(float(np.mean(base * other))) < 5.0 / np.sqrt(n)
