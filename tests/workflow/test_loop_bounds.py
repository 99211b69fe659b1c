"""Figures of a loop that cannot be held against their truth: lower bounds, and noise that holds fixed pattern too."""

from pathlib import Path
from typing import Final

import numpy as np
import pytest

from fullwell.figures.results import Row
from fullwell.report.curves import Table
from fullwell.report.loop_figures import loop_figures, put_together
from fullwell.testing import simulation
from fullwell.units import DN, Measured
from fullwell.workflow.loop.camera import options_for, turn
from fullwell.workflow.loop.comparison import Comparison
from fullwell.workflow.loop.curves import figure_records
from fullwell.workflow.loop.tally import Tally, shares_of

TRUTH: Final = 1000.0
VALUES: Final = (980.0, 1010.0, 1020.0)


def full(channel: str, value: float, *, bound: bool) -> Comparison:
    measured = Measured.exact(value, DN) if bound else Measured.normal(value, 10.0, DN)
    flags = ("lower-bound", "recommended") if bound else ("recommended",)
    row = Row(quantity="saturation_capacity", channel=channel, method="plateau", measured=measured, flags=flags)
    return Comparison(row=row, truth=TRUTH, pull=None if bound else (value - TRUTH) / 10.0)


@pytest.fixture(scope="module", params=[0, 2])
def cameras(request: pytest.FixtureRequest) -> tuple[Tally, list[Comparison]]:
    """Three cameras; R is a bound in one of them, the first or the last, G1 in none."""
    tally = Tally()
    turns = [
        [full("R", value, bound=at == request.param), full("G1", value, bound=False)] for at, value in enumerate(VALUES)
    ]
    for one in turns:
        tally.add(shares_of(one))
    return tally, turns[0]


def test_a_bound_in_any_camera_has_no_bias_and_no_pull(cameras: tuple[Tally, list[Comparison]]) -> None:
    tally, first = cameras
    red, green = figure_records(first, {}, tally.calibrations())
    assert (red["cameras"], red["bounds"], red["intervals"]) == (3, 1, 2)
    assert {red[name] for name in ("bias", "bias_std_error", "sd", "scatter_ratio", "pull_mean", "pull_p")} == {None}
    assert red["pulls"] == tally.pulls(first[0].figure).size == 0
    assert (green["bounds"], green["pulls"], tally.pulls(first[1].figure).size) == (0, 3, 3)
    assert green["bias"] == pytest.approx(10.0 / 3.0)


def test_what_is_put_together_counts_the_cameras_with_a_bound(cameras: tuple[Tally, list[Comparison]]) -> None:
    tally, first = cameras
    records = figure_records(first, {}, tally.calibrations())
    table = Table(columns=tuple((name, tuple(one[name] for one in records)) for name in records[0]))
    figures = loop_figures(table)
    assert [one.bound for one in figures] == [True, False]
    (line,) = put_together(figures)
    assert (line.figures, line.bounds, line.cameras) == (2, 1, 6)
    assert line.bias == pytest.approx(10.0 / 3.0 / TRUTH)
    assert line.intervals == 3
    (none,) = put_together(figures[:1])
    assert (none.bounds, none.cameras, none.intervals) == (1, 3, 0)
    assert np.isnan([none.bias, none.bias_std_error, none.sd, none.scatter_ratio, none.pull_mean]).all()


def test_noise_that_holds_the_fixed_pattern_is_not_held_against_temporal_noise(tmp_path: Path) -> None:
    """One frame of a chart cannot tell DSNU from read noise; its k_fpn, told by how it grows with light, is judged."""
    config = simulation(
        seed=2,
        camera={"width": 480, "height": 320, "cfa": "mono", "read_noise": 2.0, "dsnu": 3.0, "black_level": 64.0},
        study={"isos": [100], "chart": {"exposures_s": [0.01, 0.00125], "electrons": [9000.0, 1125.0], "frames": 1}},
        chart={"densities": [0.1 * step for step in range(24)]},
    )
    found = turn(config, tmp_path / "chart", options=options_for(config, workers=1), progress=None)
    mixed = [one for one in found.compared if "mixed" in one.row.flags]
    noise = {one.row.quantity: one for one in mixed if one.row.quantity.startswith("read_noise")}
    assert noise["read_noise"].row.measured.value > noise["read_noise"].truth
    assert {one.pull for one in mixed if one.row.quantity.startswith("read_noise")} == {None}
    assert all(np.isnan(numbers[2:5]).all() for _, _, numbers in shares_of(noise.values()))
    (fixed,) = (one for one in mixed if one.row.quantity == "k_fpn")
    assert fixed.pull is not None
    assert np.isfinite(shares_of([fixed])[0][2]).all()
