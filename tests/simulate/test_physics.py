"""Each process of the sensor does what its parameter says, and all of them together depend on no tile and no worker."""

import json
import tracemalloc
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.special import ndtr

from fullwell.errors import UsageError
from fullwell.raw.open import read_raw
from fullwell.simulate.camera import camera_of, take
from fullwell.simulate.geometry import Tile
from fullwell.simulate.shot import Exposure
from fullwell.simulate.truth import true_values
from fullwell.testing import simulated_study, simulation

SIGMAS = 5.0
QUIET = {
    "cfa": "mono",
    "channel_response": {},
    "black_level": 1000.0,
    "bit_depth": 16,
    "white_level": 65535,
    "system_gain": 1.0,
    "full_well": 50000.0,
    "read_noise": 0.0,
    "read_noise_row": 0.0,
    "dark_current": 0.0,
    "dsnu": 0.0,
    "prnu": 0.0,
}
DARK = {"dark": {"exposures_s": [2.0], "frames": 1}}
EVERYTHING = {
    "width": 66,
    "height": 48,
    "rts_pixels": 0.05,
    "rts_amplitude": 6.0,
    "read_noise_column": 0.2,
    "read_noise_frame": 0.1,
    "read_noise_post": 0.4,
    "dark_current_spread": 1.0,
    "hot_pixels": 0.01,
    "hot_pixel_current": 50.0,
    "dsnu_row": 0.2,
    "dsnu_column": 0.2,
    "prnu_row": 0.2,
    "prnu_column": 0.2,
    "nonlinearity": 1.0,
    "dual_conversion_ratio": 4.0,
}


def frames(camera, exposure, count):
    return (
        np.array([take(camera, replace(exposure, frame=number)) for number in range(count)], dtype=np.float64) - 1000.0
    )


@settings(max_examples=12)
@given(
    rows=st.lists(st.integers(1, 51), max_size=4, unique=True),
    columns=st.lists(st.integers(1, 73), max_size=4, unique=True),
    order=st.randoms(use_true_random=False),
    subject=st.sampled_from(["flat", "patches", "star", "chart"]),
)
def test_no_cover_changes_a_bit_whatever_the_sensor_does(rows, columns, order, subject) -> None:
    config = simulation(
        camera=EVERYTHING,
        lens={"shading": "cos4", "flare": 0.01, "defocus": 1.3},
        chart={"densities": [0.0, 0.5, 1.0, 1.5], "fill": 1.0, "margin": 0.0},
        study={**DARK, "chart": {"exposures_s": [0.1], "electrons": [10.0]}},
        output={"optical_black": {"left": 8, "top": 4}},
    )
    camera = camera_of(config)
    exposure = Exposure(iso=100.0, exposure_s=0.5, electrons=3000.0, subject=subject, frame=2)
    tops, lefts = [0, *sorted(rows), 52], [0, *sorted(columns), 74]
    cover = [
        Tile(top=top, left=left, bottom=bottom, right=right)
        for top, bottom in pairwise(tops)
        for left, right in pairwise(lefts)
    ]
    order.shuffle(cover)
    assert np.array_equal(take(camera, exposure), take(camera, exposure, cover))


def test_rows_and_columns_of_the_fixed_pattern_have_their_spread() -> None:
    config = simulation(camera={**QUIET, "dsnu_row": 3.0, "dsnu_column": 2.0, "dsnu": 1.0}, study=DARK)
    dark = take(camera_of(config), Exposure(iso=100.0, exposure_s=0.0)).astype(np.float64)
    rows, columns = dark.shape
    rest = dark - dark.mean(axis=1, keepdims=True) - dark.mean(axis=0) + dark.mean()
    for found, expected, count in (
        (dark.mean(axis=1).var(ddof=1), 9.0 + 1.083 / columns, rows),
        (dark.mean(axis=0).var(ddof=1), 4.0 + 1.083 / rows, columns),
        ((rest**2).sum() / ((rows - 1) * (columns - 1)), 1.0 + 1.0 / 12.0, rest.size),
    ):
        assert abs(found - expected) < SIGMAS * expected * np.sqrt(2.0 / (count - 1))


def test_dark_current_has_its_mean_its_spread_and_its_temperature() -> None:
    camera = {**QUIET, "dark_current": 200.0, "dark_current_spread": 60.0, "dark_current_doubling_c": 7.0}
    config = simulation(camera=camera, study={**DARK, "temperature_c": 27.0})
    made = camera_of(config)
    n = made.individual.dark_current.size
    burst = frames(made, Exposure(iso=100.0, exposure_s=2.0, temperature_c=27.0), 6)
    mean = 2.0 * 400.0
    assert abs(burst.mean() - mean) < SIGMAS * np.sqrt(mean / (6 * n))
    map_variance = burst.mean(axis=0).var() - burst.var(axis=0, ddof=1).mean() / 6
    # a log-normal law of this width has a kurtosis below 6
    assert abs(map_variance - (2.0 * 120.0) ** 2) < SIGMAS * (2.0 * 120.0) ** 2 * np.sqrt(5.0 / n)
    truth = {(one.quantity, one.unit): one.value for one in true_values(config)}
    assert truth["dark_current", "e-/s"] == pytest.approx(400.0)
    assert truth["dsnu", "e-"] == pytest.approx(240.0)


def test_hot_pixels_are_as_many_and_as_hot_as_asked_for() -> None:
    config = simulation(camera={**QUIET, "hot_pixels": 0.01, "hot_pixel_current": 500.0}, study=DARK)
    rate = camera_of(config).individual.dark_current
    assert (rate > 0.0).sum() == round(0.01 * rate.size)
    assert rate.sum(dtype=np.float64) == pytest.approx(500.0 * (rate > 0.0).sum(), rel=1e-6)
    truth = {(one.quantity, one.unit) for one in true_values(config)}
    assert ("dark_current", "e-/s") in truth
    assert ("dsnu", "e-") not in truth


def test_margins_take_nothing_from_the_visible_sensor() -> None:
    """Levels and responses of the visible planes are those of the config, whatever lies beside them."""
    camera = {"dark_current_spread": 1.0, "hot_pixels": 0.01, "hot_pixel_current": 500.0, "prnu_row": 0.3}
    config = simulation(camera=camera, output={"optical_black": {"left": 32, "top": 16, "right": 6}}, study=DARK)
    made = camera_of(config)
    visible = (slice(16, None), slice(32, -6))
    rate = made.individual.dark_current[visible]
    sensor = config.sensor
    for site in range(4):
        plane = np.s_[site // 2 :: 2, site % 2 :: 2]
        hot = round(0.01 * rate[plane].size)
        mean = sensor.dark_current + 500.0 * hot / rate[plane].size
        assert rate[plane].mean(dtype=np.float64) == pytest.approx(mean, rel=1e-6)
        assert abs(made.individual.prnu[visible][plane].mean(dtype=np.float64)) < 1e-6
    rows = made.individual.prnu_row[16:, 0]
    assert max(abs(float(rows[first::2].mean(dtype=np.float64))) for first in range(2)) < 1e-6


def test_random_telegraph_pixels_jump_and_add_their_variance() -> None:
    config = simulation(camera={**QUIET, "rts_pixels": 0.02, "rts_amplitude": 20.0}, study=DARK)
    camera = camera_of(config)
    burst = frames(camera, Exposure(iso=100.0, exposure_s=0.0), 40)
    jumping = camera.individual.jumping > 0.0
    assert jumping.sum() == round(0.02 * jumping.size)
    assert np.all(burst[:, ~jumping] == 0.0)
    assert set(np.unique(burst[:, jumping])) == {-20.0, 20.0}
    assert abs((burst[:, jumping] > 0).mean() - 0.5) < SIGMAS * 0.5 / np.sqrt(40 * jumping.sum())
    truth = {(one.quantity, one.unit): one.value for one in true_values(config)}
    assert truth["read_noise_variance", "e-^2"] == pytest.approx(0.02 * 400.0)


def test_brighter_fatter_moves_variance_into_covariances_and_loses_no_charge() -> None:
    level, a = 20000.0, 2e-6
    config = simulation(camera={**QUIET, "width": 256, "height": 256, "brighter_fatter": a}, study=DARK)
    burst = frames(camera_of(config), Exposure(iso=100.0, exposure_s=0.0, electrons=level), 8)
    n = burst.size
    assert abs(burst.mean() - level) < SIGMAS * np.sqrt(level / n)
    deviation = burst - level
    share = a * level
    # to first order 1 - a N; the squares of the four shares are left: 5 (a N / 8)^2 x 4
    variance = (1.0 - share / 2.0) ** 2 + 4.0 * (share / 8.0) ** 2
    assert abs((deviation**2).mean() / level - variance) < SIGMAS * np.sqrt(2.0 / n)
    assert variance == pytest.approx(1.0 - share, abs=0.002)
    beside = (deviation[:, :, 1:] * deviation[:, :, :-1]).mean() / level
    assert abs(beside - share / 4.0 * (1.0 - share / 2.0)) < SIGMAS / np.sqrt(n)


def test_blooming_fills_the_column_and_keeps_the_charge() -> None:
    camera = {**QUIET, "full_well": 1000.0, "blooming": 1.0, "hot_pixels": 0.001, "hot_pixel_current": 8000.0}
    made = camera_of(simulation(camera=camera, study=DARK))
    still = camera_of(simulation(camera={**camera, "full_well": 40000.0, "blooming": 0.0}, study=DARK))
    exposure = Exposure(iso=100.0, exposure_s=0.5)
    bloomed, plain = (take(one, exposure).astype(np.float64) - 1000.0 for one in (made, still))
    assert plain.max() > 3000.0
    assert bloomed.max() == 1000.0
    inner = plain[:, plain[:20].sum(axis=0) + plain[-20:].sum(axis=0) == 0.0].sum(axis=0)
    kept = bloomed[:, plain[:20].sum(axis=0) + plain[-20:].sum(axis=0) == 0.0].sum(axis=0)
    assert np.abs(kept - inner).max() <= bloomed.shape[0] * 0.5  # each pixel is rounded once
    assert (kept > 1000.0).any()


def test_the_response_bends_as_asked_for() -> None:
    config = simulation(camera={**QUIET, "nonlinearity": 2.0}, study=DARK)
    burst = frames(camera_of(config), Exposure(iso=100.0, exposure_s=0.0, electrons=40000.0), 2)
    expected = 40000.0 - 0.02 / 50000.0 * (40000.0**2 + 40000.0)
    assert abs(burst.mean() - expected) < SIGMAS * np.sqrt(40000.0 / burst.size)
    assert "prnu" not in {one.quantity for one in true_values(config)}


def test_two_amplifications_step_coarsely_in_the_bright_half() -> None:
    camera = {**QUIET, "dual_conversion_ratio": 8.0, "read_noise_post": 16.0}
    made = camera_of(simulation(camera=camera, study=DARK))
    dim = frames(made, Exposure(iso=100.0, exposure_s=0.0, electrons=500.0), 2)
    bright = frames(made, Exposure(iso=100.0, exposure_s=0.0, electrons=30000.0), 2)
    n = dim.size
    assert abs(dim.var() - (500.0 + 4.0 + 1.0 / 12.0)) < SIGMAS * 504.0 * np.sqrt(2.0 / n)
    assert np.all(bright % 8.0 == 0.0)
    assert abs(bright.var() - (30000.0 + 256.0 + 64.0 / 12.0)) < SIGMAS * 30262.0 * np.sqrt(2.0 / n)


def test_companded_codes_come_back_linear_from_their_table(tmp_path: Path) -> None:
    study = {"flat": {"exposures_s": [0.001], "electrons": [3000.0], "frames": 2}}
    plain = simulated_study(tmp_path / "plain", simulation(study=study))
    small = simulated_study(tmp_path / "small", simulation(study=study, output={"companding_bits": 9}))
    for frame in plain.frames:
        linear, companded = (read_raw(one.root / f"{frame.name}.dng") for one in (plain, small))
        table = np.array([c + (4095.0 - 511.0) * (c / 511.0) ** 2 for c in range(512)]).round()
        assert set(np.unique(companded.mosaic)) <= set(table)
        step = np.diff(table).max()
        apart = companded.mosaic.astype(np.float64) - linear.mosaic
        assert np.abs(apart).max() <= step / 2.0 + 0.5


def test_margins_see_no_light_and_are_told_of(tmp_path: Path) -> None:
    output = {"optical_black": {"left": 12, "top": 6, "bottom": 2}}
    study = simulated_study(
        tmp_path / "study",
        simulation(lens={"flare": 0.05}, output=output, study={"flat": {"exposures_s": [1.0], "electrons": [2000.0]}}),
    )
    raw = read_raw(study.root / f"{study.frames[0].name}.dng")
    assert raw.mosaic.shape == (128, 192)
    header = raw.header
    assert tuple(header.active_area) == (6, 12, 134, 204)
    assert (
        sum((area.bottom - area.top) * (area.right - area.left) for area in header.masked_areas)
        == 136 * 204 - 128 * 192
    )
    stored = take(camera_of(study.config), study.frames[0].exposure).astype(np.float64)
    masked = stored[:, :12]
    assert abs(masked.mean() - 256.0 - 0.5 * 4.0) < SIGMAS * 2.0 / np.sqrt(masked.size)  # 4 e- of dark current


def test_defocus_spreads_light_and_loses_none() -> None:
    chart = {"densities": [0.0, 3.0, 3.0, 0.0], "columns": 4, "fill": 1.0, "margin": 0.0}
    study = {"chart": {"exposures_s": [1.0], "electrons": [40000.0]}}
    camera = {**QUIET, "width": 128, "height": 32}
    seen = Exposure(iso=100.0, exposure_s=0.0, electrons=40000.0, subject="chart")
    sharp, soft = (
        frames(camera_of(simulation(camera=camera, lens={"defocus": defocus}, chart=chart, study=study)), seen, 1)[0]
        for defocus in (0.0, 4.0)
    )
    edge = soft[:, 24:40].mean(axis=0) / 40000.0
    at = (np.arange(24, 40) + 0.5 - 32.0) / 4.0
    # a pixel has a width: a sixteenth of a variance of 16 is added, which moves the profile by less than 0.003
    bound = SIGMAS / np.sqrt(40000.0 * 32) + 0.003
    assert np.abs(edge - ndtr(-at) - 1e-3 * ndtr(at)).max() < bound
    assert abs(soft.mean() - sharp.mean()) < SIGMAS * np.sqrt(2.0 * 20000.0 / soft.size)


def test_pictures_and_maps_are_read_and_bad_ones_named(tmp_path: Path) -> None:
    light = np.zeros((4, 6, 3))
    light[:, :3, 0], light[:, 3:, 2] = 1.0, 0.5
    np.save(tmp_path / "picture.npy", light)
    swap = [[0.0, 0.0, 1.0], [0.0, 1.0, 0.0], [1.0, 0.0, 0.0]]
    study = {"scene": {"subjects": [str(tmp_path / "picture.npy")], "electrons": 10000.0}}
    camera = {**QUIET, "cfa": "RGGB", "colour_matrix": swap, "width": 64, "height": 64}
    study_written = simulated_study(tmp_path / "study", simulation(camera=camera, study=study))
    image = read_raw(study_written.root / f"{study_written.frames[0].name}.dng").mosaic.astype(np.float64) - 1000.0
    assert image[0::2, 0:20:2].mean() == 0.0  # red sees blue, and there is none on the left
    assert abs(image[1::2, 1:20:2].mean() - 10000.0) < SIGMAS * 100.0 / np.sqrt(320)
    assert (study_written.root / "inputs" / "picture.npy").exists()
    np.save(tmp_path / "bad.npy", -light)
    bad = simulation(study={"scene": {"subjects": [str(tmp_path / "bad.npy")]}})
    with pytest.raises(UsageError, match=r"bad\.npy"):
        camera_of(bad)
    (tmp_path / "tuning.json").write_text('{"rpi.alsc": {"luminance_lut": [1.0]}}', encoding="utf-8")
    with pytest.raises(UsageError, match=r"tuning\.json"):
        camera_of(simulation(lens={"shading": str(tmp_path / "tuning.json")}))


def test_a_table_of_libcamera_shades_as_it_corrects(tmp_path: Path) -> None:
    y, x = (np.arange(12) + 0.5) / 12, (np.arange(16) + 0.5) / 16
    luminance = 1.0 + 2.0 * ((y[:, None] - 0.5) ** 2 + (x - 0.5) ** 2)
    red = 1.0 + 0.1 * np.abs(x - 0.5) + 0.0 * luminance
    alsc = {"luminance_lut": luminance.ravel().tolist()}
    for key, table in (("calibrations_Cr", red), ("calibrations_Cb", np.ones((12, 16)))):
        alsc[key] = [{"ct": 3000, "table": [1.0] * 192}, {"ct": 5000, "table": table.ravel().tolist()}]
    (tmp_path / "tuning.json").write_text(json.dumps({"algorithms": [{"rpi.alsc": alsc}]}), encoding="utf-8")
    config = simulation(lens={"shading": str(tmp_path / "tuning.json")}, camera={"channel_response": {}})
    lens = config.lens.map_for(config.sensor)
    rows, columns = (np.arange(1, 128, 2) + 0.5) / 128, (np.arange(1, 192, 2) + 0.5) / 192
    inner = np.s_[8:-8, 8:-8]
    parabola = 1.0 + 2.0 * ((rows[:, None] - 0.5) ** 2 + (columns - 0.5) ** 2)
    expected = 1.0 / (parabola * (1.0 + 0.1 * np.abs(columns - 0.5)))
    found = lens[1::2, 1::2]  # red of BGGR
    assert found.max() == pytest.approx(1.0, abs=1e-6)
    ratio = found[inner] / expected[inner]
    # a parabola of curvature 4, linear between cells a 12th and a 16th apart, and the kink of red between two cells
    bound = 4.0 / 8.0 * (1.0 / 144.0 + 1.0 / 256.0) + 0.1 / 16.0 / 4.0
    assert np.abs(ratio / ratio.mean() - 1.0).max() < bound


def test_a_frame_takes_its_own_memory_and_a_few_tiles() -> None:
    config = simulation(
        camera={"width": 2048, "height": 1024, "read_noise_post": 0.5, "prnu_row": 0.1},
        lens={"shading": "cos4", "flare": 0.01},
        study=DARK,
    )
    camera, exposure = camera_of(config), Exposure(iso=100.0, exposure_s=0.1, electrons=2000.0)
    take(camera, exposure)
    tracemalloc.start()
    try:
        mosaic = take(camera, exposure)
        peak = tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()
    tile_bytes = 8 * 131072
    assert peak < mosaic.nbytes + 10 * tile_bytes


def test_previews_and_noise_profiles_are_written_when_asked_for(tmp_path: Path) -> None:
    study = {
        "flat": {"exposures_s": [0.001, 0.002], "electrons": [500.0, 1000.0], "frames": 2},
        "scene": {"subjects": ["patches"]},
    }
    written = simulated_study(
        tmp_path / "study", simulation(study=study, output={"preview": True, "noise_profile": True})
    )
    shown = sorted(path.relative_to(written.root).as_posix() for path in written.root.rglob("*.jpg"))
    assert shown == [
        "flat/ISO_100/exp000001000us_n00.jpg",
        "flat/ISO_100/exp000002000us_n00.jpg",
        "scene/patches.jpg",
    ]
    header = read_raw(written.root / "scene" / "patches.dng").header
    scale, offset = header.noise_profile[0]
    unlit = (0.5**2) * (2.5**2 + 0.3**2 + 4.0 * 0.01) + 1.0 / 12.0
    assert scale == pytest.approx(0.5 / (4095 - 256))
    assert offset == pytest.approx(unlit / (4095 - 256) ** 2)
