"""Charts in a study, masked pixels, frames that say nothing of their exposure, channels that differ."""

import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import tifffile

from fullwell.errors import UsageError
from fullwell.figures.dynamic_range import dynamic_range
from fullwell.figures.results import Row
from fullwell.figures.saturation import temporal_variance_peak
from fullwell.figures.snr import snr_maximum
from fullwell.frames.chart.locate import Located
from fullwell.frames.images import load_images
from fullwell.frames.selection import Selection
from fullwell.frames.series import Kind
from fullwell.frames.study import load_study
from fullwell.raw.image import Area, RawHeader
from fullwell.units import DN, DN_PER_SECOND, Measured
from fullwell.workflow.chart import patches
from fullwell.workflow.chart.chart import ChartOptions, chart, measure_chart_folders, measure_images
from fullwell.workflow.chart.patches import WhereAbouts
from fullwell.workflow.masked import masked_area, masked_sums
from fullwell.workflow.measure.chart.shots import code_step, holder
from fullwell.workflow.measure.dynamic_range import NoiseModel, ratio_rows
from fullwell.workflow.options import Options

sys.path.insert(0, str(Path(__file__).parents[1] / "acceptance"))
from chart_simulation import Camera, Chart

CHART = Chart(edge=30, gap=6)
OPTIONS = Options(workers=1)


@pytest.fixture(scope="module")
def camera() -> Camera:
    return Camera(CHART, seed=21)


def rows_of(rows, quantity, channel, method):
    return [row for row in rows if (row.quantity, row.channel, row.method) == (quantity, channel, method)]


def codes(findings):
    return {finding.code for finding in findings}


def asked(folder, **more):
    return ChartOptions(where=WhereAbouts(patches=(folder / "patches.csv",)), **more)


def write_tiff(path, mosaic):
    tifffile.imwrite(path, mosaic, photometric="minisblack", metadata=None)
    return path


def test_exposures_nobody_declares_are_told_apart_by_their_levels(camera, tmp_path):
    camera.write_patches(tmp_path / "patches.csv")
    images = [
        write_tiff(tmp_path / f"{index}.tif", camera.frame(exposure))
        for index, exposure in enumerate((1.0, 1 / 8, 1.0, 1 / 8))
    ]
    selection = Selection(cfa="RGGB", white_level=16383.0)
    options = Options(selection=selection, workers=1)
    study = load_images(images, selection, kind=Kind.CHART)
    outcome, _ = measure_images(study, options=options, asked=asked(tmp_path))
    (scene,) = outcome.measurements[0].shots.scenes
    assert [one.files for one in scene.exposures] == [("0.tif", "2.tif"), ("1.tif", "3.tif")]
    (level,) = rows_of(outcome.section.rows, "black_level", "all", "fused")
    assert abs(level.measured.value - CHART.offset) < 4 * level.measured.std_error


def test_without_any_level_the_published_one_stands_in_and_says_so(camera, tmp_path):
    camera.write_patches(tmp_path / "patches.csv")
    image = write_tiff(tmp_path / "0.tif", camera.frame(1.0))
    selection = Selection(cfa="RGGB", white_level=16383.0)
    study = load_images([image], selection, kind=Kind.CHART)
    outcome, _ = measure_images(study, options=Options(selection=selection, workers=1), asked=asked(tmp_path))
    (level,) = rows_of(outcome.section.rows, "black_level", "all", "fused")
    assert "offset-not-identified" in level.flags
    assert level.measured.ci95[0] < CHART.offset < level.measured.ci95[1]
    (dark,) = rows_of(outcome.section.rows, "k_dark", "all", "gamma-likelihood")
    assert dark.measured.ci95[0] < CHART.k_dark < dark.measured.ci95[1]


def test_white_level_nobody_tells_is_that_of_the_bits_seen(camera, tmp_path):
    camera.write_patches(tmp_path / "patches.csv")
    image = write_tiff(tmp_path / "0.tif", camera.frame(1.0))
    study = load_images([image], Selection(cfa="RGGB"), kind=Kind.CHART)
    outcome, _ = measure_images(study, options=OPTIONS, asked=asked(tmp_path))
    assert outcome.measurements[0].levels.digital_maximum == CHART.maximum
    assert "white-level-unknown" in codes(outcome.section.findings)


def test_of_noise_that_falls_with_the_signal_no_level_is_said_to_make_sense(tmp_path):
    """As of patches that lie across the borders of dark fields."""
    rng = np.random.default_rng(2)
    levels = np.repeat(np.repeat(np.linspace(100.0, 800.0, 8), 32)[None], 32, axis=0)
    mosaic = 64.0 + levels + rng.normal(0.0, 20.0 - levels / 50.0)
    lines = [f"{at},{32 * at},0,32,32" for at in range(8)]
    (tmp_path / "patches.csv").write_text("\n".join(["patch,x,y,width,height", *lines]) + "\n")
    path = write_tiff(tmp_path / "shot.tif", np.rint(mosaic).astype(np.uint16))
    selection = Selection(cfa="RGGB", white_level=4095.0)
    study = load_images([path], selection, kind=Kind.CHART)
    outcome, _ = measure_images(study, options=Options(selection=selection, workers=1), asked=asked(tmp_path))
    (said,) = (one.message for one in outcome.section.findings if one.code == "offset-not-identified")
    assert "no level makes sense of the patches" in said
    assert "fits as well" not in said


def dark_levels(level_dn):
    """Return what dark frames tell of the black level."""
    return [
        Row(
            quantity="black_level",
            channel=channel,
            method="dark-frames" if channel != "all" else "fused",
            measured=Measured.normal(level_dn, 0.01, DN),
            iso=100.0,
            flags=("recommended",) if channel == "all" else (),
        )
        for channel in ("R", "G1", "G2", "B", "all")
    ]


def test_dark_current_of_the_exposure_is_no_stray_light(camera, tmp_path):
    """Of a constant of the patches, the black level is one part; the other is dark current or stray light."""
    folder = tmp_path / "study" / "chart"
    folder.mkdir(parents=True)
    camera.write(folder / "0.dng", 1.0)
    camera.write_patches(folder / "PATCHES.csv")
    study = load_study(tmp_path / "study", Selection())
    dark_dn, exposure_s = 2.0, study.series[0].exposure_s
    levels = dark_levels(CHART.offset - dark_dn)
    rates = [
        replace(
            row,
            quantity="dark_current",
            method="mean-slope",
            measured=Measured.normal(dark_dn / exposure_s, 0.01 / exposure_s, DN_PER_SECOND),
            flags=("recommended",),
        )
        for row in levels
    ]

    def flare(study, told):
        outcome = measure_chart_folders(study, told, options=OPTIONS)
        (said,) = (one.message for one in outcome.section.findings if one.code == "stray-light")
        (row,) = rows_of(outcome.section.rows, "flare", "all", "density-fit")
        reach = rows_of(outcome.section.rows, "camera_dynamic_range", "all", "scene-referenced")
        return row.measured, said, [row.measured for row in reach]

    both, said_of_both, reach_with_both = flare(study, levels)
    light, said_of_light, reach = flare(study, [*levels, *rates])
    assert both.value - CHART.flare > 10 * both.std_error
    assert abs(light.value - CHART.flare) < 4 * light.std_error
    assert "dark current of the exposure included" in said_of_both
    assert "dark current of the exposure taken off" in said_of_light
    assert reach_with_both == reach
    cold = replace(study, series=tuple(replace(one, temperature_c=20.0) for one in study.series))
    warm = [replace(row, temperature_c=60.0) for row in rates]
    assert flare(cold, [*levels, *warm])[0] == both


def test_charts_of_a_study_use_its_dark_frames_and_leave_its_figures_alone(camera, tmp_path):
    folder = tmp_path / "study" / "chart"
    folder.mkdir(parents=True)
    camera.write(folder / "0.dng", 1.0)
    camera.write_patches(folder / "PATCHES.csv")
    study = load_study(tmp_path / "study", Selection())
    alone = measure_chart_folders(study, (), options=OPTIONS)
    assert "offset-not-identified" in codes(alone.section.findings)
    outcome = measure_chart_folders(study, dark_levels(CHART.offset), options=OPTIONS)
    assert "offset-not-identified" not in codes(outcome.section.findings)
    assert rows_of(outcome.section.rows, "flare", "all", "density-fit")
    (level,) = rows_of(outcome.section.rows, "black_level", "all", "fused")
    assert level.region == "chart"
    assert "recommended" not in level.flags
    (gain,) = rows_of(outcome.section.rows, "system_gain", "all", "photon-transfer")
    assert gain.region is None
    assert "recommended" in gain.flags


def test_patches_of_the_whole_frame_are_found_in_a_region_of_it(camera, tmp_path):
    camera.write_patches(tmp_path / "patches.csv")
    image = write_tiff(tmp_path / "0.tif", camera.frame(1.0))
    height, width = camera.shape

    def rows(x, y):
        crop = None if (x, y) == (0, 0) else (x, y, width - x, height - y)
        selection = Selection(cfa="RGGB", white_level=16383.0, crop=crop)
        study = load_images([image], selection, kind=Kind.CHART)
        outcome, _ = measure_images(study, options=Options(selection=selection, workers=1), asked=asked(tmp_path))
        return [row for row in outcome.section.rows if row.quantity != "white_level"]

    left = min(x for x, _, _ in camera.places()) // 2 * 2
    assert left >= 2
    assert rows(2, 2) == rows(0, 0)
    with pytest.raises(UsageError, match=r"--crop 1,2,.*: give even X and Y"):
        rows(1, 2)
    with pytest.raises(UsageError, match=r"Patch P1 .* reaches out of --crop"):
        rows(left + 2, 0)


def test_corners_of_the_whole_frame_are_those_of_a_region_of_it(camera, tmp_path, monkeypatch):
    image = write_tiff(tmp_path / "0.tif", camera.frame(1.0))
    height, width = camera.shape
    crop = (8, 4, width - 8, height - 4)
    study = load_images([image], Selection(cfa="RGGB", crop=crop), kind=Kind.CHART)
    frames = [(series, frame) for series in study.series for frame in series.frames]
    used = []

    def locate(mosaic, *, corners, **_):
        used.append((mosaic.shape, corners))
        return Located(patches=(), confidence=0.0, corners=(), orientation=0, reason="Nothing like it.")

    monkeypatch.setattr(patches, "locate", locate)
    where = WhereAbouts(chart="colorchecker-classic", corners=((20, 10), (220, 10), (220, 150), (20, 150)))
    with pytest.raises(UsageError, match=r"^0\.tif: nothing like it\.$"):
        patches.place(study, [frames], where, crop=crop)
    assert used == [((height - 4, width - 8), ((12, 6), (212, 6), (212, 146), (12, 146)))]


def test_stray_light_is_a_share_of_the_lightest_patch_where_that_clips(tmp_path):
    """As the guide wants it shot: flare was a share of the next patch, 77 % too high."""
    chart = replace(CHART, brightest=1.1)
    clipping = Camera(chart, seed=34)
    images = [clipping.write(tmp_path / f"{index}.dng", exposure) for index, exposure in enumerate((1.0, 1 / 8))]
    clipping.write_patches(tmp_path / "patches.csv")
    study = load_images(images, Selection(), kind=Kind.CHART)
    outcome, _ = measure_images(study, options=OPTIONS, asked=asked(tmp_path))
    for channel in ("R", "G1", "all"):
        (flare,) = rows_of(outcome.section.rows, "flare", channel, "density-fit")
        assert abs(flare.measured.value - chart.flare) < 4.0 * flare.measured.std_error, channel


def test_channels_err_alike_where_patches_differ_from_their_densities(camera, tmp_path):
    images = [camera.write(tmp_path / f"{index}.dng", exposure) for index, exposure in enumerate((1.0, 1 / 8))]
    wrong = CHART.densities + np.random.default_rng(35).normal(0.0, 0.02, CHART.densities.size)
    camera.write_patches(tmp_path / "patches.csv", densities=np.maximum(wrong, 0.0))
    study = load_images(images, Selection(), kind=Kind.CHART)
    outcome, _ = measure_images(study, options=OPTIONS, asked=asked(tmp_path))
    own = [rows_of(outcome.section.rows, "flare", channel, "density-fit")[0] for channel in ("R", "G1", "G2", "B")]
    (flare,) = rows_of(outcome.section.rows, "flare", "all", "density-fit")
    assert flare.measured.std_error >= min(one.measured.std_error for one in own)


@pytest.mark.parametrize("truth_dn", [11950.0, 14000.0, 15900.0])
def test_ranges_reach_over_the_bracket_that_saturation_was_read_off(truth_dn):
    """Patches at 11.9, 12 and 16 kDN, as of two channels: full somewhere between; intervals ended at 14.6 kDN."""
    peak = temporal_variance_peak([11.9e3, 12e3, 16e3], [5.9e3, 6e3, 10.0], [0.0, 0.0, 1.0], std_error_dn=5.0)
    coefficients, covariance = np.array([1.1, 0.5, 1.6e-5]), np.diag([0.02, 0.002, 2e-7]) ** 2
    model = NoiseModel(coefficients=coefficients, covariance=covariance, dof=None)
    rows = ratio_rows(holder(iso=100.0, temperature_c=None, channels=("mono",)), "mono", model, peak, thresholds=[1.0])
    exact = Measured.exact(truth_dn, DN)
    maxima, reach = snr_maximum(coefficients, covariance, exact), dynamic_range(coefficients, covariance, exact).range
    truths = {"noise-model": maxima.total, "shot-only": maxima.shot_only}
    for row in rows:
        found = reach if row.quantity == "dynamic_range" else truths[row.method]
        truth = {"dB": found.decibel, "EV": found.stops, "1": found.plain}[row.measured.unit].value
        assert row.measured.ci95[0] < truth < row.measured.ci95[1], row
    assert len(rows) == 7


def test_without_saturation_every_range_is_a_bound_without_an_interval(tmp_path):
    camera = Camera(replace(CHART, brightest=0.5), seed=3)
    camera.write_patches(tmp_path / "patches.csv")
    image = write_tiff(tmp_path / "0.tif", camera.frame(1.0))
    selection = Selection(cfa="RGGB", white_level=16383.0)
    study = load_images([image], selection, kind=Kind.CHART)
    outcome, _ = measure_images(study, options=Options(selection=selection, workers=1), asked=asked(tmp_path))
    rows = [row for row in outcome.section.rows if row.quantity in {"saturation_capacity", "dynamic_range"}]
    assert {"last-consistent-level", "legacy-max-noise-patch", "legacy-patch"} < {row.method for row in rows}
    assert {"all", "G1"} < {row.channel for row in rows}
    assert all("lower-bound" in row.flags for row in rows)
    assert all(row.measured.ci95 is None and row.measured.std_error is None for row in rows)


def test_bad_patches_in_a_study_are_a_finding(camera, tmp_path):
    folder = tmp_path / "study" / "charts" / "one"
    folder.mkdir(parents=True)
    camera.write(folder / "0.dng", 1.0)
    (folder / "patches.csv").write_text("patch,x,y,width,height\nA,0,0,20,20\n")
    outcome = measure_chart_folders(load_study(tmp_path / "study", Selection()), (), options=OPTIONS)
    assert codes(outcome.section.findings) == {"patches-unusable"}
    assert not outcome.section.rows


def test_a_scaled_channel_is_seen(camera, tmp_path):
    """Digital white balance in the file: red multiplied by 1.5 after conversion."""
    camera.write_patches(tmp_path / "patches.csv")
    images = []
    for index, exposure in enumerate((0.6, 0.075)):
        mosaic = camera.frame(exposure).astype(float)
        mosaic[::2, ::2] = (mosaic[::2, ::2] - CHART.offset) * 1.5 + CHART.offset
        images.append(write_tiff(tmp_path / f"{index}.tif", np.rint(mosaic).clip(0, 16383).astype(np.uint16)))
    selection = Selection(cfa="RGGB", white_level=16383.0)
    study = load_images(images, selection, kind=Kind.CHART)
    outcome, _ = measure_images(study, options=Options(selection=selection, workers=1), asked=asked(tmp_path))
    (finding,) = (one for one in outcome.section.findings if one.code == "channels-differ")
    assert "digital scaling" in finding.message
    (gain,) = rows_of(outcome.section.rows, "system_gain", "all", "photon-transfer")
    assert "channels-differ" in gain.flags


def test_isos_must_agree(camera, tmp_path):
    camera.write_patches(tmp_path / "patches.csv")
    for iso in (100, 200):
        (tmp_path / f"ISO_{iso}").mkdir()
        write_tiff(tmp_path / f"ISO_{iso}" / "a.tif", camera.frame(1.0))
    images = sorted(tmp_path.rglob("*.tif"))
    with pytest.raises(UsageError, match="different ISOs"):
        chart(
            images,
            tmp_path / "out",
            options=Options(selection=Selection(cfa="RGGB"), workers=1),
            asked=asked(tmp_path),
        )
    assert not (tmp_path / "out").exists()


def header(mosaic: np.ndarray, **more) -> RawHeader:
    height, width = mosaic.shape
    path = Path("memory.raw")
    return RawHeader(
        path=path,
        format="dng",
        raw_width=width,
        raw_height=height,
        active_area=Area(26, 40, height, width),
        cfa="RGGB",
        bit_depth=14,
        **more,
    )


def test_masked_pixels_are_read_per_site_and_believed_as_far_as_their_lines_agree(monkeypatch):
    """Margins of 26 rows and 40 columns, row noise of 2 DN: the error of the mean is that of the rows."""
    rng = np.random.default_rng(4)
    whole = np.full((426, 640), 3000.0)
    dark = np.add.outer(2.0 * rng.standard_normal(426), np.zeros(640)) + 3.0 * rng.standard_normal((426, 640)) + 512.0
    site = np.array([[0.0, 10.0], [20.0, 30.0]])
    dark += np.tile(site, (213, 320))
    whole[:, :40], whole[:26] = dark[:, :40], dark[:26]
    mosaic = np.rint(whole).astype(np.uint16)

    def crop(one, _data):
        area = one.active_area
        return mosaic[area.top : area.bottom, area.left : area.right]

    monkeypatch.setattr("fullwell.workflow.masked.decode", crop)
    sums = masked_sums(header(mosaic), b"")
    pooled = masked_area([sums, sums], ("R", "G1", "G2", "B"))
    assert [one.channel for one in pooled] == ["R", "G1", "G2", "B"]
    for one, offset in zip(pooled, site.ravel(), strict=True):
        assert not one.declared
        assert abs(one.mean_dn - 512.0 - offset) < 4 * one.std_error_dn
        assert 2.0 / np.sqrt(213) < one.std_error_dn < 2.0
    declared = masked_sums(replace(header(mosaic), masked_areas=(Area(30, 0, 426, 40),)), b"")
    assert {one.declared for one in declared} == {True}
    assert not masked_sums(replace(header(mosaic), active_area=Area(0, 0, 426, 640)), b"")


def test_step_of_codes_is_found_whatever_it_is(camera):
    from fullwell.statistics.series import Histogram  # noqa: PLC0415

    counts = np.bincount(camera.frame(1.0)[::2, ::2].ravel() // 16 * 3)
    assert code_step([Histogram(first_code=0, counts=counts, frames=1)]) == 3
