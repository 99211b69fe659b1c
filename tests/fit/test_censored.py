import numpy as np
import pytest
from scipy.special import ndtr

from fullwell.fit.censored import fit_censored_normal, is_clipped_low, trim_hot_pixels

NOISE = 1.5


def _cells(mean, noise, codes):
    return np.diff(np.concatenate([[0.0], ndtr((np.arange(codes) + 0.5 - mean) / noise)]))


@pytest.mark.parametrize(
    ("above_black", "naive_bias"), [(-0.5, -0.51), (0.0, -0.40), (0.5, -0.28), (1.0, -0.19), (2.0, -0.055)]
)
def test_T12_clipped_noise_is_recovered(above_black, naive_bias):  # noqa: N802 - METHOD's name of the test
    """The bias of the plain standard deviation is METHOD 3.4's, known to half a percent; this one has none."""
    sets, n = 1000, 20_000
    rng = np.random.default_rng(12)
    cells = _cells(above_black, NOISE, 24)
    noise, mean, covered, naive = [], [], [], []
    for counts in rng.multinomial(n, cells / cells.sum(), sets):
        fit = fit_censored_normal(64, counts, clipped_low=True, clipped_high=False)
        assert fit.converged
        noise.append(fit.noise.value)
        mean.append(fit.mean.value - 64.0)
        covered.append(
            (
                fit.noise.ci95[0] <= NOISE <= fit.noise.ci95[1],
                fit.mean.ci95[0] <= 64.0 + above_black <= fit.mean.ci95[1],
            )
        )
        codes = np.arange(counts.size)
        naive.append(np.sqrt(counts @ codes**2 / n - (counts @ codes / n) ** 2))
    assert abs(np.mean(noise) / NOISE - 1.0) <= 4.0 * np.std(noise) / NOISE / np.sqrt(sets)
    assert abs(np.mean(mean) - above_black) <= 4.0 * np.std(mean) / np.sqrt(sets)
    share = np.mean(covered, axis=0)
    assert np.all(np.abs(share - 0.95) <= 4.0 * np.sqrt(0.95 * 0.05 / sets)), share
    assert np.mean(naive) / NOISE - 1.0 == pytest.approx(naive_bias, abs=0.005)


def _histogram(rng, *, mean, noise, rail=None, hot=0.0, n=1_000_000):
    codes = np.rint(mean + noise * rng.standard_normal(n)).astype(np.int64)
    hot_pixels = int(hot * n)
    codes[:hot_pixels] += rng.integers(20, 400, hot_pixels)
    if rail is not None:
        codes = np.maximum(codes, rail)
    return int(codes.min()), np.bincount(codes - codes.min())


@pytest.mark.parametrize("noise", [0.05, 0.1, 0.2, 0.3, 0.4, 0.5, 1.0, 3.0])
@pytest.mark.parametrize("mean", [64.0, 64.2, 64.45, 64.5])
@pytest.mark.parametrize("hot", [0.0, 0.03])
def test_a_distribution_that_is_not_cut_is_not_called_clipped(noise, mean, hot):
    rng = np.random.default_rng(34)
    assert not is_clipped_low(*_histogram(rng, mean=mean, noise=noise, hot=hot))


@pytest.mark.parametrize("noise", [0.5, 1.0, 3.0, 20.0])
@pytest.mark.parametrize("above", [0.0, 0.5, 1.0, 2.0])
@pytest.mark.parametrize("hot", [0.0, 0.03])
def test_a_distribution_that_is_cut_is_called_clipped(noise, above, hot):
    """The rail lies up to two sigma below the mean: between half and 2 % of the pixels are beyond it."""
    rng = np.random.default_rng(35)
    histogram = _histogram(rng, mean=64.0 + above * noise, noise=noise, rail=64, hot=hot)
    assert is_clipped_low(*histogram)


def test_pixels_that_differ_more_than_they_flicker_are_not_taken_for_a_cut():
    """Five frames show the few lowest of 768 pixels five times: values pile up where no rail is."""
    rng = np.random.default_rng(36)
    frames, pattern_dn, noise_dn = 5, 20.0, 1.25
    alike = 1.0 + (frames - 1) * pattern_dn**2 / (pattern_dn**2 + noise_dn**2)
    taken_singly = 0
    for _ in range(1500):
        levels = 256.0 + pattern_dn * rng.standard_normal(768)
        codes = np.rint(levels + noise_dn * rng.standard_normal((frames, 768))).astype(np.int64)
        histogram = int(codes.min()), np.bincount(codes.ravel() - codes.min())
        taken_singly += is_clipped_low(*histogram)
        assert not is_clipped_low(*histogram, alike=alike)
    assert taken_singly > 0
    cut = np.maximum(codes, round(256.0 - 1.5 * pattern_dn))
    assert is_clipped_low(int(cut.min()), np.bincount(cut.ravel() - cut.min()), alike=alike)


def test_code_zero_is_a_rail_and_a_suspected_one_decides_where_the_histogram_cannot():
    two_codes = np.array([900, 100])
    assert is_clipped_low(0, two_codes)
    assert not is_clipped_low(64, two_codes)
    assert is_clipped_low(64, two_codes, suspected_rail=64)
    assert not is_clipped_low(0, np.array([1, 999, 5000, 999]))


def test_far_tails_are_safe():
    counts = np.zeros(600, dtype=np.int64)
    counts[:3], counts[599] = (10, 100, 10), 1
    fit = fit_censored_normal(0, counts, clipped_low=False, clipped_high=False)
    codes = np.arange(600)
    mean = counts @ codes / 121
    assert fit.mean.value == pytest.approx(mean, abs=1e-3)
    assert fit.noise.value == pytest.approx(np.sqrt(counts @ (codes - mean) ** 2 / 121 - 1 / 12), rel=1e-3)


def test_upper_rail_mirrors_the_lower_one():
    counts = np.array([5000, 3000, 1500, 400, 100])
    low = fit_censored_normal(0, counts, clipped_low=True, clipped_high=False)
    high = fit_censored_normal(0, counts[::-1], clipped_low=False, clipped_high=True)
    assert high.noise.value == pytest.approx(low.noise.value, rel=1e-6)
    assert high.mean.value == pytest.approx(4.0 - low.mean.value, abs=1e-6)


def test_rescaled_codes():
    counts = np.array([5000, 3000, 1500, 400, 100])
    spread = np.zeros(17, dtype=np.int64)
    spread[::4] = counts
    one = fit_censored_normal(0, counts, clipped_low=True, clipped_high=False)
    four = fit_censored_normal(0, spread, clipped_low=True, clipped_high=False, step=4)
    assert four.noise.value == pytest.approx(4.0 * one.noise.value)
    assert four.mean.std_error == pytest.approx(4.0 * one.mean.std_error)


def test_one_code_says_nothing():
    with pytest.raises(ValueError, match="one populated code"):
        fit_censored_normal(64, np.array([7]), clipped_low=False, clipped_high=False)


def test_hot_pixels_do_not_set_the_noise():
    rng = np.random.default_rng(38)
    first, counts = _histogram(rng, mean=65.0, noise=3.0, rail=64, hot=0.001)
    naive = fit_censored_normal(first, counts, clipped_low=True, clipped_high=False).noise
    fit = fit_censored_normal(first, trim_hot_pixels(counts), clipped_low=True, clipped_high=False).noise
    assert naive.value > 4.0
    assert abs(fit.value - 3.0) <= 4.0 * fit.std_error
    clean = rng.multinomial(20_000, _cells(1.0, NOISE, 24))
    np.testing.assert_array_equal(np.trim_zeros(trim_hot_pixels(clean), "b"), np.trim_zeros(clean, "b"))
