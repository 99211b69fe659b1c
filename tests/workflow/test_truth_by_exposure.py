"""Figures that are told of each burst have the truth of their exposure: DSNU, total dark noise, shading."""

from pathlib import Path

import pytest

from fullwell.frames.selection import Selection
from fullwell.simulate.truth import true_values
from fullwell.testing import simulated_study, simulation
from fullwell.workflow.characterize import measure
from fullwell.workflow.loop.comparison import compared
from fullwell.workflow.options import Options

STUDY = {
    "flat": {"exposures_s": [0.001, 0.002, 0.004], "electrons": [1000.0, 2000.0, 4000.0], "frames": 3},
    "dark": {"exposures_s": [0.5, 1.0, 2.0], "frames": 4},
    "bias": {"exposures_s": [0.0001], "frames": 5},
}


def test_every_burst_meets_its_own_truth(tmp_path: Path) -> None:
    config = simulation(
        seed=21,
        camera={"dark_current": 40.0, "dark_current_spread": 6.0, "pixel_pitch_um": 4.0},
        lens={"shading": "cos4", "focal_length_mm": 0.8, "flare": 0.05},
        study=STUDY,
    )
    simulated_study(tmp_path / "study", config)
    results = measure(tmp_path / "study", options=Options(selection=Selection(), workers=1)).results
    found = compared(results.rows, true_values(config))
    dsnu = [one for one in found if one.row.quantity == "dsnu" and one.row.exposure_s and one.row.measured.unit == "DN"]
    assert {one.row.exposure_s for one in dsnu} == {0.5, 1.0, 2.0}
    assert len({one.truth for one in dsnu}) == 3
    dark = [one for one in found if one.row.quantity == "total_dark_noise"]
    assert len(dark) == 2 * 3 * 4
    shading = [
        one for one in found if one.row.quantity.startswith("shading_") and one.row.method in {"radial", "p-spline"}
    ]
    assert {one.row.quantity for one in shading} == {"shading_corner", "shading_edge_x", "shading_edge_y"}
    assert min(one.truth for one in shading) < 0.85
    judged = [one for one in (*dsnu, *dark, *shading) if one.pull is not None]
    assert len(judged) > 100
    # Two-sided p of a normal number above 1e-5, for each of fewer than 300 figures.
    assert [one for one in judged if abs(one.pull or 0.0) > 4.5] == []


@pytest.mark.parametrize("bias", [None, {"exposures_s": [0.0001], "frames": 1}])
def test_without_bias_frames_read_noise_is_told_and_judged_without_dark_current(
    tmp_path: Path, bias: dict[str, object] | None
) -> None:
    study = {"dark": STUDY["dark"], **({} if bias is None else {"bias": bias})}
    config = simulation(seed=22, camera={"dark_current": 40.0}, study=study)
    simulated_study(tmp_path / "study", config)
    results = measure(tmp_path / "study", options=Options(selection=Selection(), workers=1)).results
    found = [one for one in compared(results.rows, true_values(config)) if one.row.method == "temporal-variance"]
    assert len(found) == 10
    # Two-sided p of a normal number above 1e-5, for each of fewer than 300 figures.
    assert [one for one in found if abs(one.pull or 0.0) > 4.5] == []


def test_noise_of_whole_frames_is_none_of_a_single_frame(tmp_path: Path) -> None:
    config = simulation(seed=23, camera={"read_noise_frame": 4.0}, study=STUDY)
    simulated_study(tmp_path / "study", config)
    results = measure(tmp_path / "study", options=Options(selection=Selection(), workers=1)).results
    found = [one for one in compared(results.rows, true_values(config)) if one.row.quantity == "k_dark_variance"]
    assert {one.row.channel for one in found} == {"R", "G1", "G2", "B", "all"}
    still = {one.value for one in true_values(simulation(seed=23, study=STUDY)) if one.quantity == "k_dark_variance"}
    assert {one.truth for one in found} == still
    # Two-sided p of a normal number above 1e-5.
    assert [one for one in found if abs(one.pull or 0.0) > 4.5] == []
