"""The loop closed: a camera is simulated, measured again through the front door, and judged by its truth."""

import json
import subprocess
import sys
import tempfile
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Final

import numpy as np
import pytest

from fullwell.errors import UsageError
from fullwell.simulate.config_text import config_text
from fullwell.simulate.truth import true_values
from fullwell.testing import simulation
from fullwell.workflow.loop.design import LARGEST_PATCH, MOST_PIXELS, design_of
from fullwell.workflow.loop.loop import LoopOptions, loop
from fullwell.workflow.loop.repeats import Repeat, run_repeat
from fullwell.workflow.loop.source import source_of

CAMERAS: Final = 3
NORMAL_1E4: Final = 3.89
"""Two-sided p of a normal number is 1e-4."""
STUDY: Final = {
    "isos": [100],
    "flat": {"exposures_s": [0.001, 0.002, 0.004], "electrons": [1000.0, 2000.0, 4000.0], "frames": 3},
    "dark": {"exposures_s": [0.5, 1.0, 2.0], "frames": 3},
    "bias": {"exposures_s": [0.0001], "frames": 5},
}
EMVA: Final = """
design = "chart"
[figures]
system_gain = 0.425
read_noise = 2.36
dsnu = 0.703
prnu = 0.687
digital_maximum = 4095
black = 128
"""


def start(*arguments: str | Path) -> "subprocess.CompletedProcess[str]":
    command = [sys.executable, "-m", "fullwell", "loop", *map(str, arguments)]
    return subprocess.run(command, check=False, capture_output=True, text=True)


def read(out: Path) -> tuple[Mapping, Mapping]:
    return tuple(json.loads((out / name).read_text(encoding="utf-8")) for name in ("results.json", "loop.json"))


@pytest.fixture(scope="module")
def closed(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Three cameras of a config, measured through the command line."""
    folder = tmp_path_factory.mktemp("loop")
    config = folder / "camera.toml"
    config.write_text(config_text(simulation(seed=5, study=STUDY).table), encoding="utf-8")
    done = start(config, "-o", folder / "out", "--repeat", str(CAMERAS), "--workers", "2")
    assert done.returncode == 0, done.stderr
    assert f"{CAMERAS} cameras" in done.stdout
    assert "sd/error" in done.stdout
    assert f"saturation capacity {4 * CAMERAS} of {4 * CAMERAS}, snr max" in done.stdout  # no channel saturates
    return folder / "out"


def test_every_figure_stands_beside_its_truth(closed: Path) -> None:
    results, document = read(closed)
    assert (results["schema"], document["schema"]) == ("fullwell-results/1", "fullwell-loop/1")
    assert (document["cameras"], document["source_is"], document["seed"]) == (CAMERAS, "config", 5)
    truth = {
        (one.quantity, one.channel, one.unit, one.iso, one.snr_threshold, one.exposure_s): one.value
        for one in true_values(simulation(seed=5, study=STUDY))
    }
    judged = 0
    for one in document["figures"]:
        name = tuple(one[key] for key in ("quantity", "channel", "unit", "iso", "snr_threshold"))
        assert one["truth"] == truth.get((*name, one["exposure_s"]), truth.get((*name, None)))
        if one["recommended"] == "yes" and one["pull"] is not None:
            judged += 1
            assert abs(one["pull"]) < NORMAL_1E4, one
            assert abs(one["pull_mean"]) < NORMAL_1E4 / np.sqrt(CAMERAS), one
    assert judged > 60


def test_cameras_are_different_and_their_frames_are_gone(closed: Path) -> None:
    _, document = read(closed)
    (row,) = (
        one
        for one in document["figures"]
        if (one["quantity"], one["channel"], one["method"]) == ("system_gain", "all", "photon-transfer")
    )
    assert row["cameras"] == row["intervals"] == row["pulls"] == CAMERAS
    assert row["sd"] > 0.0
    assert row["bias"] == pytest.approx(row["mean"] - row["truth"])
    full = [one for one in document["figures"] if one["quantity"] == "saturation_capacity"]
    assert {(one["bounds"], one["bias"], one["bias_std_error"], one["pulls"]) for one in full} == {
        (CAMERAS, None, None, 0)
    }
    assert not (closed / "study").exists()
    assert not (closed / "repeats").exists()


def test_the_report_has_a_chapter_on_the_loop(closed: Path) -> None:
    page = (closed / "report.html").read_text(encoding="utf-8")
    for text in (
        "The loop closed",
        f"{4 * CAMERAS} of {4 * CAMERAS}",
        "Original beside simulated",
        "Coverage and bias",
        "published methods would have",
    ):
        assert text in page
    curves = read(closed)[0]["curves"]
    assert set(curves["loop_transfer"]["whose"]["values"]) == {"simulated", "truth"}
    pulls = curves["loop_pulls"]
    for quantity in set(pulls["quantity"]["values"]):
        at = [index for index, one in enumerate(pulls["quantity"]["values"]) if one == quantity]
        assert np.all(np.diff([pulls["pull"]["values"][index] for index in at]) >= 0.0)


def test_a_measured_camera_is_its_own_truth(closed: Path, tmp_path: Path) -> None:
    """The original's figures become the simulation's truth; measured again they are found within their errors."""
    before = read(closed)[0]
    outcome = loop(closed, tmp_path / "again", options=LoopOptions(keep=True))
    rows = {
        (row["quantity"], row["channel"], row["unit"]): row["value"]
        for row in before["results"]
        if "recommended" in row["flags"] and row["snr_threshold"] is None
    }
    _, document = read(tmp_path / "again")
    assert (document["source_is"], document["cameras"]) == ("results", 1)
    frames = list((tmp_path / "again" / "study").rglob("*.dng"))
    assert len(frames) == document["design"]["frames"] == 9 + 9 + 5
    shown = {(one["quantity"], one["channel"], one["unit"]): one for one in document["figures"] if one["pull"]}
    for quantity, unit in (("system_gain", "DN/e-"), ("read_noise", "e-"), ("prnu", "%"), ("dsnu", "e-")):
        one = shown[quantity, "all", unit]
        assert one["original"] == rows[quantity, "all", unit]
        # Row and column parts that came out below zero cannot be simulated: the whole moves by a part of its error.
        assert abs(one["truth"] - one["original"]) <= 0.25 * one["original_std_error"]
        assert abs(one["pull"]) < NORMAL_1E4
    whose = {column.name: column.values for column in curve_named(outcome.results.curves, "loop_transfer")}["whose"]
    assert set(whose) == {"original", "simulated", "truth"}


def curve_named(curves: Sequence, name: str) -> Sequence:
    return next(curve.columns for curve in curves if curve.name == name)


def test_figures_do_not_depend_on_the_number_of_workers(closed: Path, tmp_path: Path) -> None:
    config = tmp_path / "camera.toml"
    config.write_text(config_text(simulation(seed=5, study=STUDY).table), encoding="utf-8")
    loop(config, tmp_path / "one", options=LoopOptions(repeats=CAMERAS, workers=1))
    assert read(tmp_path / "one")[1]["figures"] == read(closed)[1]["figures"]


def test_sums_of_further_cameras_lie_with_their_frames(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A process that is ended leaves them, and they go with the frames."""
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path / "nowhere"))
    config = simulation(seed=1, study=STUDY)
    assert run_repeat(Repeat(config=config, folder=tmp_path / "one", keep=False))
    assert list(tmp_path.iterdir()) == []


def test_published_figures_are_a_camera(tmp_path: Path) -> None:
    path = tmp_path / "emva.toml"
    path.write_text(EMVA, encoding="utf-8")
    source = source_of(path)
    assert source.kind == "figures"
    k = {one.quantity: one.value for one in true_values(source.config) if one.channel == "all" and one.unit == "1"}
    assert k["k_shot"] == pytest.approx(np.sqrt(0.425 / 4095))
    assert k["k_fpn"] == pytest.approx(0.00687)
    dark = 0.425 * np.sqrt(2.36**2 + 0.703**2 + 1.0 / (12.0 * 0.425**2)) / 4095
    assert k["k_dark"] == pytest.approx(dark)


def test_large_frames_are_reduced_by_the_rule_and_full_ones_are_not() -> None:
    large = simulation(camera={"width": 4032, "height": 3024})
    reduced = design_of(large, full=False)
    width, height = reduced.size
    assert width * height <= MOST_PIXELS < 4 * width * height
    pitch = large.sensor.pixel_pitch_um
    assert width * reduced.config.sensor.pixel_pitch_um == pytest.approx(4032 * pitch, rel=0.02)
    assert reduced.original_size == (4032, 3024)
    full = design_of(large, full=True)
    assert (full.size, full.reduced, full.config) == ((4032, 3024), False, large)


def test_patches_of_a_chart_are_cut_and_laid_side_by_side() -> None:
    densities = [0.25 * step for step in range(12)]
    config = simulation(
        camera={"width": 2400, "height": 1600},
        study={"isos": [100], "chart": {"exposures_s": [0.01], "electrons": [5000.0], "frames": 2}},
        chart={"densities": densities},
    )
    design = design_of(config, full=False)
    chart = design.config.chart
    assert chart is not None
    assert [patch.density for patch in chart.measured] == pytest.approx(densities)
    assert {(patch.width, patch.height) for patch in chart.measured} == {(LARGEST_PATCH, LARGEST_PATCH)}
    assert design.size[0] * design.size[1] < 2 * 12 * LARGEST_PATCH**2
    for one in chart.measured:
        assert one.x + one.width <= design.size[0]
        assert one.y + one.height <= design.size[1]


@pytest.mark.parametrize(
    ("name", "text", "said"),
    [
        ("missing.toml", None, "is nothing to start from"),
        ("photo.dng", "II", "is nothing to start from"),
        ("results.json", "{}", "is no results document"),
        ("results.json", "[1", "is no results document"),
        ("camera.toml", "[camera", "is not TOML"),
        ("camera.toml", "[camera]\nwidht = 3", "Did you mean width?"),
        ("figures.toml", "[figures]\nk_drak = 1", "figures.k_drak is not a key"),
        ("figures.toml", "[figures]\nk_dark = 'a'", 'k_dark = "a" is not a number'),
        ("figures.toml", "seed = -1\n[figures]\nk_dark = 1", "seed = -1 cannot be used"),
        ("figures.toml", "design = 'x'\n" + EMVA.replace('design = "chart"', ""), 'no design "x"'),
    ],
)
def test_bad_sources_are_refused_with_a_sentence(name: str, text: str | None, said: str, tmp_path: Path) -> None:
    path = tmp_path / name
    if text is not None:
        path.write_text(text, encoding="utf-8")
    with pytest.raises(UsageError, match=r".") as refused:
        loop(path, tmp_path / "out", options=LoopOptions())
    assert said in str(refused.value)
    assert not (tmp_path / "out").exists()
