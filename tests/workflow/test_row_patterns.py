"""A fixed pattern of whole rows: tiles take part of it off, and channels share it."""

from pathlib import Path

from fullwell.frames.selection import Selection
from fullwell.glossary import RECOMMENDED
from fullwell.simulate.truth import true_values
from fullwell.testing import simulated_study, simulation
from fullwell.workflow.characterize import measure
from fullwell.workflow.loop.comparison import compared
from fullwell.workflow.options import Options

PATTERNED = {"width": 256, "height": 192, "dsnu_row": 1.0, "prnu_row": 0.6}
STUDY = {
    "flat": {"exposures_s": [0.001, 0.002, 0.003, 0.006], "electrons": [1000.0, 2000.0, 3000.0, 6000.0], "frames": 4},
    "dark": {"exposures_s": [0.5, 1.0, 2.0], "frames": 4},
    "bias": {"exposures_s": [0.0001], "frames": 8},
}


def test_noise_coefficients_hold_the_rows_that_tiles_take_off(tmp_path: Path) -> None:
    config = simulation(seed=33, camera=PATTERNED, study=STUDY)
    simulated_study(tmp_path / "study", config)
    results = measure(tmp_path / "study", options=Options(selection=Selection(), workers=1)).results
    found = [one for one in compared(results.rows, true_values(config)) if one.recommended]
    ks = [one for one in found if one.row.quantity in {"k_dark", "k_fpn"}]
    assert len(ks) == 10
    # Two-sided p of a normal number above 1e-5; without the rows some are 10 errors off.
    assert [one for one in ks if abs(one.pull or 0.0) > 4.5] == []
    errors = {(one.row.quantity, one.row.channel): one.row.measured.std_error or 0.0 for one in found}
    for quantity in ("k_fpn", "prnu_row", "dsnu_row"):
        # a row belongs to two channels: the mean of four is no better than that of two
        assert errors[quantity, "all"] > 0.5 * sum(errors[quantity, name] for name in ("R", "G1", "G2", "B")) / 4.0


def test_rows_that_tiles_leave_are_the_degrees_of_freedom(tmp_path: Path) -> None:
    """Planes of 24 rows in tiles of 8 tell a pattern of rows with 15 degrees of freedom, not 23; channels share it."""
    camera = {"width": 64, "height": 48, "prnu": 0.6, "prnu_row": 0.6}
    simulated_study(tmp_path / "study", simulation(seed=2, camera=camera, study=STUDY))
    results = measure(tmp_path / "study", options=Options(selection=Selection(), workers=1)).results
    found = {(one.quantity, one.channel): one.measured for one in results.rows if RECOMMENDED in one.flags}
    for channel in ("R", "G1", "G2", "B"):
        rows = found["prnu_row_variance", channel]
        assert rows.dof is not None
        assert rows.dof < 23.0
        of_rows = 1e-4 * rows.value * (2.0 / 15.0) ** 0.5
        assert (found["k_fpn_variance", channel].std_error or 0.0) > of_rows
