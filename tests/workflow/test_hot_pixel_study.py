"""Hot pixels, and dark current that differs between pixels: no figure of the light holds them."""

import pytest

from fullwell.figures.results import Results
from fullwell.frames.selection import Selection
from fullwell.simulate.truth import true_values
from fullwell.testing import simulated_study, simulation
from fullwell.workflow.characterize import measure
from fullwell.workflow.options import Options

CAMERA = {"dark_current_spread": 2.0, "hot_pixels": 0.002, "hot_pixel_current": 600.0, "prnu": 0.7}
FLATS = {"exposures_s": [0.001, 0.01, 0.5], "electrons": [4.0, 40.0, 2000.0], "frames": 8}
DARKS = {"exposures_s": [0.25, 1.0], "frames": 8}
"""None has the exposure of the flats; mixed, they have."""


@pytest.fixture(scope="module")
def measured(tmp_path_factory: pytest.TempPathFactory) -> tuple[Results, dict[tuple[str, str, str], float]]:
    study = {"flat": FLATS, "dark": DARKS, "bias": {"exposures_s": [0.0001], "frames": 8}}
    config = simulation(seed=12, camera=CAMERA, study=study, output={"optical_black": {"left": 32, "top": 16}})
    root = tmp_path_factory.mktemp("hot") / "study"
    simulated_study(root, config)
    truth = {(one.quantity, one.channel, one.unit): one.value for one in true_values(config)}
    return measure(root, options=Options(selection=Selection(), workers=1)).results, truth


def test_prnu_is_free_of_dark_current(measured: tuple[Results, dict[tuple[str, str, str], float]]) -> None:
    results, truth = measured
    rows = [
        row
        for row in results.rows
        if row.quantity in {"prnu", "prnu_pixel"} and "recommended" in row.flags and row.region is None
    ]
    assert {row.channel for row in rows} == {"R", "G1", "G2", "B", "all"}
    for row in rows:
        value = truth[row.quantity, row.channel, "%"]
        assert abs(row.measured.value - value) < 5.0 * (row.measured.std_error or 0.0)
        assert (row.measured.std_error or 0.0) < 0.1 * value
        assert "model-misfit" not in row.flags


def test_masked_pixels_count_where_dark_current_has_no_time(
    measured: tuple[Results, dict[tuple[str, str, str], float]],
) -> None:
    results, _ = measured
    assert not {finding.code for finding in results.findings} & {"optical-black-noisier", "optical-black-differs"}
    rows = [row for row in results.rows if row.method == "optical-black"]
    assert len(rows) == 4
    assert all(abs(row.measured.value - 256.0) < 5.0 * (row.measured.std_error or 0.0) for row in rows)
