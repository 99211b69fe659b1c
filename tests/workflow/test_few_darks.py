"""Unlit frames of few exposures, and levels that whole frames share."""

import math
from pathlib import Path

from fullwell.figures.results import Results
from fullwell.frames.selection import Selection
from fullwell.testing import simulated_study, simulation
from fullwell.workflow.characterize import measure
from fullwell.workflow.options import Options

FLAT = {"exposures_s": [0.001, 0.002, 0.003, 0.006], "electrons": [1000.0, 2000.0, 3000.0, 6000.0], "frames": 3}


def _measured(folder: Path, dark: dict[str, object], **camera: float) -> Results:
    config = simulation(seed=5, camera={"width": 96, "height": 96, **camera}, study={"flat": FLAT, "dark": dark})
    simulated_study(folder, config)
    return measure(folder, options=Options(selection=Selection(), workers=1)).results


def test_all_channels_together_know_a_level_they_share_no_better(tmp_path: Path) -> None:
    results = _measured(tmp_path / "study", {"exposures_s": [0.5, 1.0, 2.0], "frames": 3}, read_noise_frame=1.0)
    for quantity, method in (("black_level", "fused"), ("k_dark_variance", "gamma-likelihood")):
        rows = {row.channel: row.measured for row in results.rows if (row.quantity, row.method) == (quantity, method)}
        own = [rows[channel].std_error or 0.0 for channel in ("R", "G1", "G2", "B")]
        # half as much, were the levels independent
        assert 0.9 * min(own) < (rows["all"].std_error or 0.0) < max(own)
        assert (rows["all"].dof or math.inf) < 30.0  # one burst more than the line needs, and metadata


def test_two_exposures_are_told_to_leave_drift_out(tmp_path: Path) -> None:
    results = _measured(tmp_path / "study", {"exposures_s": [0.5, 1.0], "frames": 3})
    assert "two-unlit-exposures" in {finding.code for finding in results.findings}


def test_read_noise_of_darks_too_close_together_is_not_extrapolated(tmp_path: Path) -> None:
    results = _measured(tmp_path / "study", {"exposures_s": [1.0, 1.006, 1.012], "frames": 3}, dark_current=4.0)
    rows = [row for row in results.rows if (row.quantity, row.measured.unit) == ("read_noise", "DN")]
    own = [row for row in rows if row.method == "temporal-variance"]
    assert len(own) == 5
    assert all("mixed" in row.flags for row in own)
    # dark current of 4 electrons beside 2.5^2 of read noise, at 0.5 DN/e-
    assert all(
        abs(row.measured.value - 0.5 * (6.25 + 4.0) ** 0.5) < 5.0 * (row.measured.std_error or 0.0) for row in own
    )


def test_hot_pixels_do_not_stand_for_levels_that_cover_all_phases(tmp_path: Path) -> None:
    camera = {"width": 96, "height": 96, "cfa": "mono", "read_noise": 0.4, "system_gain": 0.5, "dsnu": 0.1}
    hot = {"hot_pixels": 0.001, "hot_pixel_current": 400.0, "dark_current": 0.0}
    config = simulation(seed=1, camera=camera | hot, study={"isos": [100], "dark": {"exposures_s": [0.5, 1.0, 2.0]}})
    simulated_study(tmp_path / "hot", config)
    found = measure(tmp_path / "hot", options=Options(selection=Selection(), workers=1)).results
    (row,) = (
        one
        for one in found.rows
        if (one.quantity, one.method, one.measured.unit) == ("read_noise", "temporal-variance", "DN")
    )
    low, high = row.measured.ci95 or (1.0, 0.0)
    assert "quantization-limited" in row.flags
    assert low < 0.2 < high
