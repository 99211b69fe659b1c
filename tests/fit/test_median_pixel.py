import numpy as np
import pytest
from scipy.stats import binom

from fullwell.fit.median_pixel import _widest_step, median_pixel_noise, median_pixel_variance


def test_a_few_telegraph_pixels_move_the_mean_but_not_the_median() -> None:
    rng = np.random.default_rng(36)
    frames, pixels, noise = 5, 200_000, 1.5
    codes = rng.normal(200.3, noise, (frames, pixels))
    codes[:, : pixels // 100] += 8.0 * rng.choice([-1.0, 1.0], (frames, pixels // 100))
    variances = np.rint(codes).var(axis=0, ddof=1)
    found = median_pixel_variance(float(np.median(variances)), frames=frames, pixels=pixels)
    truth = noise**2 + 1.0 / 12.0
    assert found.std_error is not None
    # one per cent of the pixels lie above the median whatever they do: the median moves to the 50.5 % point at most
    shift = 0.005 * truth / 0.25
    assert abs(found.value - truth) < 4.0 * found.std_error + shift
    assert variances.mean() > truth + 0.3


@pytest.mark.parametrize("frames", [2, 5, 16])
def test_continuous_noise_is_recovered_within_its_error(frames: int) -> None:
    rng = np.random.default_rng(frames)
    variances = rng.normal(0.0, 40.0, (frames, 100_000)).var(axis=0, ddof=1)
    found = median_pixel_variance(float(np.median(variances)), frames=frames, pixels=100_000)
    assert found.std_error is not None
    assert abs(found.value - 1600.0) < 4.0 * found.std_error


@pytest.mark.parametrize("frames", [2, 3, 4, 5, 8])
def test_variances_of_whole_codes_are_coarse_and_the_interval_allows_for_it(frames: int) -> None:
    rng = np.random.default_rng(frames)
    pixels = 20_000
    for noise in np.geomspace(1.25, 12.0, 24):
        codes = np.rint(rng.uniform(99.5, 100.5, pixels) + rng.normal(0.0, noise, (frames, pixels)))
        found = median_pixel_variance(float(np.median(codes.var(axis=0, ddof=1))), frames=frames, pixels=pixels)
        assert found.ci95 is not None
        # 120 intervals: 3.9 standard errors, which one in ten thousand exceeds
        middle, half = found.value, found.ci95[1] - found.value
        assert abs(middle - noise**2 - 1.0 / 12.0) < 2.0 * half


@pytest.mark.parametrize(("frames", "reach"), [(2, 60), (3, 60), (4, 16), (5, 9), (6, 7)])
def test_no_step_between_spreads_of_whole_codes_is_wider_than_is_reckoned(frames: int, reach: int) -> None:
    codes = np.stack(np.meshgrid(*[np.arange(reach)] * (frames - 1)), axis=-1).reshape(-1, frames - 1)
    spreads = np.unique(frames * (codes**2).sum(axis=1) - codes.sum(axis=1) ** 2)
    spreads = spreads[spreads <= (reach - 1) ** 2 * (frames - 1) / 2]
    steps = np.diff(spreads)
    assert all(step <= _widest_step(float(at), frames) for at, step in zip(spreads, steps, strict=False))


@pytest.mark.parametrize("step", [1, 16])
@pytest.mark.parametrize("frames", [2, 3, 4, 5, 6, 8, 16, 32])
def test_intervals_of_noise_of_about_a_code_and_less_hold(frames: int, step: int) -> None:
    rng = np.random.default_rng(100 * frames + step)
    pixels, held, told = 4000, 0, 0
    for noise in np.geomspace(0.02, 2.0, 60):
        for spread in (0.2, 5.0):  # levels of nearly one phase, which one is drawn, and of all
            level = 100.0 + rng.uniform() + rng.normal(0.0, spread, pixels)
            codes = step * np.rint(level + rng.normal(0.0, noise, (frames, pixels)))
            median = float(np.median(codes.var(axis=0, ddof=1)))
            found = median_pixel_noise(median, frames=frames, pixels=pixels, quantization_step=float(step)).noise
            low, high = found.ci95 or (np.inf, -np.inf)
            held, told = held + (low <= step * noise <= high), told + 1
    # a tool that holds 95 % fails once in 10 000 runs: 120 intervals, 102 or fewer
    assert held > binom.ppf(1e-4, told, 0.95)


def test_no_noise_seen_is_not_none_known() -> None:
    found = median_pixel_noise(0.0, frames=5, pixels=10_000).noise
    assert found.ci95 is not None
    assert found.ci95[1] > 0.22  # of five codes of such noise, at the median phase, half the pixels have all alike
