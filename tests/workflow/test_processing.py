"""Processing in the camera is found and named, rows it touches are flagged; untouched studies raise no alarm."""

import shutil
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from fullwell.figures.results import Results
from fullwell.frames.selection import Selection
from fullwell.raw.open import decode, read_header
from fullwell.statistics.noise_correlation import noise_correlation
from fullwell.testing.studies import simulated_study, simulation
from fullwell.workflow.characterize import measure
from fullwell.workflow.options import Options

SIGNS = {
    *("code-step", "scaled-codes", "doubled-codes", "companded-codes", "missing-codes", "correlated-noise"),
    *("line-offsets-corrected", "digital-white-balance", "optical-black-differs", "optical-black-noisier"),
}


@pytest.fixture(scope="module")
def plain(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("processing") / "study"
    simulated_study(folder, simulation(camera={"width": 320, "height": 256, "read_noise_row": 0.0}))
    return folder


def measured(plain: Path, folder: Path, change: Callable[[np.ndarray], np.ndarray]) -> Results:
    """Measure a copy of a study whose mosaics were changed."""
    shutil.copytree(plain, folder)
    for path in folder.rglob("*.dng"):
        data = bytearray(path.read_bytes())
        mosaic = decode(read_header(path), data)
        start = mosaic.__array_interface__["data"][0] - np.frombuffer(data, np.uint8).__array_interface__["data"][0]
        codes = np.clip(np.round(change(mosaic.astype(np.float64))), 0, 65535).astype("<u2")
        data[start : start + codes.nbytes] = codes.tobytes()
        path.write_bytes(bytes(data))
    return measure(folder, options=Options(selection=Selection(), workers=1)).results


def signs(results: Results) -> set[str]:
    return {finding.code for finding in results.findings} & SIGNS


def processed(results: Results, quantity: str) -> set[str]:
    return {row.channel for row in results.rows if row.quantity == quantity and "processed" in row.flags}


def smoothed(x: np.ndarray) -> np.ndarray:
    """Average neighbours of one colour along rows, as a mild denoiser does."""
    out = x.copy()
    out[:, 2:-2] = 0.7 * x[:, 2:-2] + 0.15 * (x[:, :-4] + x[:, 4:])
    return out


def balanced(x: np.ndarray) -> np.ndarray:
    x[1::2, 1::2] = 256.0 + 1.5 * (x[1::2, 1::2] - 256.0)
    return x


def balanced_without_a_comb(x: np.ndarray) -> np.ndarray:
    dither = np.random.default_rng(int(x.sum()) % 1000).uniform(-0.5, 0.5, x[1::2, 1::2].shape)
    x[1::2, 1::2] = 256.0 + 1.5 * (x[1::2, 1::2] - 256.0) + dither
    return x


def without_row_offsets(x: np.ndarray) -> np.ndarray:
    """Set the mean of every row of a plane to what it is in all rows around: what row-noise removal does."""
    for row in range(2):
        for column in range(2):
            plane = x[row::2, column::2]
            plane -= plane.mean(axis=1, keepdims=True) - plane.mean()
            plane += np.random.default_rng(int(plane.sum()) % 997).uniform(-0.5, 0.5, plane.shape)
    return x


def test_an_untouched_study_raises_no_alarm(plain: Path, tmp_path: Path) -> None:
    results = measured(plain, tmp_path / "study", lambda x: x)
    assert signs(results) == set()
    assert not any("processed" in row.flags for row in results.rows)


def test_a_denoiser_is_named(plain: Path, tmp_path: Path) -> None:
    results = measured(plain, tmp_path / "study", smoothed)
    assert "correlated-noise" in signs(results)
    assert processed(results, "system_gain") == {"R", "G1", "G2", "B", "all"}
    (message, *_) = (one.message for one in results.findings if one.code == "correlated-noise")
    assert "smoothing" in message


def test_digital_white_balance_by_its_comb_and_by_its_gain(plain: Path, tmp_path: Path) -> None:
    results = measured(plain, tmp_path / "comb", balanced)
    assert {"scaled-codes", "digital-white-balance"} <= signs(results)
    assert processed(results, "system_gain") == {"R", "all"}
    dithered = measured(plain, tmp_path / "dithered", balanced_without_a_comb)
    assert signs(dithered) == {"digital-white-balance"}


def test_row_offsets_taken_off(plain: Path, tmp_path: Path) -> None:
    assert "line-offsets-corrected" in signs(measured(plain, tmp_path / "study", without_row_offsets))


def test_shifted_codes_leave_the_read_noise_as_it_was(plain: Path, tmp_path: Path) -> None:
    before = measured(plain, tmp_path / "plain", lambda x: x)
    after = measured(plain, tmp_path / "shifted", lambda x: 4.0 * x)
    assert signs(after) == {"code-step"}

    def noise(results: Results) -> dict[str, float]:
        return {
            row.channel: row.measured.value
            for row in results.rows
            if (row.quantity, row.method, row.measured.unit) == ("read_noise", "temporal-variance", "DN")
        }

    assert {name: value / 4.0 for name, value in noise(after).items()} == pytest.approx(noise(before), rel=1e-9)


def test_correlations_of_independent_noise_are_none() -> None:
    pulls = []
    for seed in range(40):
        rng = np.random.default_rng(seed)
        one, two = (rng.normal(300.0, 2.0, (128, 160)).round().astype(np.uint16) for _ in range(2))
        found = noise_correlation(one, two)
        lags = found.correlation.copy()
        lags[0, :4] = np.nan
        pulls.append(lags[np.isfinite(lags)] / found.std_error)
    # 40 x 24 standard normals: rms within four sigma, 4 / sqrt(2 x 960)
    assert np.sqrt(np.mean(np.square(pulls))) == pytest.approx(1.0, abs=0.1)


def test_a_known_filter_gives_its_correlations_and_keeps_the_sum() -> None:
    rng = np.random.default_rng(2)
    frames = []
    for _ in range(2):
        white = rng.normal(0.0, 20.0, (300, 304))
        frames.append((1000.0 + 0.8 * white[:, 2:-2] + 0.1 * (white[:, :-4] + white[:, 4:])).round().astype(np.uint16))
    found = noise_correlation(*frames)
    variance = 0.8**2 + 2 * 0.1**2
    assert found.correlation[0, 5] == pytest.approx(0.16 / variance, abs=4 * found.std_error)
    assert found.correlation[0, 4] == pytest.approx(0.0, abs=4 * found.std_error)
    assert found.total_dn2 == pytest.approx(400.0, rel=4 * (2 * 24) ** 0.5 * found.std_error)
