import math

import numpy as np
import pytest
from scipy import stats

from fullwell.figures.differences import difference
from fullwell.units import Measured


def test_a_difference_is_welchs_test():
    one, other = Measured.student(10.3, 0.2, 7.0, "DN"), Measured.student(9.6, 0.3, 4.0, "DN")
    found = difference(one, other)
    error = math.hypot(0.2, 0.3)
    dof = error**4 / (0.2**4 / 7.0 + 0.3**4 / 4.0)
    assert found.measured.std_error == pytest.approx(error, rel=1e-15)
    assert found.measured.dof == pytest.approx(dof, rel=1e-12)
    assert found.statistic == pytest.approx(0.7 / error, rel=1e-12)
    assert found.p_value == pytest.approx(2.0 * stats.t.sf(0.7 / error, dof), rel=1e-9)


def test_figures_of_one_truth_differ_by_chance_as_often_as_p_says():
    rng = np.random.default_rng(7)
    draws, sizes = 4000, (5, 9)
    p_values = []
    for _ in range(draws):
        samples = [rng.normal(3.0, spread, size) for spread, size in zip((1.0, 2.0), sizes, strict=True)]
        figures = [
            Measured.student(float(x.mean()), float(x.std(ddof=1)) / math.sqrt(len(x)), len(x) - 1.0, "DN")
            for x in samples
        ]
        p_values.append(difference(*figures).p_value)
    for level in (0.05, 0.2, 0.5):
        found = float(np.mean(np.array(p_values) < level))
        assert abs(found - level) < 4.0 * math.sqrt(level * (1.0 - level) / draws) + 0.1 * level  # Welch: about 10 %


def test_what_has_no_error_or_the_same_frames_has_no_chance():
    one, bare = Measured.normal(2.0, 0.1, "DN"), Measured.exact(1.0, "DN")
    assert difference(one, bare).p_value is None
    assert difference(one, Measured.normal(1.0, 0.1, "DN"), independent=False).measured.std_error is None
    assert difference(one, bare).ratio == 2.0
    assert difference(one, Measured.exact(0.0, "DN")).ratio is None
