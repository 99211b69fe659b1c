"""Patches of a chart: what is removed, what is left, and what it is worth."""

from dataclasses import dataclass

import numpy as np
import pytest

from fullwell.statistics.chart import MAX_CLIPPED, patch_points
from fullwell.statistics.patch import patch_statistics

EDGE = 40


@dataclass(frozen=True, kw_only=True)
class Box:
    name: str = "one"
    x: int = 2
    y: int = 4
    width: int = 2 * EDGE
    height: int = 2 * EDGE
    density: float | None = 0.3


def frames(rng, count, *, noise=6.0, pattern=0.0, flicker=0.0, level=2000.0):
    shape = (2 * EDGE + 8, 2 * EDGE + 6)
    y, x = np.mgrid[: shape[0], : shape[1]] / shape[0] - 0.5
    light = level * (1.0 + 0.02 * x + 0.01 * y - 0.01 * x * y)
    fixed = pattern * rng.standard_normal(shape)
    scale = 1.0 + flicker * np.linspace(-1.0, 1.0, count)
    return [np.rint(one * light + fixed + noise * rng.standard_normal(shape)).astype(np.uint16) for one in scale]


def test_one_frame_is_the_patch_about_its_surface():
    (mosaic,) = frames(np.random.default_rng(1), 1)
    points = patch_points([mosaic], [Box()], cfa="RGGB", white_dn=16383)
    assert [point.channel for point in points] == ["R", "G1", "G2", "B"]
    for site, point in enumerate(points):
        plane = mosaic[4 + site // 2 : 4 + 2 * EDGE : 2, 2 + site % 2 : 2 + 2 * EDGE : 2]
        known = patch_statistics(plane)
        assert (point.n, point.dof) == (known.n, known.dof)
        assert point.mean_dn == pytest.approx(known.mean)
        assert point.variance_dn2 == point.spatial_variance_dn2 == pytest.approx(known.variance)
        assert np.isnan(point.temporal_variance_dn2)
        assert point.temporal_dof == 0


def test_variance_of_single_frames_is_spatial_and_temporal_part_exactly():
    stack = frames(np.random.default_rng(2), 5, pattern=4.0)
    (point, *_) = patch_points(stack, [Box()], cfa="RGGB", white_dn=None)
    alone = [patch_points([one], [Box()], cfa="RGGB", white_dn=None)[0].variance_dn2 for one in stack]
    assert point.variance_dn2 == pytest.approx(np.mean(alone), rel=1e-12)
    assert point.variance_dn2 == pytest.approx(point.spatial_variance_dn2 + 0.8 * point.temporal_variance_dn2)
    assert point.temporal_dof == 4 * point.spatial_dof == 4 * (EDGE**2 - 6)
    assert point.spatial_dof < point.dof < 5 * point.spatial_dof
    np.testing.assert_allclose(point.frame_means_dn, [one[4:84:2, 2:82:2].mean() for one in stack])


def test_temporal_and_spatial_variance_find_noise_and_pattern_whatever_the_light_does():
    """2 % flicker over a 2 % gradient; 400 patches' worth of pixels: 4 sigma of their chi-square."""
    rng = np.random.default_rng(3)
    found = np.array(
        [
            (point.temporal_variance_dn2, point.spatial_variance_dn2 - point.temporal_variance_dn2 / 4)
            for _ in range(40)
            for point in patch_points(frames(rng, 4, pattern=5.0, flicker=0.02), [Box()], cfa="RGGB", white_dn=None)
        ]
    )
    temporal, fixed = 36.0 + 1 / 12, 25.0
    error = np.array([temporal * np.sqrt(2 / 3), (fixed + temporal / 4) * np.sqrt(2)]) / EDGE / np.sqrt(len(found))
    assert np.all(np.abs(found.mean(axis=0) - [temporal, fixed]) < 4 * error + [0.0, 0.002])


def test_dof_of_the_mean_of_single_frames_is_what_its_scatter_says():
    rng = np.random.default_rng(4)
    points = [
        point
        for _ in range(150)
        for point in patch_points(frames(rng, 3, pattern=6.0), [Box()], cfa="RGGB", white_dn=None)
    ]
    variance = np.array([point.variance_dn2 for point in points])
    dof = np.mean([point.dof for point in points])
    ratio = variance.var(ddof=1) / (2 * variance.mean() ** 2 / dof)
    assert abs(ratio - 1) < 4 * np.sqrt(2 / len(points))


def test_rows_in_common_are_seen_and_white_noise_has_none():
    rng = np.random.default_rng(5)
    signed = {0.0: [], 2.0: []}
    for size, found in signed.items():
        for _ in range(60):
            mosaic = frames(rng, 1)[0].astype(float)
            mosaic += size * rng.standard_normal((mosaic.shape[0], 1))
            (point,) = patch_points([np.rint(mosaic).astype(np.uint16)], [Box()], cfa="mono", white_dn=None)
            found.append((point.row_variance_dn2, point.column_variance_dn2))
    for size, found in signed.items():
        mean, error = np.mean(found, axis=0), np.std(found, axis=0, ddof=1) / np.sqrt(len(found))
        assert abs(mean[0] - size**2) < 4 * error[0]
        assert abs(mean[1]) < 4 * error[1] + size**2 / (2 * EDGE)


def test_clipping_counts_both_rails():
    mosaic = frames(np.random.default_rng(6), 1)[0]
    mosaic[4:8, 2:82:2] = 4000
    mosaic[5:9:2, 3:83:2] = 0
    red, _, _, blue = patch_points([mosaic], [Box()], cfa="RGGB", white_dn=(4000, 4000, 4000, 4000))
    assert red.clipped_high == pytest.approx(2 / EDGE)
    assert blue.clipped_low == pytest.approx(2 / EDGE)
    assert red.clipped_high > MAX_CLIPPED
    assert not red.admitted
    assert red.highest == 4000
    flat = np.full(mosaic.shape, 7, np.uint16)
    assert not any(point.admitted for point in patch_points([flat], [Box()], cfa="RGGB", white_dn=None))
