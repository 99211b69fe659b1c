import numpy as np
import pytest

from fullwell.fit.median_pixel import median_pixel_variance


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
