"""Frames written by `simulate`, analysed without any code of Fullwell: tifffile reads them, NumPy and SciPy judge them.

Bounds are five standard errors, derived where they stand.
"""

from pathlib import Path

import numpy as np
import pytest
import tifffile
from scipy import stats

from fullwell.testing import simulated_study, simulation

K, BLACK, FRAMES = 0.6, 200.0, 12
LEVELS = (0.5, 3.0, 30.0, 5000.0)
HEIGHT, WIDTH = 192, 256
CAMERA = {
    "width": WIDTH,
    "height": HEIGHT,
    "bit_depth": 14,
    "black_level": BLACK,
    "white_level": 16383,
    "system_gain": K,
    "full_well": 20000.0,
    "dark_current": 0.0,
    "read_noise": 1.2,
    "read_noise_row": 0.4,
    "read_noise_column": 0.3,
    "read_noise_post": 0.5,
    "dsnu": 0.8,
    "dsnu_row": 0.3,
    "prnu": 1.0,
    "prnu_column": 0.5,
    "channel_response": {"R": 0.5, "G1": 1.0, "G2": 1.0, "B": 0.6},
    "pixel_pitch_um": 8.0,
}
RESPONSE = {(0, 0): 0.5, (0, 1): 1.0, (1, 0): 1.0, (1, 1): 0.6}
FOCAL_MM = 3.0
SIGMAS = 5.0


def flats(levels, frames):
    return {
        "series": [
            {"kind": "flat", "iso": 100, "exposure_s": 0.001 * (number + 1), "electrons": level, "frames": frames}
            for number, level in enumerate(levels)
        ]
    }


def bursts(root: Path):
    """Frames of each exposure, shortest first."""
    found: dict[str, list[np.ndarray]] = {}
    for path in sorted((root / "flat").rglob("*.dng")):
        found.setdefault(path.name.split("_n")[0], []).append(tifffile.imread(path).astype(np.float64))
    return [np.array(frames) for _, frames in sorted(found.items())]


@pytest.fixture(scope="module")
def planes(tmp_path_factory):
    """Frames and expected electrons of every level and plane."""
    lens = {"shading": "cos4", "focal_length_mm": FOCAL_MM, "flare": 0.02}
    config = simulation(seed=11, camera={**CAMERA, "cfa": "RGGB"}, lens=lens, study=flats(LEVELS, FRAMES))
    written = bursts(simulated_study(tmp_path_factory.mktemp("frames") / "study", config).root)
    y, x = np.mgrid[:HEIGHT, :WIDTH]
    r2 = ((y - (HEIGHT - 1) / 2) ** 2 + (x - (WIDTH - 1) / 2) ** 2) * 0.008**2
    fall_off = (1.0 + r2 / FOCAL_MM**2) ** -2.0 + 0.02
    return [
        (frames[:, row::2, column::2], level * response * fall_off[row::2, column::2])
        for level, frames in zip(LEVELS, written, strict=True)
        for (row, column), response in RESPONSE.items()
    ]


def temporal_dn2(expected_e):
    """Temporal variance of a pixel."""
    return K**2 * (expected_e + 1.2**2 + 0.4**2 + 0.3**2) + 0.5**2 + 1.0 / 12.0


def test_means_are_those_of_the_light(planes) -> None:
    for frames, expected_e in planes:
        rows, columns = expected_e.shape
        lines = K**2 * (0.4**2 / rows + 0.3**2 / columns) / FRAMES
        patterns = (K * 0.01 * expected_e.std()) ** 2 / expected_e.size + (K * 0.005 * expected_e.std()) ** 2 / columns
        error = np.sqrt(temporal_dn2(expected_e).mean() / (expected_e.size * FRAMES) + lines + patterns)
        assert abs(frames.mean() - BLACK - K * expected_e.mean()) < SIGMAS * error


def test_temporal_variances_and_covariances_are_those_of_the_noise(planes) -> None:
    for frames, expected_e in planes:
        rows, columns = expected_e.shape
        deviation = frames - frames.mean(axis=0)
        unbiased = FRAMES / (FRAMES - 1.0)
        v = temporal_dn2(expected_e)
        n, dof = expected_e.size, FRAMES - 1
        lines = 2.0 * K**4 * (0.4**4 / rows + 0.3**4 / columns) / dof
        error = np.sqrt((2.0 * v**2 + K**4 * expected_e).mean() / (n * dof) + lines)
        assert abs(unbiased * (deviation**2).mean() - v.mean()) < SIGMAS * error
        for step, variance, count in (((0, 1), 0.4**2, rows), ((1, 0), 0.3**2, columns), ((1, 1), 0.0, n)):
            near = deviation[:, : rows - step[0], : columns - step[1]]
            far = deviation[:, step[0] :, step[1] :]
            shared = K**2 * variance
            scatter = np.sqrt((v**2).mean() / (n * dof) + 2.0 * shared**2 / (count * dof) + lines)
            assert abs(unbiased * (near * far).mean() - shared) < SIGMAS * scatter


def test_fixed_patterns_have_the_spread_of_pixels_rows_and_columns(planes) -> None:
    for frames, expected_e in planes:
        rows, columns = expected_e.shape
        mean = frames.mean(axis=0) - BLACK - K * expected_e
        floor = K**2 * (expected_e + 1.2**2) / FRAMES + (0.5**2 + 1.0 / 12.0) / FRAMES
        row_mean, column_mean = mean.mean(axis=1, keepdims=True), mean.mean(axis=0, keepdims=True)
        rest = mean - row_mean - column_mean + mean.mean()
        pixel = K**2 * (0.8**2 + (0.01 * expected_e) ** 2) + floor
        assert abs((rest**2).mean() - pixel.mean()) < SIGMAS * np.sqrt(
            2.0 * (pixel**2).mean() / rest.size
        ) + pixel.mean() * (1.0 / rows + 1.0 / columns)
        light2 = (expected_e**2).mean()
        row = K**2 * (0.3**2 + 0.4**2 / FRAMES) + pixel.mean() / columns
        column = K**2 * (0.005**2 * light2 + 0.3**2 / FRAMES) + pixel.mean() / rows
        for found, expected, count in ((row_mean, row, rows), (column_mean, column, columns)):
            # one mean is taken off; a column's light differs along it, by less than the fall-off's spread
            spread = (
                SIGMAS * expected * np.sqrt(2.0 / (count - 1)) + expected * (expected_e.std() / expected_e.mean()) ** 2
            )
            assert abs(found.var(ddof=1) - expected) < spread


def test_shading_is_that_of_the_lens(planes) -> None:
    for frames, expected_e in planes[-4:]:
        rows, columns = (size // 8 * 8 for size in expected_e.shape)

        def blocks(image, rows=rows, columns=columns):
            return image[:rows, :columns].reshape(8, rows // 8, 8, columns // 8).mean(axis=(1, 3))

        found = (blocks(frames.mean(axis=0)) - BLACK) / (K * blocks(expected_e))
        # PRNU of the block's pixels, and of its columns, which all blocks of a column of blocks share
        error = np.sqrt(0.01**2 / (rows * columns / 64) + 0.005**2 / (columns / 8) + 1.0 / (5000.0 * 0.3))
        assert np.abs(found - 1.0).max() < SIGMAS * error
        assert expected_e.min() / expected_e.max() < 0.85


def test_codes_follow_the_exact_law_into_the_tails(tmp_path: Path) -> None:
    """Poisson electrons, normal read noise, rounding: the histogram of one frame against the sum over electrons."""
    camera = {
        key: value
        for key, value in CAMERA.items()
        if key not in {"prnu", "prnu_column", "dsnu_row", "channel_response"}
    }
    camera |= {"cfa": "mono", "read_noise_row": 0.0, "read_noise_column": 0.0, "dsnu": 0.0, "prnu": 0.0}
    config = simulation(seed=12, camera=camera, study=flats(LEVELS, 4))
    for level, frames in zip(LEVELS, bursts(simulated_study(tmp_path / "study", config).root), strict=True):
        sigma = np.sqrt((K * 1.2) ** 2 + 0.5**2)
        electrons = np.arange(*stats.poisson.interval(1.0 - 1e-13, level), dtype=np.float64)
        electrons = np.arange(max(electrons[0] - 1, 0), electrons[-1] + 2)
        codes = np.arange(frames.min() - 1, frames.max() + 2)
        upper = stats.norm.cdf((codes[:, None] + 0.5 - BLACK - K * electrons) / sigma)
        law = np.diff((upper * stats.poisson.pmf(electrons, level)).sum(axis=1), prepend=0.0)
        law[-1] += 1.0 - law.sum()
        counts = np.array([(frames == code).sum() for code in codes], dtype=np.float64)
        expected = frames.size * law
        common = expected >= 5.0
        observed = np.append(counts[common], counts[~common].sum())
        expected = np.append(expected[common], expected[~common].sum())
        # four levels: fails by chance for one seed in 250 000
        assert stats.chisquare(observed, expected).pvalue > 1e-6


def test_libraw_opens_what_was_written(tmp_path: Path) -> None:
    rawpy = pytest.importorskip("rawpy")
    margins = {"left": 16, "top": 8}
    config = simulation(
        camera={**CAMERA, "cfa": "RGGB"}, output={"optical_black": margins}, study=flats((3.0, 5000.0), 1)
    )
    for path in (simulated_study(tmp_path / "study", config).root / "flat").rglob("*.dng"):
        stored = tifffile.imread(path)
        assert stored.shape == (HEIGHT + 8, WIDTH + 16)
        with rawpy.imread(str(path)) as opened:
            assert np.array_equal(opened.raw_image_visible, stored[8:, 16:])
            assert opened.sizes.width == WIDTH
            # LibRaw takes the masked pixels' mean for black, cut to a whole number
            assert all(abs(level - BLACK) <= 1.0 for level in opened.black_level_per_channel)
            assert opened.postprocess(half_size=True).shape == (HEIGHT // 2, WIDTH // 2, 3)
        assert abs(stored[:8].mean() - BLACK) < SIGMAS * 1.2 * np.sqrt(0.4**2 / 8 + 0.3**2 / 100)
