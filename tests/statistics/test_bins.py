"""A plane in bins: plain means, and what is left out of them."""

import numpy as np
import pytest
from numpy.typing import NDArray

from fullwell.statistics.bins import bin_plane, bin_size

FRAMES = 5
NOISE = 4.0


def burst(shape: tuple[int, int], *, seed: int = 1, noise: float = NOISE) -> NDArray[np.uint32]:
    """Sum of frames around a shaded surface."""
    rng = np.random.default_rng(seed)
    surface = 500.0 - 200.0 * np.linspace(-1, 1, shape[0])[:, np.newaxis] ** 2 + np.linspace(-30, 30, shape[1])
    sums = sum(np.rint(surface + rng.normal(0.0, noise, shape)) for _ in range(FRAMES))
    return np.asarray(sums, np.float64).astype(np.uint32)


def plain(sums: NDArray[np.uint32], size: int) -> NDArray[np.float64]:
    rows, columns = sums.shape
    return np.array(
        [
            [sums[i : i + size, j : j + size].mean() / FRAMES for j in range(0, columns, size)]
            for i in range(0, rows, size)
        ]
    )


def left_in_the_mean(noise: float = NOISE) -> float:
    return noise / float(np.sqrt(FRAMES))


def test_bins_of_sound_pixels_are_plain_means() -> None:
    sums = burst((77, 90))
    found = bin_plane(sums, FRAMES, size=8, temporal_noise_dn=left_in_the_mean(), limit_dn=600.0)
    np.testing.assert_allclose(found.mean, plain(sums, 8), rtol=1e-14)
    assert (found.defective, found.saturated, found.plane_shape, found.size) == (0, 0, (77, 90), 8)
    assert found.n.sum() == sums.size
    # Ragged at the end: rows 72 to 76, columns 88 and 89.
    np.testing.assert_array_equal(found.rows, [*np.arange(3.5, 72, 8), 74.0])
    np.testing.assert_array_equal(found.columns, [*np.arange(3.5, 88, 8), 88.5])


def test_a_view_of_a_mosaic_is_taken_as_it_is() -> None:
    mosaic = burst((64, 96))
    options = {"size": 4, "temporal_noise_dn": 2.0, "limit_dn": None}
    found = bin_plane(mosaic[1::2, ::2], FRAMES, **options)
    np.testing.assert_array_equal(found.mean, bin_plane(mosaic[1::2, ::2].copy(), FRAMES, **options).mean)
    assert mosaic.flags.writeable


def test_defective_pixels_are_left_out() -> None:
    sums = burst((96, 96))
    clean = sums.copy()
    rng = np.random.default_rng(3)
    at = rng.choice(sums.size, 60, replace=False)
    sums.ravel()[at[:40]] = 1023 * FRAMES
    sums.ravel()[at[40:]] = 0
    found = bin_plane(sums, FRAMES, size=8, temporal_noise_dn=left_in_the_mean(), limit_dn=900.0)
    assert (found.defective, found.saturated) == (60, 0)
    bad = np.zeros(sums.size, bool)
    bad[at] = True
    kept = np.where(bad.reshape(sums.shape), np.nan, clean)
    expected = [[np.nanmean(kept[i : i + 8, j : j + 8]) for j in range(0, 96, 8)] for i in range(0, 96, 8)]
    np.testing.assert_allclose(found.mean, np.array(expected) / FRAMES, rtol=1e-14)


def test_the_larger_of_scatter_and_noise_decides() -> None:
    sums = np.full((8, 8), 100 * FRAMES, np.uint32)
    sums[2, 3] = 110 * FRAMES
    few, many = (bin_plane(sums, FRAMES, size=8, temporal_noise_dn=noise, limit_dn=None) for noise in (1.6, 1.7))
    assert (few.defective, many.defective) == (1, 0)
    wide = np.rint(np.random.default_rng(4).normal(500.0, 20.0, (8, 8))).astype(np.uint32)
    wide[0, 0] = 580  # four standard deviations of its bin, eighty of the stated noise
    assert bin_plane(wide, 1, size=8, temporal_noise_dn=1.0, limit_dn=None).defective == 0


def test_defects_do_not_hide_each_other() -> None:
    rng = np.random.default_rng(5)
    sums = np.rint(rng.normal(2500.0, 10.0, (16, 16))).astype(np.uint32)
    hot = rng.choice(256, 60, replace=False)
    sums.ravel()[hot] = np.linspace(3000, 5000, 60).astype(np.uint32)
    found = bin_plane(sums, FRAMES, size=16, temporal_noise_dn=2.0, limit_dn=None)
    assert found.defective == 60


def test_bins_near_saturation_are_left_out_whole() -> None:
    sums = burst((64, 64))
    limit = 490.0
    found = bin_plane(sums, FRAMES, size=8, temporal_noise_dn=left_in_the_mean(), limit_dn=limit)
    highest = sums.reshape(8, 8, 8, 8).max(axis=(1, 3)) / FRAMES
    np.testing.assert_array_equal(found.n == 0, highest > limit)
    np.testing.assert_array_equal(np.isnan(found.mean), highest > limit)
    assert 0 < found.saturated == int((highest > limit).sum()) < 64
    lone = np.full((8, 8), 1000, np.uint32)
    lone[4, 4] = 1023 * FRAMES  # a hot pixel says nothing about its bin
    assert bin_plane(lone, FRAMES, size=8, temporal_noise_dn=2.0, limit_dn=900.0).saturated == 0


def test_noise_alone_makes_no_defects() -> None:
    sums = burst((600, 800), seed=6)
    found = bin_plane(sums, FRAMES, size=8, temporal_noise_dn=left_in_the_mean(), limit_dn=None)
    # Beyond six sigma of normal noise: 480 000 times 2e-9, and never below the stated noise.
    assert found.defective == 0


def test_the_size_aims_at_as_many_bins_as_shading_needs() -> None:
    assert bin_size((1512, 2016)) == 8
    assert bin_size((3024, 4032)) == 16
    assert bin_size((30, 40)) == 4


@pytest.mark.parametrize("size", [0, 65])
def test_impossible_sizes_are_refused(size: int) -> None:
    with pytest.raises(ValueError, match="1 to 64"):
        bin_plane(np.ones((8, 8), np.uint32), 1, size=size, temporal_noise_dn=1.0, limit_dn=None)
