import numpy as np
import pytest

from fullwell.fit.amplification import fit_amplifier_noise
from fullwell.fit.legacy.imatest import legacy_offset_ratio
from fullwell.units import DN, square_root


def test_pre_and_post_amplifier_noise_cover():
    """METHOD 3.7: bias below .01 %, coverage 95 %."""
    rng = np.random.default_rng(37)
    amplification = np.array([55, 99, 198, 299, 395, 798]) / 55.0
    truth, dof, sets = (0.4 * amplification) ** 2 + 0.9**2 + 1.0 / 12.0, 200_000, 1000
    pre, post = [], []
    for _ in range(sets):
        fit = fit_amplifier_noise(amplification, truth * rng.chisquare(dof, 6) / dof, dof)
        for found, variance, value in ((pre, fit.pre_variance, 0.4), (post, fit.post_variance, 0.9)):
            noise = square_root(variance, DN)
            found.append(((noise.value - value) / noise.std_error, noise.value))
    for found, value in ((np.array(pre), 0.4), (np.array(post), 0.9)):
        assert abs(np.mean(np.abs(found[:, 0]) <= 1.96) - 0.95) <= 4.0 * np.sqrt(0.95 * 0.05 / sets)
        assert abs(found[:, 1].mean() / value - 1.0) <= 1e-4 + 4.0 * found[:, 1].std() / value / np.sqrt(sets)


def test_no_noise_after_the_amplifier_is_an_upper_limit():
    amplification = np.array([1.0, 2.0, 4.0])
    fit = fit_amplifier_noise(amplification, (0.5 * amplification) ** 2, 10_000)
    assert fit.post_variance.value == pytest.approx(-1.0 / 12.0)
    assert fit.pre_variance.value == pytest.approx(0.25)
    post = square_root(fit.post_variance, DN)
    assert (post.value, post.std_error, post.ci95[0]) == (0.0, None, 0.0)


def test_one_iso_cannot_tell():
    with pytest.raises(ValueError, match="two or more ISOs"):
        fit_amplifier_noise([1.0, 1.0], [1.0, 1.0], 10)


def test_published_offset_absorbs_flare():
    """METHOD 2.2: without flare it lands range/1e5 below the darkest patch."""
    assert legacy_offset_ratio(511.0, 16383.0).value == pytest.approx(511.0 - (16383.0 - 511.0) / 99999.0)
