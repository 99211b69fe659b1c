import numpy as np
import pytest
from scipy.stats import bartlett, kstest

from fullwell.fit.constancy import constancy, equal_variances
from fullwell.fit.pooling import weighted_mean
from fullwell.units import DN2, ELECTRON, Measured

SETS = 2000


def _measured(rng, truth, errors, dof=None):
    values = truth + errors * rng.standard_normal(len(errors))
    if dof is not None:
        errors = errors * np.sqrt(rng.chisquare(dof, len(errors)) / dof)
    return [Measured.student(v, e, dof, ELECTRON) for v, e in zip(values, errors, strict=True)]


@pytest.mark.parametrize("dof", [None, 12])
def test_p_values_are_uniform_where_the_figure_is_constant(dof):
    """With 12 degrees of freedom behind each error, chi-square itself would reject too often; Welch's test does not."""
    rng = np.random.default_rng(51)
    found = [constancy(_measured(rng, 3.0, np.array([0.1, 0.2, 0.1, 0.4, 0.3]), dof)) for _ in range(SETS)]
    size = np.mean([one.p_value < 0.05 for one in found])
    assert abs(size - 0.05) <= 4.0 * np.sqrt(0.05 * 0.95 / SETS), size
    assert all(one.dof == 4 for one in found)
    if dof is None:
        assert kstest([one.p_value for one in found], "uniform").pvalue > 1e-3
        assert np.mean([one.chi_square for one in found]) == pytest.approx(4.0, abs=4.0 * np.sqrt(8.0 / SETS))
        covered = np.mean([one.mean.ci95[0] <= 3.0 <= one.mean.ci95[1] for one in found])
        assert abs(covered - 0.95) <= 4.0 * np.sqrt(0.95 * 0.05 / SETS)


def test_a_change_is_seen():
    values = [Measured.normal(v, 0.1, ELECTRON) for v in (1.0, 1.0, 1.0, 1.8)]
    found = constancy(values)
    assert found.chi_square == pytest.approx(48.0)  # 0.64 * (3/4) / 0.01
    assert found.p_value < 1e-9


def test_what_all_share_is_left_out_of_the_test_and_kept_in_the_mean():
    """The same pattern at every ISO: own errors hold its scatter, 0.5, which no comparison sees."""
    rng = np.random.default_rng(52)
    own, shared = np.array([0.1, 0.2, 0.15, 0.1]), 0.5
    p_values, blind, covered = [], [], []
    for _ in range(SETS):
        common = shared * rng.standard_normal()
        values = 2.0 + common + own * rng.standard_normal(own.size)
        measured = [Measured.normal(v, float(np.hypot(e, shared)), ELECTRON) for v, e in zip(values, own, strict=True)]
        found = constancy(measured, errors=own.tolist())
        p_values.append(found.p_value)
        blind.append(constancy(measured).p_value)
        covered.append(found.mean.ci95[0] <= 2.0 <= found.mean.ci95[1])
    assert kstest(p_values, "uniform").pvalue > 1e-3
    assert min(blind) > 0.05  # with own errors the test could never reject
    assert abs(np.mean(covered) - 0.95) <= 4.0 * np.sqrt(0.95 * 0.05 / SETS)


def test_without_errors_there_is_a_mean_and_no_verdict():
    found = constancy([Measured.exact(1.0, DN2), Measured.exact(3.0, DN2)])
    assert (found.mean.value, found.mean.std_error, found.p_value, found.dof) == (2.0, None, 1.0, 0)


def test_measurements_without_an_error_take_no_part():
    known = [Measured.normal(1.0, 0.1, DN2), Measured.normal(1.1, 0.2, DN2)]
    found = constancy([*known, Measured.exact(9.0, DN2)])
    assert found.dof == 1
    assert found.mean == weighted_mean(known).measured


def test_one_measurement_agrees_with_itself():
    one = Measured.normal(1.0, 0.1, DN2)
    assert constancy([one]).p_value == 1.0
    assert constancy([one]).mean.value == pytest.approx(1.0)


@pytest.mark.parametrize("errors", [None, [0.1]])
def test_nothing_to_compare_is_refused(errors):
    with pytest.raises(ValueError, match="as many errors"):
        constancy([], errors=errors)


def test_equal_variances_is_bartletts_test():
    groups = [np.random.default_rng(seed).normal(0.0, 1.0 + 0.1 * seed, 10 + 5 * seed) for seed in range(5)]
    expected = bartlett(*groups)
    found = equal_variances([group.var(ddof=1) for group in groups], [group.size - 1 for group in groups])
    assert found.chi_square == pytest.approx(expected.statistic, rel=1e-12)
    assert found.p_value == pytest.approx(expected.pvalue, rel=1e-9)
    together = sum(((group - group.mean()) ** 2).sum() for group in groups) / sum(group.size - 1 for group in groups)
    assert found.mean.value == pytest.approx(together)


def test_fewer_degrees_of_freedom_keep_the_size_where_pixels_share_noise():
    """Two pixels always read the same noise: estimates scatter as with half the degrees of freedom."""
    rng = np.random.default_rng(53)
    regions, dof = 16, 200
    found = rng.chisquare(dof / 2, (SETS, regions)) / (dof / 2)
    size = np.mean([equal_variances(one, dof / 2).p_value < 0.05 for one in found])
    assert abs(size - 0.05) <= 4.0 * np.sqrt(0.05 * 0.95 / SETS), size
    assert np.mean([equal_variances(one, dof).p_value < 0.05 for one in found]) > 0.5


def test_estimates_without_degrees_of_freedom_are_left_out():
    found = equal_variances([[1.0, 1.1], [np.nan, 5.0]], [[50, 60], [40, 0]])
    assert (found.dof, found.mean.unit) == (1, DN2)
    with pytest.raises(ValueError, match="degrees of freedom"):
        equal_variances([1.0], 0)


def test_a_region_without_noise_differs_from_one_with():
    assert equal_variances([1.0, 0.0], 50).p_value == 0.0
    assert equal_variances([0.0, 0.0], 50).p_value == 1.0
