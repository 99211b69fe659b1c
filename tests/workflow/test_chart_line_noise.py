"""Rows and columns of noise in shots of a chart: variances, means of patches, and the figures that rest on them."""

import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from fullwell.frames.chart.patches import Patch
from fullwell.frames.images import load_images
from fullwell.frames.selection import Selection
from fullwell.frames.series import Kind
from fullwell.statistics.chart import patch_points
from fullwell.workflow.chart.chart import ChartOptions, measure_images
from fullwell.workflow.chart.patches import WhereAbouts
from fullwell.workflow.measure.chart.line_noise import Lines, line_noise
from fullwell.workflow.options import Options

sys.path.insert(0, str(Path(__file__).parents[1] / "acceptance"))
from chart_simulation import Camera, Chart, write_dng

PATCHES = tuple(
    Patch(name=str(index), x=x, y=y, width=width, height=24)
    for index, (x, y, width) in enumerate(((0, 0, 24), (30, 0, 30), (0, 12, 24), (66, 40, 24)))
)
ROW, FIXED, PIXEL = 4.0, 3.0, 6.0


def _frames(rng, count, *, row=ROW, fixed=FIXED):
    """Frames with rows of noise, a fixed pattern of rows and white noise, RGGB."""
    shape = (64, 90)
    pattern = 1000.0 + fixed * rng.standard_normal((shape[0], 1))
    return [
        np.rint(pattern + row * rng.standard_normal((shape[0], 1)) + PIXEL * rng.standard_normal(shape)).astype(
            np.uint16
        )
        for _ in range(count)
    ]


def test_lines_are_told_apart_and_what_a_surface_takes_of_them_is_given_back():
    rng = np.random.default_rng(51)
    whole, moving, temporal, spatial = [], [], [], []
    for _ in range(150):
        points = patch_points(_frames(rng, 3), PATCHES, cfa="RGGB", white_dn=None)
        lines = line_noise(points)
        whole.append(lines.row.whole_dn2)
        moving.append(lines.row.moving_dn2)
        temporal.append(np.mean([one.temporal_variance_dn2 + lines.lost(one, between=True) for one in points]))
        spatial.append(np.mean([one.spatial_variance_dn2 + lines.lost(one) for one in points]))
    rounding = 1 / 12
    for found, truth in (
        (whole, ROW**2 + FIXED**2),
        (moving, ROW**2),
        (temporal, ROW**2 + PIXEL**2 + rounding),
        (spatial, (ROW**2 + PIXEL**2 + rounding) / 3 + FIXED**2),
    ):
        assert abs(np.mean(found) - truth) <= 4.0 * np.std(found) / np.sqrt(len(found))


def test_means_of_patches_scatter_together_as_their_rows_say():
    """Two shots of one frame, then two: covariance of the means of overlapping and of other planes, by simulation."""
    rng = np.random.default_rng(52)
    exposures = [patch_points(_frames(rng, count), PATCHES, cfa="RGGB", white_dn=None) for count in (2, 1)]
    lines = replace(line_noise([one for points in exposures for one in points]), column=Lines())
    expected = lines.of_means(exposures, PATCHES, cfa="RGGB")
    scale = lines.row.moving_dn2 / 2 + lines.row.fixed_dn2
    count = len(exposures[0])
    assert expected.shape == (2, count, 2, count)
    names = [(one.patch, one.channel) for one in exposures[0]]
    red, beside, blue, lower = (names.index(pair) for pair in (("0", "R"), ("1", "G1"), ("1", "B"), ("2", "R")))
    assert expected[0, red, 0, red] == pytest.approx(scale / 12)
    assert expected[0, red, 0, beside] == pytest.approx(scale / 12)
    assert expected[0, red, 0, lower] == pytest.approx(scale * 6 / 144)
    assert expected[0, red, 0, blue] == 0.0
    assert expected[0, red, 1, red] == pytest.approx(lines.row.fixed_dn2 / 12)
    assert expected[1, red, 1, red] == pytest.approx((lines.row.moving_dn2 + lines.row.fixed_dn2) / 12)


def test_rows_too_weak_to_be_seen_are_in_the_errors_of_means():
    """A tenth of the pixels' noise: hardly ever seen, yet a tenth of the variance of a mean, shared by patches."""
    rng = np.random.default_rng(53)
    weak, counted, seen = 0.1 * PIXEL, [], 0
    for _ in range(100):
        points = patch_points(_frames(rng, 2, row=weak, fixed=0.0), PATCHES, cfa="RGGB", white_dn=None)
        lines = line_noise(points)
        seen += lines.row.seen
        counted.append(lines.of_means([points], PATCHES, cfa="RGGB")[0, 0, 0, 4])
        assert lines.row.seen or lines.lost(points[0]) == 0.0 or lines.column.seen
    assert seen < 50
    # patches 0 and 1 have their rows in common, of which a plane has 12
    assert np.mean(counted) >= weak**2 / 2 / 12 - 4.0 * np.std(counted) / np.sqrt(len(counted))


class _Rowed(Camera):
    """A camera whose rows have noise in common, a share of its read noise."""

    share = 0.3

    def frame(self, exposure: float) -> np.ndarray:
        rows = self.share * self.read_noise * self.rng.standard_normal((self.shape[0], 1))
        clean = super().frame(exposure).astype(np.float64)
        return np.clip(np.rint(clean + rows), 0, self.chart.maximum).astype(np.uint16)


def _rows_of(camera, folder):
    """Shoot a chart at two exposures and return what is measured, by quantity and channel."""
    folder.mkdir()
    camera.write_patches(folder / "patches.csv")
    images = [folder / f"{index}.dng" for index in range(2)]
    for path, exposure in zip(images, (1.0, 1 / 8), strict=True):
        write_dng(path, camera.frame(exposure), exposure_s=exposure / 50, black=512, white=16383)
    study = load_images(images, Selection(), kind=Kind.CHART)
    asked = ChartOptions(where=WhereAbouts(patches=(folder / "patches.csv",)))
    outcome, _ = measure_images(study, options=Options(workers=1), asked=asked)
    return {(row.quantity, row.channel, row.method): row.measured for row in outcome.section.rows}


def test_the_black_level_covers_where_rows_have_noise_in_common(tmp_path):
    """Sixteen cameras: errors of pixels alone were 2.5 times too small."""
    chart = Chart(edge=30, gap=6)
    pulls = []
    for seed in range(16):
        level = _rows_of(_Rowed(chart, seed=60 + seed), tmp_path / str(seed))["black_level", "all", "exposure-bracket"]
        pulls.append((level.value - chart.offset) / level.std_error)
    assert np.sum(np.square(pulls)) <= 39.3  # chi-square of 16 at 0.1 %


def test_dark_noise_covers_where_most_of_it_is_of_rows(tmp_path):
    """Twelve cameras with three quarters of the read noise in rows: 30 to 55 % of intervals were true, now 95 to 97.

    Nine patches beside each other, of four channels two and two, see the same rows; and weights by the variance that
    was found in a patch made the noise 3 % too large.
    """
    chart = Chart(edge=30, gap=6)
    pulls = []
    for seed in range(12):
        camera = _Rowed(chart, seed=100 + seed)
        camera.share = 0.75
        found = _rows_of(camera, tmp_path / str(seed))
        rows_dn2 = (camera.share * camera.read_noise) ** 2 + 1.0 / 12.0  # their frames are rounded once more
        truth = chart.k_dark**2 + rows_dn2 / chart.maximum**2
        dark = [found["k_dark_variance", channel, "gamma-likelihood"] for channel in ("G1", "all")]
        pulls.append([(one.value - truth) / one.std_error for one in dark])
    assert np.all(np.sum(np.square(pulls), axis=0) <= 32.9)  # chi-square of 12 at 0.1 %
