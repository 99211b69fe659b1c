"""A chart through the command line alone, simulated and written without any of our code."""

import json
import math
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pytest
from chart_simulation import RESPONSE, Camera, Chart, write_dng
from scipy import stats

CHART = Chart()
PLANNED = {"k_dark": 9.1, "k_shot": 14.5, "k_fpn": 78.0}
"""METHOD 1.6: expected error of four channels of 36 patches, times the square root of n, in per cent."""
Run = Callable[..., "subprocess.CompletedProcess[str]"]


def start(*arguments: str | Path) -> "subprocess.CompletedProcess[str]":
    command = [sys.executable, "-m", "fullwell", "chart", *map(str, arguments)]
    return subprocess.run(command, check=False, capture_output=True, text=True)


def measured(out: Path, *arguments: str | Path, status: int = 0) -> dict:
    done = start(*arguments, "-o", out, "--quiet")
    assert done.returncode == status, done.stderr
    return json.loads((out / "results.json").read_text())


@pytest.fixture(scope="module")
def shots(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Two exposures, 1 and 1/8, and three more frames of each."""
    folder = tmp_path_factory.mktemp("shots")
    camera = Camera(CHART, seed=11)
    camera.write_patches(folder / "patches.csv")
    for index in range(4):
        camera.write(folder / f"nominal_{index}.dng", 1.0)
        camera.write(folder / f"under_{index}.dng", 1 / 8)
    return folder


@pytest.fixture(scope="module")
def bracket(shots: Path, tmp_path_factory: pytest.TempPathFactory) -> dict:
    out = tmp_path_factory.mktemp("bracket") / "out"
    return measured(out, shots / "nominal_0.dng", shots / "under_0.dng", "--patches", shots / "patches.csv")


@pytest.fixture(scope="module")
def single(shots: Path, tmp_path_factory: pytest.TempPathFactory) -> dict:
    out = tmp_path_factory.mktemp("single") / "out"
    return measured(out, shots / "nominal_0.dng", "--patches", shots / "patches.csv")


@pytest.fixture(scope="module")
def bursts(shots: Path, tmp_path_factory: pytest.TempPathFactory) -> dict:
    out = tmp_path_factory.mktemp("bursts") / "out"
    return measured(out, *sorted(shots.glob("*.dng")), "--patches", shots / "patches.csv")


def found(results: dict, quantity: str, channel: str, method: str, unit: str = "1") -> dict:
    (row,) = (
        one
        for one in results["results"]
        if (one["quantity"], one["channel"], one["method"], one["unit"], one["region"])
        == (quantity, channel, method, unit, None)
        and one["snr_threshold"] in {None, 1.0}
    )
    return row


def truth_of(row: dict) -> float | None:
    dark = (CHART.k_dark * CHART.maximum) ** 2 - 1.0 / 12.0
    known = {
        ("black_level", "DN"): CHART.offset,
        ("k_dark", "1"): CHART.k_dark,
        ("k_shot", "1"): CHART.k_shot,
        ("k_fpn", "1"): CHART.k_fpn,
        ("system_gain", "DN/e-"): CHART.system_gain,
        ("read_noise", "DN"): math.sqrt(dark),
        ("read_noise", "e-"): math.sqrt(dark) / CHART.system_gain,
        ("flare", "1"): CHART.flare,
        ("channel_ratio", "1"): RESPONSE.get(row["channel"]),
    }
    return known.get((row["quantity"], row["unit"]))


def judged(results: dict) -> Iterator[tuple[dict, float]]:
    for row in results["results"]:
        truth = truth_of(row)
        if truth is not None and row["std_error"] and row["method"] != "metadata":
            yield row, truth


def p_value(row: dict, truth: float) -> float:
    pull = abs(row["value"] - truth) / row["std_error"]
    return float(2 * (stats.norm.sf(pull) if row["dof"] is None else stats.t.sf(pull, row["dof"])))


def codes(results: dict) -> set[str]:
    return {finding["code"] for finding in results["findings"]}


def message(results: dict, code: str) -> str:
    (finding,) = (one for one in results["findings"] if one["code"] == code)
    return finding["message"]


def test_offset_of_all_planes_is_found_to_two_hundredths(bracket: dict) -> None:
    row = found(bracket, "black_level", "all", "fused", "DN")
    assert abs(row["value"] - CHART.offset) <= 0.02
    assert "recommended" in row["flags"]
    assert "offset-not-identified" not in row["flags"]
    assert found(bracket, "black_level", "all", "exposure-bracket", "DN")["std_error"] < 0.0062 * 1.25


@pytest.mark.parametrize("which", ["bracket", "bursts"])
def test_every_interval_is_honest(which: str, request: pytest.FixtureRequest) -> None:
    rows = list(judged(request.getfixturevalue(which)))
    assert len(rows) > 40
    off = [(row["quantity"], row["channel"], row["value"], truth) for row, truth in rows if p_value(row, truth) < 1e-4]
    assert not off


def test_pulls_of_the_planes_are_as_scattered_as_they_should_be(bracket: dict) -> None:
    scores = [
        stats.norm.isf(p_value(row, truth) / 2) ** 2
        for row, truth in judged(bracket)
        if (row["quantity"], row["method"]) in {("black_level", "exposure-bracket"), ("k_shot", "gamma-likelihood")}
        and row["channel"] != "all"
    ]
    assert len(scores) == 8
    low, high = stats.chi2.ppf([1e-4, 1 - 1e-4], len(scores))
    assert low < sum(scores) < high


@pytest.mark.parametrize("which", ["bracket", "bursts"])
def test_errors_are_no_wider_than_planned(which: str, request: pytest.FixtureRequest) -> None:
    for name, planned in PLANNED.items():
        row = found(request.getfixturevalue(which), name, "all", "gamma-likelihood")
        assert row["std_error"] <= 1.25 * planned / 100 / CHART.edge * truth_of(row)


def test_several_frames_tell_fixed_pattern_from_temporal_noise(bursts: dict, bracket: dict) -> None:
    assert "mixed" in found(bracket, "k_fpn", "all", "gamma-likelihood")["flags"]
    assert "mixed" not in found(bursts, "k_fpn", "all", "gamma-likelihood")["flags"]
    assert found(bursts, "k_dark", "all", "gamma-likelihood")["n"] == 4 * 2 * 4 * 36 * CHART.edge**2


def test_one_exposure_does_not_tell_the_offset(single: dict) -> None:
    for channel in ("R", "G1", "G2", "B", "all"):
        for quantity, method, unit in (
            ("black_level", "fused", "DN"),
            ("k_dark", "gamma-likelihood", "1"),
            ("read_noise", "noise-model", "DN"),
        ):
            assert "offset-not-identified" in found(single, quantity, channel, method, unit)["flags"]
    dark = found(single, "k_dark", "all", "gamma-likelihood")
    assert dark["ci95_low"] < CHART.k_dark < dark["ci95_high"]
    assert dark["ci95_high"] - dark["ci95_low"] > 0.0337 * CHART.k_dark  # a code wide, at 3.37 % per DN
    said = message(single, "offset-not-identified")
    assert "dk_dark/doffset = 5." in said
    assert "% per DN" in said
    assert "flare-not-identified" in codes(single)
    assert not [row for row in single["results"] if row["quantity"] == "flare"]


def test_published_optimizer_takes_flare_for_black(bracket: dict, shots: Path, tmp_path: Path) -> None:
    nominal = (shots / "nominal_0.dng", shots / "under_0.dng", "--patches", shots / "patches.csv")
    assert found(bracket, "black_level", "G1", "legacy-offset-ratio", "DN")["value"] - CHART.offset > 3.0
    results = measured(tmp_path / "out", *nominal, "--black-method", "legacy-offset-ratio=1e4")
    row = found(results, "black_level", "all", "fused", "DN")
    assert row["value"] == found(results, "black_level", "all", "legacy-offset-ratio", "DN")["value"]
    assert "offset-not-identified" in row["flags"]
    assert "10000" in message(results, "legacy-black-level")
    dark = found(results, "k_dark", "all", "gamma-likelihood")
    assert dark["ci95_low"] < CHART.k_dark < dark["ci95_high"]


def test_recommended_stands_on_exactly_one_row(bracket: dict, bursts: dict, single: dict) -> None:
    for results in (bracket, bursts, single):
        seen: dict[tuple, int] = {}
        for row in results["results"]:
            key = tuple(row[name] for name in ("quantity", "channel", "unit", "iso", "temperature_c", "snr_threshold"))
            if row["region"] is None and row["exposure_s"] is None:
                seen[key] = seen.get(key, 0) + ("recommended" in row["flags"])
        assert set(seen.values()) == {1}


def test_same_bytes_for_any_number_of_workers(bursts: dict, shots: Path, tmp_path: Path) -> None:
    images = sorted(shots.glob("*.dng"))
    other = measured(tmp_path / "out", *reversed(images), "--patches", shots / "patches.csv", "--workers", "1")
    assert {**other, "run": None} == {**bursts, "run": None}


def test_clipped_patches_take_no_part(shots: Path, tmp_path: Path) -> None:
    camera = Camera(Chart(brightest=1.8), seed=5)
    images = [camera.write(tmp_path / f"{index}.dng", exposure) for index, exposure in enumerate((1.0, 1 / 8))]
    results = measured(tmp_path / "out", *images, "--patches", shots / "patches.csv")
    assert "over-exposed" in codes(results)
    assert "no-dark-exposure" not in codes(results)
    assert "patches of R at ISO 100 do not reach saturation" in message(results, "saturation-not-reached")
    for name, truth in (("k_shot", CHART.k_shot), ("k_dark", CHART.k_dark), ("k_fpn", CHART.k_fpn)):
        assert p_value(found(results, name, "all", "gamma-likelihood"), truth) > 1e-4
    assert abs(found(results, "black_level", "all", "fused", "DN")["value"] - CHART.offset) < 0.02
    peak = found(results, "saturation_capacity", "G1", "temporal-variance-peak", "DN")
    assert peak["ci95_low"] < CHART.maximum - CHART.offset < 1.001 * peak["ci95_high"]  # a few values do not clip


def test_two_framings_tell_prnu_from_texture(tmp_path: Path) -> None:
    """The chart's grain is 1 %, the sensor's PRNU half of that: one framing gives their sum."""
    chart = Chart(k_fpn=5.477e-3, edge=60)
    camera = Camera(chart, seed=8)
    rng = np.random.default_rng(9)
    grain = 1.0 + 0.01 * np.kron(rng.standard_normal((camera.shape[0] // 2, camera.shape[1] // 2)), np.ones((2, 2)))
    relative = camera.relative.copy()
    images = []
    for index in range(2):
        camera.relative = relative * np.roll(grain, 12 * index, axis=1)
        images.append(camera.write(tmp_path / f"{index}.dng", 1.0))
    camera.write_patches(tmp_path / "first.csv")
    lines = (tmp_path / "first.csv").read_text().splitlines()
    moved = [line.split(",") for line in lines[1:]]
    shifted = [",".join([name, str(int(x) + 12), *rest]) for name, x, *rest in moved]
    (tmp_path / "second.csv").write_text("\n".join([lines[0], *shifted]) + "\n")
    patches = ("--patches", tmp_path / "first.csv", "--patches", tmp_path / "second.csv")
    results = measured(tmp_path / "out", *images, *patches, "--separate")
    row = found(results, "prnu_variance", "all", "two-framings", "%^2")
    assert p_value(row, (100 * chart.k_fpn) ** 2) > 1e-3
    assert found(results, "k_fpn", "all", "gamma-likelihood")["value"] > 1.5 * chart.k_fpn


def test_a_black_image_is_an_error_finding(shots: Path, tmp_path: Path) -> None:
    shape = Camera(CHART, seed=1).shape
    write_dng(tmp_path / "black.dng", np.full(shape, 511, np.uint16), exposure_s=0.02, black=511, white=16383)
    results = measured(tmp_path / "out", tmp_path / "black.dng", "--patches", shots / "patches.csv", status=1)
    assert {"image-without-signal", "too-few-patches"} <= codes(results)
    rng = np.random.default_rng(3)
    noise = np.rint(rng.normal(511, 2.7, shape)).astype(np.uint16)
    write_dng(tmp_path / "noise.dng", noise, exposure_s=0.02, black=511, white=16383)
    results = measured(tmp_path / "noisy", tmp_path / "noise.dng", "--patches", shots / "patches.csv", status=1)
    assert "image-without-signal" in codes(results)


def test_densities_that_do_not_fall_with_the_level_are_named(shots: Path, tmp_path: Path) -> None:
    densities = CHART.densities.copy()
    densities[[3, 7]] = densities[[7, 3]]
    patches = Camera(CHART, seed=11).write_patches(tmp_path / "patches.csv", densities=densities)
    results = measured(tmp_path / "out", shots / "nominal_0.dng", "--patches", patches)
    assert "P8" in message(results, "densities-disagree")


def test_too_few_patches_without_clipping(shots: Path, tmp_path: Path) -> None:
    camera = Camera(Chart(brightest=1.2), seed=5)
    image = camera.write(tmp_path / "0.dng", 1000.0)
    lines = (shots / "patches.csv").read_text().splitlines()
    (tmp_path / "patches.csv").write_text("\n".join(lines[:9]) + "\n")
    results = measured(tmp_path / "out", image, "--patches", tmp_path / "patches.csv", status=1)
    assert "too-few-patches" in codes(results)
    assert not [row for row in results["results"] if row["quantity"] == "k_shot"]


@pytest.mark.parametrize(
    ("change", "sentence"),
    [
        (lambda lines: [*lines[:3], "Far,5000,10,40,40,1.0", *lines[4:]], "reaches out of the visible mosaic"),
        (lambda lines: [*lines[:3], "Odd,31,10,40,40,1.0", *lines[4:]], "is odd"),
        (lambda lines: [*lines, "Over,24,24,40,40,1.0"], "overlap"),
        (lambda lines: lines[:4], "too few"),
    ],
)
def test_bad_patches_are_refused_with_a_sentence(
    change: Callable[[list[str]], list[str]], sentence: str, shots: Path, tmp_path: Path
) -> None:
    lines = change((shots / "patches.csv").read_text().splitlines())
    (tmp_path / "patches.csv").write_text("\n".join(lines) + "\n")
    done = start(shots / "nominal_0.dng", "--patches", tmp_path / "patches.csv", "-o", tmp_path / "out")
    assert done.returncode == 2
    assert sentence in done.stderr
    assert "Traceback" not in done.stderr
    assert not (tmp_path / "out").exists()


def test_a_file_given_twice_counts_once(shots: Path, tmp_path: Path) -> None:
    copy = tmp_path / "copy.dng"
    copy.write_bytes((shots / "nominal_0.dng").read_bytes())
    results = measured(tmp_path / "out", shots / "nominal_0.dng", copy, "--patches", shots / "patches.csv")
    assert "duplicate-frame" in codes(results)
    assert "mixed" in found(results, "k_fpn", "all", "gamma-likelihood")["flags"]
