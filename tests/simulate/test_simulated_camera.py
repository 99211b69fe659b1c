"""Simulated frames have the statistics of their parameters, by plain NumPy and bounds derived from the sample sizes."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from numpy.typing import NDArray

from fullwell.model.sensor import SensorParameters
from fullwell.simulate.camera import STAGES, Surroundings, build, take
from fullwell.simulate.geometry import Tile
from fullwell.simulate.lens import Lens
from fullwell.simulate.scene import SUBJECTS
from fullwell.simulate.shot import Exposure

ROWS, COLUMNS, FRAMES = 128, 160, 24
BLACK = 200.0
GAIN = 2.0
SENSOR = SensorParameters(
    width=COLUMNS,
    height=ROWS,
    cfa="mono",
    bit_depth=16,
    black_level=(BLACK,),
    white_level=65535,
    base_iso=100.0,
    system_gain=GAIN,
    full_well=20000.0,
    response=(1.0,),
    read_noise=2.0,
    read_noise_row=0.6,
    read_noise_column=0.4,
    read_noise_post=1.5,
    dark_current=3.0,
    dsnu=1.5,
    prnu=0.01,
)
SIGMAS = 4.5
"""Bounds in standard errors: a normal number exceeds 4.5 of them seven times in a million."""


def burst(sensor: SensorParameters, exposure: Exposure, frames: int = FRAMES, **lens: float) -> NDArray[np.float64]:
    camera = build(sensor, seed=7, **lens)
    return np.array([take(camera, replace(exposure, frame=number)) for number in range(frames)], dtype=np.float64)


@pytest.fixture(scope="module", params=[0.5, 3.0, 30.0, 5000.0])
def level(request: pytest.FixtureRequest) -> tuple[float, NDArray[np.float64]]:
    electrons = float(request.param)
    return electrons, burst(SENSOR, Exposure(iso=100.0, exposure_s=0.0, electrons=electrons))


def temporal_dn2(electrons: float) -> float:
    before = electrons + SENSOR.read_noise**2 + SENSOR.read_noise_row**2 + SENSOR.read_noise_column**2
    return GAIN**2 * before + SENSOR.read_noise_post**2 + 1.0 / 12.0


def shared_dn2(lines: int, noise: float) -> float:
    """Variance of the mean of lines that share noise."""
    return (GAIN * noise) ** 2 / lines


def test_mean_is_black_level_plus_signal(level: tuple[float, NDArray[np.float64]]) -> None:
    electrons, frames = level
    variance = temporal_dn2(electrons) / frames.size
    variance += shared_dn2(ROWS * FRAMES, SENSOR.read_noise_row) + shared_dn2(
        COLUMNS * FRAMES, SENSOR.read_noise_column
    )
    assert abs(frames.mean() - (BLACK + GAIN * electrons)) < SIGMAS * np.sqrt(variance)


def test_temporal_variance_is_that_of_all_noises(level: tuple[float, NDArray[np.float64]]) -> None:
    electrons, frames = level
    expected = temporal_dn2(electrons)
    excess = GAIN**4 * electrons
    squared_error = (2.0 * expected**2 / (FRAMES - 1) + excess / FRAMES) / (ROWS * COLUMNS)
    for lines, noise in ((ROWS, SENSOR.read_noise_row), (COLUMNS, SENSOR.read_noise_column)):
        squared_error += 2.0 * (GAIN * noise) ** 4 / (lines * (FRAMES - 1))
    assert abs(frames.var(axis=0, ddof=1).mean() - expected) < SIGMAS * np.sqrt(squared_error)


def test_spatial_variance_is_that_of_dsnu_and_prnu(level: tuple[float, NDArray[np.float64]]) -> None:
    electrons, frames = level
    fixed = GAIN**2 * (SENSOR.dsnu**2 + (SENSOR.prnu * electrons) ** 2)
    temporal = frames.var(axis=0, ddof=1).mean() / FRAMES
    squared_error = 2.0 * (fixed + temporal) ** 2 / (ROWS * COLUMNS)
    for lines, noise in ((ROWS, SENSOR.read_noise_row), (COLUMNS, SENSOR.read_noise_column)):
        squared_error += 2.0 * ((GAIN * noise) ** 2 / FRAMES) ** 2 / lines
    assert abs(frames.mean(axis=0).var(ddof=1) - temporal - fixed) < SIGMAS * np.sqrt(squared_error)


@pytest.mark.parametrize(("axis", "noise"), [(2, SENSOR.read_noise_row), (1, SENSOR.read_noise_column)])
def test_lines_share_row_and_column_noise(level: tuple[float, NDArray[np.float64]], axis: int, noise: float) -> None:
    electrons, frames = level
    differences = (frames[1::2] - frames[::2]) / np.sqrt(2.0)
    lines = differences.mean(axis=axis)
    lines -= lines.mean(axis=1, keepdims=True)
    across = frames.shape[axis]
    other = SENSOR.read_noise_column if axis == 2 else SENSOR.read_noise_row
    white = (temporal_dn2(electrons) - (GAIN * noise) ** 2 - (GAIN * other) ** 2) / across
    expected = (GAIN * noise) ** 2 + white
    dof = lines.shape[0] * (lines.shape[1] - 1)
    assert abs((lines**2).sum() / dof - expected) < SIGMAS * expected * np.sqrt(2.0 / dof)


def test_skewness_is_poisson() -> None:
    quiet = replace(SENSOR, read_noise=0.0, read_noise_row=0.0, read_noise_column=0.0, read_noise_post=0.0)
    quiet = replace(quiet, dsnu=0.0, prnu=0.0, system_gain=1.0)
    for electrons in (0.5, 3.0, 30.0):
        frames = burst(quiet, Exposure(iso=100.0, exposure_s=0.0, electrons=electrons), 8) - BLACK
        third = ((frames - electrons) ** 3).mean()
        # Sixth central moment of Poisson less the third squared: mean + 25 mean^2 + 15 mean^3 - mean^2.
        spread = electrons + 24.0 * electrons**2 + 15.0 * electrons**3
        assert abs(third - electrons) < SIGMAS * np.sqrt(spread / frames.size)


def test_dark_current_adds_its_mean_and_its_shot_noise() -> None:
    frames = burst(SENSOR, Exposure(iso=100.0, exposure_s=10.0))
    expected = temporal_dn2(30.0)
    shared = shared_dn2(ROWS * FRAMES, SENSOR.read_noise_row) + shared_dn2(COLUMNS * FRAMES, SENSOR.read_noise_column)
    assert abs(frames.mean() - BLACK - GAIN * 30.0) < SIGMAS * np.sqrt(expected / frames.size + shared)


def test_amplification_scales_all_but_the_noise_after_it() -> None:
    frames = burst(SENSOR, Exposure(iso=400.0, exposure_s=0.0))
    expected = (
        16.0 * (temporal_dn2(0.0) - SENSOR.read_noise_post**2 - 1.0 / 12.0) + SENSOR.read_noise_post**2 + 1.0 / 12.0
    )
    squared_error = 2.0 * expected**2 / (ROWS * COLUMNS * (FRAMES - 1))
    for lines, noise in ((ROWS, SENSOR.read_noise_row), (COLUMNS, SENSOR.read_noise_column)):
        squared_error += 2.0 * (4.0 * GAIN * noise) ** 4 / (lines * (FRAMES - 1))
    assert abs(frames.var(axis=0, ddof=1).mean() - expected) < SIGMAS * np.sqrt(squared_error)


def test_charge_stops_at_the_full_well_and_codes_at_the_rails() -> None:
    quiet = replace(SENSOR, read_noise=0.0, read_noise_row=0.0, read_noise_column=0.0, read_noise_post=0.0, dsnu=0.0)
    full = burst(quiet, Exposure(iso=100.0, exposure_s=0.0, electrons=40000.0), 1)
    assert np.all(full == BLACK + GAIN * quiet.full_well)
    clipped = burst(
        replace(quiet, bit_depth=12, white_level=4000), Exposure(iso=100.0, exposure_s=0.0, electrons=1e4), 1
    )
    assert np.all(clipped == 4000)
    noisy = replace(SENSOR, black_level=(1.0,), read_noise=20.0)
    dark = burst(noisy, Exposure(iso=100.0, exposure_s=0.0), 1)
    assert dark.min() == 0
    assert 0.4 < np.mean(dark == 0) < 0.55  # half of a normal number about 1 DN, of 40 DN spread, lies below 0.5 DN


def test_shading_and_response_are_those_of_the_channel() -> None:
    sensor = replace(
        SENSOR,
        cfa="GRBG",
        black_level=(BLACK,) * 4,
        response=(1.0, 0.5, 0.6, 0.9),
        dsnu=0.0,
        prnu=0.0,
        pixel_pitch_um=30.0,
    )
    sensor = replace(sensor, read_noise_row=0.0, read_noise_column=0.0)
    lens = Lens(shading="cos4", focal_length_mm=4.0, exponents=(1.0, 1.1, 0.9, 1.0), flare=0.01)
    camera = build(sensor, seed=3, around=Surroundings(lens=lens))
    frames = np.array(
        [take(camera, Exposure(iso=100.0, exposure_s=0.0, electrons=4000.0, frame=n)) for n in range(8)],
        dtype=np.float64,
    )
    y, x = np.mgrid[:ROWS, :COLUMNS]
    r_mm = np.hypot(y - (ROWS - 1) / 2.0, x - (COLUMNS - 1) / 2.0) * 0.030
    site = 2 * (y % 2) + x % 2
    cos4 = np.cos(np.arctan(r_mm / 4.0)) ** 4
    response = np.array(sensor.response)[site]
    expected_e = 4000.0 * response * (cos4 ** np.array([1.0, 1.1, 0.9, 1.0])[site] + 0.01)
    variance = (GAIN**2 * (expected_e + sensor.read_noise**2) + sensor.read_noise_post**2 + 1.0 / 12.0) / len(frames)
    chi2 = ((frames.mean(axis=0) - BLACK - GAIN * expected_e) ** 2 / variance).sum()
    n = ROWS * COLUMNS
    assert cos4.min() < 0.6
    assert abs(chi2 - n) < SIGMAS * np.sqrt(2.0 * n)


def test_fixed_patterns_have_no_mean_and_stay_from_frame_to_frame() -> None:
    sensor = replace(SENSOR, cfa="RGGB", black_level=(BLACK,) * 4, response=(1.0,) * 4)
    camera, other = build(sensor, seed=7).individual, build(sensor, seed=8).individual
    for row in (0, 1):
        for column in (0, 1):
            assert abs(camera.dsnu[row::2, column::2].mean(dtype=np.float64)) < 1e-7
            assert abs(camera.prnu[row::2, column::2].mean(dtype=np.float64)) < 1e-7
    correlation = np.corrcoef(camera.dsnu.ravel(), camera.prnu.ravel())[0, 1]
    assert abs(correlation) < SIGMAS / np.sqrt(camera.dsnu.size)
    assert not np.array_equal(camera.dsnu, other.dsnu)


def test_no_tile_and_no_order_changes_a_bit() -> None:
    sensor = replace(SENSOR, cfa="BGGR", black_level=(BLACK, 201.0, 202.0, 203.0), response=(0.6, 1.0, 1.0, 0.5))
    lens = Lens(shading="cos4", focal_length_mm=0.2, exponents=(1.0,) * 4, flare=0.01)
    camera = build(sensor, seed=7, around=Surroundings(lens=lens))
    exposure = Exposure(iso=200.0, exposure_s=0.5, electrons=300.0, subject="patches", frame=3)
    tops, lefts = [0, 33, 34, 101, ROWS], [0, 7, 90, COLUMNS]
    cover = [
        Tile(top=top, left=left, bottom=bottom, right=right)
        for top, bottom in pairwise(tops)
        for left, right in pairwise(lefts)
    ]
    order = np.random.default_rng(1).permutation(len(cover))
    assert np.array_equal(take(camera, exposure), take(camera, exposure, [cover[index] for index in order]))


@pytest.mark.parametrize("subject", sorted(SUBJECTS))
def test_subjects_are_light_and_the_same_picture_at_any_size(subject: str) -> None:
    coarse, fine = ((np.arange(n) + 0.5) / n for n in (63, 189))
    for colour in range(3):
        light = SUBJECTS[subject](coarse[None, :], coarse[:, None], colour)
        again = SUBJECTS[subject](fine[None, :], fine[:, None], colour)
        assert light.shape == (63, 63)
        assert light.min() >= 0.0
        assert np.allclose(light, again[1::3, 1::3], rtol=1e-12)


def test_stages_are_in_the_order_of_physics() -> None:
    names = [stage.__name__ for stage in STAGES]
    assert names == [
        "light",
        "focused",
        "filtered",
        "illumination",
        "expected_electrons",
        "collected",
        "attracted",
        "held",
        "sensed",
        "read_out",
        "amplified",
        "converted",
    ]
