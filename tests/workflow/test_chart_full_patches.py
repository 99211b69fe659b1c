"""Patches whose pixels fill below the white level are on no curve."""

from pathlib import Path

import pytest

from fullwell.frames.selection import Selection
from fullwell.simulate.truth import true_values
from fullwell.testing import simulated_study, simulation
from fullwell.workflow.characterize import measure
from fullwell.workflow.loop.comparison import compared
from fullwell.workflow.options import Options

CAMERA = {
    "width": 300,
    "height": 216,
    "cfa": "mono",
    "bit_depth": 14,
    "white_level": 16383,
    "black_level": 511,
    "read_noise": 3.0,
    "prnu": 0.5,
    "dark_current": 0.0,
}
CHART = {"densities": [round(0.13 * step, 3) for step in range(24)], "columns": 6, "fill": 0.8, "margin": 0.02}


@pytest.mark.parametrize("frames", [1, 2])
@pytest.mark.parametrize("full_well", [20000.0, 9000.0])
def test_full_patches_bend_no_curve_and_are_no_flare(tmp_path: Path, frames: int, full_well: float) -> None:
    taken = {"exposures_s": [0.02, 0.0025], "electrons": [28000.0, 3500.0], "frames": frames}
    config = simulation(
        seed=7,
        camera={**CAMERA, "full_well": full_well},
        lens={"flare": 3e-4},
        chart=CHART,
        study={"isos": [100], "chart": taken},
    )
    simulated_study(tmp_path / "study", config)
    results = measure(tmp_path / "study", options=Options(selection=Selection(), workers=1)).results
    found = {one.row.quantity: one for one in compared(results.rows, true_values(config)) if one.recommended}
    # Two-sided p of a normal number above 1e-5; with full patches flare was 2.5 times too high, k_fpn nothing.
    for quantity in ("system_gain", "k_shot_variance", "k_fpn_variance", "k_dark_variance", "flare", "black_level"):
        assert abs(found[quantity].pull or 0.0) < 4.5, quantity
    low, high = found["saturation_capacity"].row.measured.ci95 or (0.0, 0.0)
    assert low <= found["saturation_capacity"].truth <= high
    assert "over-exposed" in {finding.code for finding in results.findings}
    assert not {"response-bends", "noise-model-misfit"} & {finding.code for finding in results.findings}
