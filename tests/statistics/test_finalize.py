"""The statistics of a series against brute force and against known truth."""

import math

import numpy as np
import pytest
import statistics_oracle as oracle
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from fullwell.statistics.burst import burst_sums
from fullwell.statistics.finalize import finalize
from fullwell.statistics.moments import Layout, Moments, stack_of
from fullwell.statistics.series import PlaneStatistics, SeriesStatistics

CASES = (("RGGB", 37, 51, 4, 8), ("mono", 20, 33, 7, 16), ("BGGR", 140, 300, 5, 64), ("GRBG", 30, 30, 1, 8))
# The oracle works in float64 on codes of a few thousand: variances of order 100 keep nine digits after cancellation.
ROUNDING = 1e-9


def statistics_of(x: NDArray[np.uint16], cfa: str, *, tile: int = 64, every: bool = True) -> SeriesStatistics:
    moments = Moments(Layout(height=x.shape[1], width=x.shape[2], cfa=cfa, tile=tile), every_histogram=every)
    names = [f"{k:04d}" for k in range(len(x))]
    moments.add(names[:5], stack_of(list(x[:5])))
    bursts = burst_sums(moments)
    if len(x) > 5:
        moments.add(names[5:], stack_of(list(x[5:])))
    return finalize(moments, bursts=bursts)


def scene(cfa: str, height: int, width: int, frames: int) -> NDArray[np.uint16]:
    rng = np.random.default_rng(len(cfa) + height)
    yy, xx = np.mgrid[:height, :width]
    x = rng.normal(500, 20, (frames, height, width)) + xx * 3 + yy + rng.normal(0, 5, (frames, 1, 1))
    x += rng.normal(0, 5, (frames, height, 1)) + rng.normal(0, 9, (height, 1))
    return x.round().clip(0, 65535).astype(np.uint16)


@pytest.fixture(params=CASES, ids=lambda case: f"{case[0]}-{case[1]}x{case[2]}x{case[3]}")
def case(request: pytest.FixtureRequest) -> tuple[int, list[NDArray[np.float64]], SeriesStatistics]:
    cfa, height, width, frames, tile = request.param
    x = scene(cfa, height, width, frames)
    return tile, oracle.planes_of(x, 1 if cfa == "mono" else 2), statistics_of(x, cfa, tile=tile)


Case = tuple[int, list[NDArray[np.float64]], SeriesStatistics]


def test_mean_squares_equal_a_brute_force_analysis_of_variance(case: Case) -> None:
    for plane, x in zip(case[2].planes, case[1], strict=True):
        expected = oracle.mean_squares(x)
        for name in ("t", "v", "h", "tv", "th", "vh", "tvh"):
            value = getattr(plane.mean_squares, name)
            assert value == pytest.approx(expected.get(name, math.nan), rel=ROUNDING, nan_ok=True), name


def test_variances_equal_numpy(case: Case) -> None:
    for plane, x in zip(case[2].planes, case[1], strict=True):
        assert (plane.frames, plane.rows, plane.columns) == x.shape
        np.testing.assert_allclose(plane.frame_means, x.mean((1, 2)), rtol=ROUNDING)
        assert plane.mean == pytest.approx(x.mean(), rel=ROUNDING)
        assert plane.spatial_variance == pytest.approx(x.mean(0).var(ddof=1), rel=ROUNDING)
        temporal = (plane.temporal_variance, plane.temporal_variance_scatter, plane.temporal_variance_median)
        if len(x) == 1:
            assert np.isnan(temporal).all()
            assert plane.legacy is None
            continue
        v = x.var(0, ddof=1)
        np.testing.assert_allclose(temporal, (v.mean(), v.var(ddof=1), np.median(v)), rtol=ROUNDING)
        assert plane.legacy is not None
        found = (plane.legacy.pair_variance, plane.legacy.residual_variance)
        np.testing.assert_allclose(found, oracle.legacy(x[:5]), rtol=ROUNDING)


def test_tiles_equal_a_least_squares_fit_of_each(case: Case) -> None:
    size, planes, statistics = case
    for plane, x in zip(statistics.planes, planes, strict=True):
        tiles = plane.tiles
        assert tiles.n.shape == (-(-x.shape[1] // size), -(-x.shape[2] // size))
        for i, j in np.ndindex(tiles.n.shape):
            tile = x[:, i * size : (i + 1) * size, j * size : (j + 1) * size]
            found = (tiles.temporal_variance[i, j], tiles.spatial_variance[i, j])
            np.testing.assert_allclose(found, oracle.tile_variances(tile), rtol=10 * ROUNDING)
            assert tiles.mean[i, j] == pytest.approx(tile.mean(), rel=ROUNDING)
            n = tile[0].size
            assert tiles.n[i, j] == n
            assert tiles.temporal_dof[i, j] == (n - 1) * (len(x) - 1)
            small = min(tile.shape[1:]) < 3
            assert tiles.spatial_dof[i, j] == (0 if small else n - 6)
            assert (tiles.lowest[i, j], tiles.highest[i, j]) == (tile.min(), tile.max())
            assert tiles.n_lowest[i, j] == (tile == tile.min()).sum()
            assert tiles.n_highest[i, j] == (tile == tile.max()).sum()


@pytest.mark.parametrize("every", [True, False])
def test_histogram_counts_all_frames_or_the_first(every: bool) -> None:  # noqa: FBT001 - a test's parameter
    x = scene("RGGB", 12, 14, 6)
    for plane, codes in zip(statistics_of(x, "RGGB", every=every).planes, oracle.planes_of(x, 2), strict=True):
        counted = codes if every else codes[:1]
        assert plane.histogram.frames == len(counted)
        values, counts = np.unique(counted, return_counts=True)
        found = plane.histogram.counts
        assert plane.histogram.first_code == values[0]
        assert plane.histogram.first_code + found.size - 1 == values[-1]
        np.testing.assert_array_equal(found[found > 0], counts)


@pytest.mark.parametrize("frames", [2, 3, 4, 5, 8])
def test_published_flows_differ_by_an_exact_factor(frames: int) -> None:
    x = scene("RGGB", 20, 22, frames)
    statistics = statistics_of(x, "RGGB")
    count = min(frames, 5)
    for burst in (statistics.legacy, *(plane.legacy for plane in statistics.planes)):
        assert burst is not None
        assert burst.frames == count
        ratio = math.sqrt(burst.pair_variance / 2 / burst.residual_variance)
        assert ratio == pytest.approx(math.sqrt(count / (count - 1)), rel=4 * np.finfo(float).eps)


def test_legacy_of_the_mosaic_mixes_the_planes() -> None:
    x = scene("RGGB", 20, 22, 6)
    found = statistics_of(x, "RGGB").legacy
    assert found is not None
    np.testing.assert_allclose(
        (found.pair_variance, found.residual_variance), oracle.legacy(x[:5].astype(np.float64)), rtol=ROUNDING
    )


@settings(max_examples=60)
@given(st.integers(0, 2**32 - 1), st.integers(2, 9), st.sampled_from((0, 1, 30, 3000, 65535)), st.integers(2, 40))
def test_median_is_exact_at_every_spread(seed: int, frames: int, largest: int, width: int) -> None:
    x = np.random.default_rng(seed).integers(0, largest, (frames, 5, width), dtype=np.uint16, endpoint=True)
    x[:, 2:4] //= 7  # rows of another spread, so that sampling rows may guess wrong
    plane = statistics_of(x, "mono").planes[0]
    exact = x.astype(object)
    spread = frames * (exact**2).sum(0) - exact.sum(0) ** 2
    assert plane.temporal_variance_median == np.median(spread.astype(np.float64)) / (frames * (frames - 1))


def known_plane() -> tuple[PlaneStatistics, float, int]:
    """Sixteen frames of Gaussian noise of 8 DN on a quadratic surface, with 90 DN of flicker."""
    rng = np.random.default_rng(20)
    frames, side, sigma = 16, 256, 8.0
    yy, xx = np.mgrid[-1 : 1 : side * 1j, -1 : 1 : side * 1j]
    surface = 3000 * (1 - 0.2 * (xx**2 + yy**2) + 0.05 * xx)
    flicker = rng.normal(0, 90, (frames, 1, 1))
    x = (surface + flicker + rng.normal(0, sigma, (frames, side, side))).round().astype(np.uint16)
    return statistics_of(x, "mono").planes[0], sigma**2 + 1 / 12, frames


def test_tile_variance_recovers_the_truth_despite_flicker() -> None:
    plane, variance, _frames = known_plane()
    dof = plane.tiles.temporal_dof
    pooled = float((plane.tiles.temporal_variance * dof).sum() / dof.sum())
    assert pooled == pytest.approx(variance, abs=4 * variance * math.sqrt(2 / dof.sum()))
    # With flicker left in, 90^2 DN^2 of 15 degrees of freedom: at least 15 % of it with probability 1 - 1e-4.
    assert plane.temporal_variance > variance + 0.15 * 90**2


def test_spatial_residual_of_noise_alone_is_the_noise_of_the_mean() -> None:
    plane, variance, frames = known_plane()
    dof = plane.tiles.spatial_dof
    pooled = float((plane.tiles.spatial_variance * dof).sum() / dof.sum())
    assert pooled == pytest.approx(variance / frames, abs=4 * variance / frames * math.sqrt(2 / dof.sum()))
