"""Repeats of a known truth: bias, scatter, coverage and pulls come out as they were put in."""

import numpy as np
import pytest
from scipy import stats

from fullwell.figures.calibration import Trials, binomial_interval, calibration, normal_p_value, pull
from fullwell.units import Measured

REPEATS = 4000


def trials(*, bias: float = 0.0, error_factor: float = 1.0, seed: int = 1) -> Trials:
    """Return a figure of truth 10 and scatter 2 that reports ``error_factor`` times its scatter as error."""
    values = 10.0 + bias + 2.0 * np.random.default_rng(seed).standard_normal(REPEATS)
    error = np.full(REPEATS, 2.0 * error_factor)
    half = stats.norm.ppf(0.975) * error
    return Trials(
        truth=10.0,
        values=values,
        std_errors=error,
        low=values - half,
        high=values + half,
        pulls=(values - 10.0) / error,
    )


def test_honest_errors_are_found_honest() -> None:
    found = calibration(trials())
    assert found.bias_std_error == pytest.approx(2.0 / np.sqrt(REPEATS), rel=4.0 / np.sqrt(2.0 * REPEATS))
    assert abs(found.bias) < 4.0 * (found.bias_std_error or 0.0)
    assert found.scatter_ratio == pytest.approx(1.0, abs=4.0 / np.sqrt(2.0 * REPEATS))
    assert found.coverage == pytest.approx(0.95, abs=4.0 * np.sqrt(0.95 * 0.05 / REPEATS))
    assert (found.coverage_p or 0.0) > 1e-4
    assert (found.pull_p or 0.0) > 1e-4


@pytest.mark.parametrize(("bias", "error_factor"), [(1.0, 1.0), (0.0, 0.7), (0.0, 1.4)])
def test_wrong_errors_and_biases_are_found(bias: float, error_factor: float) -> None:
    found = calibration(trials(bias=bias, error_factor=error_factor))
    expected = stats.norm.cdf(1.96 * error_factor - bias / 2.0) - stats.norm.cdf(-1.96 * error_factor - bias / 2.0)
    assert found.coverage == pytest.approx(expected, abs=4.0 * np.sqrt(expected * (1.0 - expected) / REPEATS))
    assert (found.coverage_p or 1.0) < 1e-6
    assert (found.pull_p or 1.0) < 1e-6
    assert found.bias == pytest.approx(bias, abs=8.0 / np.sqrt(REPEATS))
    assert found.scatter_ratio == pytest.approx(1.0 / error_factor, rel=4.0 / np.sqrt(2.0 * REPEATS))


def test_figures_without_errors_keep_their_bias() -> None:
    none = np.full(3, np.nan)
    found = calibration(
        Trials(truth=2.0, values=np.array([3.0, 4.0, 5.0]), std_errors=none, low=none, high=none, pulls=none)
    )
    assert (found.bias, found.sd, found.std_error, found.scatter_ratio) == (2.0, 1.0, None, None)
    assert (found.intervals, found.coverage, found.coverage_p, found.pulls, found.pull_p) == (0, None, None, 0, None)


def test_one_repeat_tells_no_scatter() -> None:
    one = np.array([3.0])
    found = calibration(Trials(truth=2.0, values=one, std_errors=one, low=one - 2.0, high=one + 2.0, pulls=one - 2.0))
    assert (found.sd, found.bias_std_error, found.pull_sd, found.pull_p) == (None, None, None, None)
    assert (found.covering, found.intervals) == (1, 1)


def test_binomial_interval_covers_at_least_as_often_as_it_says() -> None:
    for probability in (0.5, 0.95):
        hits = np.arange(41)
        inside = [low <= probability <= high for low, high in (binomial_interval(int(h), 40) for h in hits)]
        assert float(stats.binom.pmf(hits, 40, probability) @ np.array(inside)) >= 0.95


def test_pulls_of_few_degrees_of_freedom_become_normal() -> None:
    t = np.random.default_rng(5).standard_t(3, size=2000)
    pulls = np.array([pull(Measured.student(value, 1.0, 3, "DN"), 0.0) for value in t.tolist()])
    assert (normal_p_value(pulls) or 0.0) > 1e-3
    assert (normal_p_value(t) or 1.0) < 1e-3
