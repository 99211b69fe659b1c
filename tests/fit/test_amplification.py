import numpy as np
import pytest

from fullwell.fit.amplification import fit_amplifier_noise
from fullwell.fit.legacy import legacy_offset_ratio


def test_pre_and_post_amplifier_noise_cover():
    """METHOD 3.7: bias below .01 %, coverage 95 %."""
    rng = np.random.default_rng(37)
    amplification = np.array([55, 99, 198, 299, 395, 798]) / 55.0
    truth, dof, sets = (0.4 * amplification) ** 2 + 0.9**2 + 1.0 / 12.0, 200_000, 1000
    pre, post = [], []
    for _ in range(sets):
        fit = fit_amplifier_noise(amplification, truth * rng.chisquare(dof, 6) / dof, dof)
        pre.append(((fit.pre.value - 0.4) / fit.pre.std_error, fit.pre.value))
        post.append(((fit.post.value - 0.9) / fit.post.std_error, fit.post.value))
    for found, value in ((np.array(pre), 0.4), (np.array(post), 0.9)):
        assert abs(np.mean(np.abs(found[:, 0]) <= 1.96) - 0.95) <= 4.0 * np.sqrt(0.95 * 0.05 / sets)
        assert abs(found[:, 1].mean() / value - 1.0) <= 1e-4 + 4.0 * found[:, 1].std() / value / np.sqrt(sets)


def test_no_noise_after_the_amplifier_is_an_upper_limit():
    amplification = np.array([1.0, 2.0, 4.0])
    fit = fit_amplifier_noise(amplification, (0.5 * amplification) ** 2, 10_000)
    assert fit.post.value == 0.0
    assert fit.post.std_error is None
    assert fit.post.ci95[0] == 0.0
    assert fit.post_variance.value == pytest.approx(-1.0 / 12.0)
    assert fit.pre.value == pytest.approx(0.5)


def test_one_iso_cannot_tell():
    with pytest.raises(ValueError, match="two or more ISOs"):
        fit_amplifier_noise([1.0, 1.0], [1.0, 1.0], 10)


def test_published_offset_absorbs_flare():
    """METHOD 2.2: without flare it lands range/1e5 below the darkest patch."""
    assert legacy_offset_ratio(511.0, 16383.0).value == pytest.approx(511.0 - (16383.0 - 511.0) / 99999.0)
