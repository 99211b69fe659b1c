"""Two bursts of one shading differ by noise alone, and the test says so; a real change is seen."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.stats import kstest

from fullwell.fit.shading.comparison import compare_shading

SETS = 240
FALSE_ALARM = 1e-3


def pair(plane, rng, *, change=0.0, scale=0.4, same=True):
    """Two exposures of one sensor (or two); ``change``: how much less light the second has at the left and right."""
    signal = 500.0 * plane.on_bins(plane.cosine)
    side = np.broadcast_to(np.linspace(-1.0, 1.0, plane.bins[1]) ** 2, plane.bins)
    pattern = plane.pattern(rng)
    first = plane.data(signal, rng, pattern=pattern)
    second = plane.data(scale * signal * (1.0 - change * side), rng, pattern=pattern if same else None)
    return first, second


@pytest.mark.parametrize("same", [True, False])
def test_chi_square_is_one_where_nothing_changed(same, bench):
    plane = bench(bins=(48, 64), size=16)
    rng = np.random.default_rng(11)
    found = [compare_shading(*pair(plane, rng, same=same), same_sensor=same) for _ in range(SETS)]
    assert kstest([one.p_value for one in found], "uniform").pvalue > FALSE_ALARM
    dof = found[0].dof
    assert dof == 55
    mean = np.mean([one.chi_square for one in found])
    assert abs(mean - dof) < 4.0 * np.sqrt(2.0 * dof / SETS)
    pulls = np.array([one.difference / one.std_error for one in found])
    # every place of the map by itself; 4.5 sigma, since the map has some fifty places that are independent
    assert np.all(np.abs(pulls.std(axis=0) - 1.0) < 4.5 / np.sqrt(2.0 * SETS))


def test_prnu_of_one_sensor_would_hide_a_change_if_it_counted(bench):
    plane = bench()
    first, second = pair(plane, np.random.default_rng(2))
    one, two = (compare_shading(first, second, same_sensor=same) for same in (True, False))
    assert np.all(one.std_error < two.std_error)


def test_a_change_of_a_fifth_of_a_percent_is_seen(bench):
    plane = bench()
    rng = np.random.default_rng(3)
    for _ in range(5):
        found = compare_shading(*pair(plane, rng, change=0.002))
        assert found.p_value < 1e-6
        assert found.largest > 5.0
        left, middle = found.difference[:, 0].mean(), found.difference[:, 32].mean()
        # the sides lose .2 % against the middle; the error of a mean of correlated places is at most that of one
        assert abs(left - middle + 0.002) < 4.0 * found.std_error[:, 0].max()


def test_the_scale_is_found_and_taken_off(bench):
    plane = bench(bins=(48, 64))
    found = compare_shading(*pair(plane, np.random.default_rng(4), scale=0.37))
    noise = 2.0 * np.sqrt((plane.temporal_variance(np.array(185.0)) / 185.0**2) / (48 * 64))
    assert found.scale == pytest.approx(0.37, rel=4.0 * noise)
    assert abs(found.difference.mean()) < found.std_error.mean()
    assert found.rms == pytest.approx(np.sqrt(np.mean(found.difference**2)))


def test_a_spot_is_a_misfit_of_the_smooth_difference(bench):
    plane = bench()
    first, second = pair(plane, np.random.default_rng(5))
    spot = second.signal_dn.copy()
    spot[80:83, 90:93] *= 0.9
    assert not compare_shading(first, second).misfit
    assert compare_shading(first, replace(second, signal_dn=spot)).misfit


def test_bins_that_one_burst_lacks_are_left_out_of_the_map(bench):
    plane = bench(bins=(48, 64))
    first, second = pair(plane, np.random.default_rng(6))
    signal = second.signal_dn.copy()
    signal[10:30, 20:45] = np.nan
    found = compare_shading(first, replace(second, signal_dn=signal))
    np.testing.assert_array_equal(np.isnan(found.difference), np.isnan(signal))
    assert found.p_value > FALSE_ALARM
    assert np.isfinite([found.largest, found.rms, found.scale]).all()


def test_what_cannot_be_compared_is_refused(bench):
    plane = bench(bins=(30, 40))
    first, second = pair(plane, np.random.default_rng(7))
    with pytest.raises(ValueError, match="same bins"):
        compare_shading(first, replace(second, rows=second.rows + 1.0))
    with pytest.raises(ValueError, match="too few"):
        compare_shading(first, replace(second, signal_dn=np.full((30, 40), np.nan)))
    with pytest.raises(ValueError, match="no light"):
        compare_shading(first, replace(second, signal_dn=-second.signal_dn))
