"""Fixed pattern and shading through the command line: no pattern at all, and studies that lack something."""

import shutil
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from independent_study import FLAT_EXPOSURES_S, Sensor, Truth, write_dng, write_study

SMALL = Truth(width=256, height=192, isos=(100,), darks=3, flats=4, biases=5)


@pytest.fixture(scope="module")
def small_study(tmp_path_factory: pytest.TempPathFactory) -> Path:
    root = tmp_path_factory.mktemp("small") / "study"
    write_study(root, SMALL, seed=31, dark_exposures_s=(0.5, 2.0))
    return root


def rows_of(document: dict, quantity: str, method: str) -> list[dict]:
    return [row for row in document["results"] if row["quantity"] == quantity and row["method"] == method]


def codes_of(document: dict) -> set[str]:
    return {finding["code"] for finding in document["findings"]}


def test_without_prnu_the_interval_holds_zero_and_the_published_figure_does_not(
    characterize: Callable, tmp_path: Path
) -> None:
    write_study(tmp_path / "study", replace(SMALL, prnu=0.0), seed=8, dark_exposures_s=(0.5, 2.0))
    _, document = characterize(tmp_path / "study", tmp_path / "out")
    rows = [
        row
        for method in ("flat-dark-stack", "exposure-slope")
        for row in rows_of(document, "prnu", method)
        if row["region"] is None and row["channel"] != "all"
    ]
    assert len(rows) == 8
    # eight 95 % intervals, at most two of which miss with a probability of 0.994
    assert sum(row["ci95_low"] > 0.0 for row in rows) <= 2
    assert all((row["value"] == 0.0) == ("upper-limit" in row["flags"]) for row in rows)
    published = [row["value"] for row in rows_of(document, "prnu", "legacy-slope-std") if row["channel"] in "RB"]
    assert published
    assert min(published) > 0.5


def test_one_flat_exposure_is_said_and_the_stack_still_measured(
    small_study: Path, characterize: Callable, tmp_path: Path
) -> None:
    study = tmp_path / "study"
    shutil.copytree(small_study, study)
    kept = f"{round(FLAT_EXPOSURES_S[2] * 1e6):08d}"
    for path in (study / "flat").rglob("*.dng"):
        if not path.name.startswith(kept):
            path.unlink()
    _, document = characterize(study, tmp_path / "out")
    assert "one-flat-exposure" in codes_of(document)
    stack = [row for row in rows_of(document, "prnu", "flat-dark-stack") if row["region"] is None]
    assert {row["channel"] for row in stack} == {"R", "G1", "G2", "B", "all"}
    assert not rows_of(document, "prnu", "exposure-slope")
    assert rows_of(document, "shading_corner", "p-spline")


def test_missing_darks_are_said_and_slopes_measure_what_they_can(
    small_study: Path, characterize: Callable, tmp_path: Path
) -> None:
    study = tmp_path / "study"
    shutil.copytree(small_study, study, ignore=shutil.ignore_patterns("dark", "bias"))
    _, document = characterize(study, tmp_path / "out", "--black", str(SMALL.black))
    assert {"no-dark-stack", "no-dark-frames", "no-bias-frames"} <= codes_of(document)
    prnu = [row for row in rows_of(document, "prnu", "exposure-slope") if row["region"] is None]
    assert all("recommended" in row["flags"] for row in prnu)
    truth = 100 * SMALL.prnu
    assert all(abs(row["value"] - truth) < 5 * row["std_error"] for row in prnu)
    assert [row for row in rows_of(document, "dsnu", "exposure-intercept") if "recommended" in row["flags"]]


def test_saturated_flats_are_left_out_and_named(small_study: Path, characterize: Callable, tmp_path: Path) -> None:
    study = tmp_path / "study"
    shutil.copytree(small_study, study)
    rng = np.random.default_rng(3)
    for number in range(4):
        mosaic = np.full((SMALL.height, SMALL.width), SMALL.white, np.uint16)
        mosaic[::7, ::5] -= rng.integers(1, 9, mosaic[::7, ::5].shape, dtype=np.uint16)
        write_dng(
            study / "flat" / "ISO_100" / f"bright_{number}.dng",
            mosaic,
            iso=100,
            exposure_s=0.05,
            black=SMALL.black,
            white=SMALL.white,
        )
    _, document = characterize(study, tmp_path / "out")
    said = [finding for finding in document["findings"] if finding["code"] == "flats-saturated"]
    assert len(said) == 1
    assert "50 ms" in said[0]["message"]
    assert "shading-not-measured" in codes_of(document)
    prnu = [row for row in rows_of(document, "prnu", "exposure-slope") if row["region"] is None]
    assert all(abs(row["value"] - 100 * SMALL.prnu) < 5 * row["std_error"] for row in prnu)


def test_other_sizes_and_cfas_are_named_and_change_nothing(
    small_study: Path, characterize: Callable, tmp_path: Path
) -> None:
    _, clean = characterize(small_study, tmp_path / "clean")
    study = tmp_path / "study"
    shutil.copytree(small_study, study)
    flat = study / "flat" / "ISO_100"
    mosaic = np.full((SMALL.height // 2, SMALL.width), 900, np.uint16)
    write_dng(flat / "small.dng", mosaic, iso=100, exposure_s=0.004, black=SMALL.black, white=SMALL.white)
    _, document = characterize(study, tmp_path / "out")
    assert any("small.dng" in file for finding in document["findings"] for file in finding["files"])
    assert document["results"] == clean["results"]


def test_a_flickering_lamp_over_a_shaded_field_is_said_and_moves_no_prnu(
    characterize: Callable, tmp_path: Path
) -> None:
    truth = replace(SMALL, flats=5)
    study = tmp_path / "study"
    write_study(study, truth, seed=77, dark_exposures_s=(0.5, 2.0))
    sensor = Sensor(truth, 77)
    rng = np.random.default_rng(2)
    for path in sorted((study / "flat").rglob("*.dng")):
        exposure_s = int(path.stem.split("_")[0]) / 1e6
        mosaic = sensor.frame(iso=100, exposure_s=exposure_s * (1 + 0.05 * rng.standard_normal()), lit=True)
        write_dng(path, mosaic, iso=100, exposure_s=exposure_s, black=truth.black, white=truth.white)
    _, document = characterize(study, tmp_path / "out")
    assert "flat-flicker" in codes_of(document)
    for quantity, expected in (("prnu_variance", (100 * truth.prnu) ** 2), ("prnu_row_variance", 0.0)):
        rows = [row for row in rows_of(document, quantity, "flat-dark-stack") if row["region"] is None]
        assert all(abs(row["value"] - expected) < 5 * row["std_error"] for row in rows)


def test_a_dark_burst_much_longer_than_the_flats_is_not_set_against_them(
    small_study: Path, characterize: Callable, tmp_path: Path
) -> None:
    study = tmp_path / "study"
    shutil.copytree(small_study, study, ignore=shutil.ignore_patterns("bias"))
    _, document = characterize(study, tmp_path / "out")
    assert "no-dark-stack" in codes_of(document)
    assert not rows_of(document, "prnu", "flat-dark-stack")


@pytest.mark.parametrize(("width", "height"), [(201, 151), (200, 150), (64, 48)])
def test_odd_sizes_and_slivers_of_tiles_are_measured(
    width: int, height: int, characterize: Callable, tmp_path: Path
) -> None:
    truth = replace(SMALL, width=width, height=height, flats=2, darks=2, biases=2)
    write_study(tmp_path / "study", truth, seed=5, dark_exposures_s=(0.5, 2.0))
    _, document = characterize(tmp_path / "study", tmp_path / "out")
    rows = [row for row in rows_of(document, "prnu_variance", "flat-dark-stack") if row["region"] is None]
    assert len(rows) == 5
    assert all(row["std_error"] > 0 for row in rows)
