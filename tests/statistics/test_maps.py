"""Maps of a burst are those of NumPy, for any number of threads."""

import numpy as np
import pytest

from fullwell.statistics.maps import burst_maps


@pytest.mark.parametrize("workers", [1, 2, 7])
@pytest.mark.parametrize("count", [1, 2, 5, 8])
def test_maps_equal_numpy(workers: int, count: int) -> None:
    frames = np.random.default_rng(count).integers(0, 65536, (count, 21, 34), dtype=np.uint16)
    mean, variance = burst_maps(frames, workers=workers)
    # One rounding to float32, at most half a unit in the last place; float64 in between adds nothing visible.
    rounding = float(np.finfo(np.float32).eps)
    np.testing.assert_allclose(mean, frames.mean(0), rtol=rounding)
    if count == 1:
        assert np.isnan(variance).all()
    else:
        np.testing.assert_allclose(variance, frames.astype(np.float64).var(0, ddof=1), rtol=rounding)


def test_no_frames_is_refused() -> None:
    with pytest.raises(ValueError, match="65536 frames"):
        burst_maps(np.zeros((0, 2, 2), np.uint16))
