"""A camera that was measured comes back as a config: its truth within the errors, its design to the frame."""

import json
import math
from pathlib import Path

import pytest

from fullwell.errors import UsageError
from fullwell.simulate.config import parse_config
from fullwell.simulate.config_text import config_text
from fullwell.simulate.plan import plan
from fullwell.simulate.truth import true_values
from fullwell.testing import simulated_study, simulation
from fullwell.workflow.characterize import characterize
from fullwell.workflow.chart.chart import ChartOptions, chart
from fullwell.workflow.chart.patches import WhereAbouts
from fullwell.workflow.model_figures import StatedFigures, models_of_figures
from fullwell.workflow.options import Options
from fullwell.workflow.simulation.camera import camera_from_models, camera_from_results

STUDY = {
    "isos": [100, 400],
    "flat": {"exposures_s": [0.001, 0.002, 0.003, 0.004], "electrons": [800.0, 1600.0, 2400.0, 3200.0], "frames": 3},
    "dark": {"exposures_s": [0.5, 1.0, 2.0], "frames": 3},
    "bias": {"exposures_s": [0.0001], "frames": 5},
}


def test_a_measured_study_becomes_its_camera_and_its_design(tmp_path: Path) -> None:
    lens = {"shading": "cos4", "focal_length_mm": 0.4}
    truth = simulation(study=STUDY, lens=lens)
    characterize(simulated_study(tmp_path / "study", truth).root, tmp_path / "out", options=Options(workers=1))
    document = json.loads((tmp_path / "out" / "results.json").read_text(encoding="utf-8"))
    config = camera_from_results(document).config
    assert sorted(taken(config)) == sorted(taken(truth))
    n = 192 * 128
    for iso in (100, 400):
        mine, true = config.sensor_at(iso), truth.sensor_at(iso)
        assert mine.system_gain_at(iso) == pytest.approx(true.system_gain_at(iso), rel=0.05)
        assert mine.read_noise == pytest.approx(true.read_noise, rel=0.06)  # system gain's error and its own
        assert mine.read_noise_row == pytest.approx(true.read_noise_row, abs=0.1)
        assert mine.black_level == pytest.approx((256.0,) * 4, abs=5.0 * 2.0 / math.sqrt(n / 4))
    assert config.sensor.response == pytest.approx(truth.sensor.response, rel=5.0 / math.sqrt(3 * 800.0 * n / 4) * 4.0)
    assert (config.sensor.width, config.sensor.height, config.sensor.cfa) == (192, 128, "BGGR")
    assert parse_config(config_text(config.table), name="again", folder=Path()) == config
    shaded = camera_from_results(document, folder=tmp_path / "out").config
    lens = shaded.lens.map_for(shaded.sensor)
    green = lens[1::2, 0::2]
    expected = truth.lens.map_for(truth.sensor)[1::2, 0::2]
    levels = [[one.electrons for one in made.study.series if one.kind == "flat"] for made in (config, shaded)]
    # 5 standard errors of a tenth of a plane at 3200 e-
    bound = 5.0 / math.sqrt(3200.0 * 3 * n / 40)
    for level, plain in zip(levels[1], levels[0], strict=True):
        assert level * green.mean() == pytest.approx(plain, rel=1e-3)
    assert green[28:36, 44:52].mean() / green.mean() == pytest.approx(
        expected[28:36, 44:52].mean() / expected.mean(), rel=bound + 2e-3
    )


def taken(config):
    return [
        (frame.kind, frame.exposure.iso, frame.exposure.exposure_s, frame.exposure.electrons > 0.0)
        for frame in plan(config)
    ]


def test_a_measured_chart_becomes_its_patches_and_their_light(tmp_path: Path) -> None:
    densities = [round(0.3 + 0.15 * number, 2) for number in range(12)]
    truth = simulation(
        camera={"width": 320, "height": 240, "dsnu": 0.0, "dark_current": 0.0},
        lens={"flare": 0.005},
        chart={"densities": densities},
        study={"chart": {"exposures_s": [0.008, 0.001], "electrons": [6000.0, 750.0], "frames": 2}},
    )
    study = simulated_study(tmp_path / "study", truth)
    patches = study.root / "chart" / "ISO_100" / "PATCHES.csv"
    asked = ChartOptions(where=WhereAbouts(patches=(patches,)))
    images = sorted(patches.parent.glob("*.dng"))
    chart(images, tmp_path / "out", options=Options(workers=1), asked=asked)
    config = camera_from_results(json.loads((tmp_path / "out" / "results.json").read_text(encoding="utf-8"))).config
    assert sorted(taken(config)) == sorted(taken(truth))
    seen = config.chart
    assert seen is not None
    assert [(one.x, one.y, one.width, one.height) for one in seen.measured] == [
        (one.x, one.y, one.width, one.height) for one in truth.chart.measured
    ]
    lights = {one.name: light[1] for one, light in zip(seen.measured, seen.light, strict=True)}
    assert lights["5"] / lights["1"] == pytest.approx(10.0**-0.6, rel=0.05)
    document = json.loads((tmp_path / "out" / "results.json").read_text(encoding="utf-8"))
    fixed = next(
        row["value"]
        for row in document["results"]
        if row["quantity"] == "k_fpn_variance" and row["channel"] == "all" and "recommended" in row["flags"]
    )
    assert config.sensor.prnu**2 == pytest.approx(max(fixed, 0.0), rel=1e-9)
    levels = sorted({frame.exposure.electrons for frame in plan(config)})
    assert levels == pytest.approx([750.0, 6000.0], rel=0.1)
    stray = next(row for row in document["results"] if row["quantity"] == "flare" and row["channel"] == "all")
    true_flare = next(one.value for one in true_values(truth) if one.quantity == "flare")
    assert true_flare == pytest.approx(0.005 / 10.0**-0.3)
    assert abs(stray["value"] - true_flare) < 4 * stray["std_error"]
    assert abs(config.lens.flare - 0.005) < 4 * stray["std_error"] * 10.0**-0.3


def test_a_chart_that_is_named_is_found_where_it_was_put(tmp_path: Path) -> None:
    truth = simulation(
        camera={
            "width": 640,
            "height": 480,
            "cfa": "RGGB",
            "bit_depth": 14,
            "white_level": 16383,
            "full_well": 31000.0,
        },
        chart={"name": "dynamic-range-36-grid"},
        study={"chart": {"exposures_s": [0.02], "electrons": [25000.0], "frames": 1}},
    )
    images = sorted((simulated_study(tmp_path / "study", truth).root / "chart").rglob("*.dng"))
    asked = ChartOptions(where=WhereAbouts(chart="dynamic-range-36-grid"))
    results = chart(images, tmp_path / "out", options=Options(workers=1), asked=asked)
    found = {patch["name"]: patch for patch in results.study["patches"]}
    assert truth.chart is not None
    for one in truth.chart.whole:
        mine = found[one.name]
        assert one.x <= mine["x"]
        assert mine["x"] + mine["width"] <= one.x + one.width
        assert one.y <= mine["y"]
        assert mine["y"] + mine["height"] <= one.y + one.height


def test_published_coefficients_and_figures_of_emva_become_cameras() -> None:
    a6000 = StatedFigures(k_dark=1.672e-4, k_shot=5.554e-3, k_fpn=5.477e-3, digital_maximum=16383.0, black=511.0)
    made = camera_from_models(models_of_figures(a6000))
    sensor = made.config.sensor
    gain = 16383.0 * 5.554e-3**2
    assert sensor.system_gain == pytest.approx(gain, rel=1e-12)
    assert (sensor.read_noise * gain) ** 2 + 1 / 12 == pytest.approx((1.672e-4 * 16383.0) ** 2, rel=1e-9)
    assert sensor.prnu == pytest.approx(5.477e-3, rel=1e-12)
    assert sensor.black_level == (511.0,) * 4
    assert len(plan(made.config)) == 2 * 4
    assert any("DSNU is not known" in one for one in made.said)
    emva = StatedFigures(system_gain=0.425, read_noise=2.36, dsnu=0.703, prnu=0.687, digital_maximum=4095.0)
    sony = camera_from_models(models_of_figures(emva), design="study")
    assert (sony.config.sensor.dsnu, sony.config.sensor.read_noise) == pytest.approx((0.703, 2.36), rel=1e-12)
    assert any("black level is not known" in one for one in sony.said)
    profile = StatedFigures(noise_profile=((3.3e-5, 9.2e-8),), white=15000.0, black=2048.0)
    phone = camera_from_models(models_of_figures(profile)).config.sensor
    assert phone.system_gain == pytest.approx(3.3e-5 * (15000.0 - 2048.0), rel=1e-12)
    with pytest.raises(UsageError, match="no design"):
        camera_from_models(models_of_figures(a6000), design="film")


def test_results_without_a_system_gain_are_refused() -> None:
    with pytest.raises(UsageError, match="no results document"):
        camera_from_results({"schema": "something"})
    study = {"width": 64, "height": 64, "cfa": "mono", "bit_depth": 12}
    with pytest.raises(UsageError, match="no system gain"):
        camera_from_results({"schema": "fullwell-results/1", "study": study, "results": [], "curves": {}})
