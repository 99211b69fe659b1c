"""What the k's and volts are relative to: the converter's highest code, whether or not pixels fill before it."""

from pathlib import Path

import pytest

from fullwell.figures.results import Row
from fullwell.glossary import RECOMMENDED
from fullwell.simulate.truth import true_values
from fullwell.testing import simulated_study, simulation
from fullwell.units import DN, Measured
from fullwell.workflow.characterize import measure
from fullwell.workflow.loop.camera import options_for
from fullwell.workflow.loop.comparison import compared
from fullwell.workflow.measure.white_level import WhiteLevel, digital_maximum
from fullwell.workflow.simulation.measured_figures import Figures

FULL_BELOW_THE_RAIL = {
    "width": 96,
    "height": 64,
    "bit_depth": 8,
    "black_level": 12,
    "white_level": 255,
    "system_gain": 0.03,
    "full_well": 6500.0,
    "read_noise": 3.0,
    "read_noise_row": 0.0,
    "voltage_swing_v": 0.5,
}
STUDY = {
    "isos": [100],
    "flat": {"exposures_s": [0.001, 0.003, 0.006, 0.01], "electrons": [1e3, 3e3, 6e3, 1e4], "frames": 4},
    "dark": {"exposures_s": [0.5, 1.0], "frames": 3},
    "bias": {"exposures_s": [0.0001], "frames": 3},
}


def test_a_full_well_below_the_rail_changes_no_k(tmp_path: Path) -> None:
    """G1 and G2 fill at 207 of 255 DN and codes pile up there, R and B do not fill: k_shot was 11 % too large in two.

    The bound is four standard errors: by chance one run in 16 000 goes beyond it.
    """
    config = simulation(seed=3, camera=FULL_BELOW_THE_RAIL, study=STUDY)
    simulated_study(tmp_path / "s", config)
    rows = measure(tmp_path / "s", options=options_for(config, workers=1), progress=None, folder=None).results.rows
    found = [one for one in compared(rows, true_values(config)) if one.recommended]
    whites = {one.channel: one.measured.value for one in rows if one.quantity == "white_level" and one.flags}
    assert whites["G1"] == 207.0
    shots = {one.row.channel: one for one in found if one.row.quantity == "k_shot_variance"}
    assert set(shots) == {"R", "G1", "G2", "B", "all"}
    assert max(abs(one.pull or 0.0) for one in shots.values()) < 4.0
    assert "channels-differ" not in shots["all"].row.flags
    maxima = [one for one in found if one.row.quantity == "digital_maximum"]
    assert {(one.row.channel, one.row.measured.value, one.truth) for one in maxima} == {
        (channel, 255.0, 255.0) for channel in shots
    }
    noise = {one.row.measured.unit: one.row.measured.value for one in found if one.row.quantity == "read_noise"}
    assert noise["V"] == pytest.approx(noise["DN"] * 0.5 / 255.0, rel=1e-12)


def white(declared: float | None, seen: int, *, piles_up: bool) -> WhiteLevel:
    return WhiteLevel(channel="G1", declared=declared, seen=seen, piles_up=piles_up, n=1000)


@pytest.mark.parametrize(
    ("whites", "maximum_dn"),
    [
        pytest.param([white(255.0, 207, piles_up=True), white(255.0, 170, piles_up=False)], 255.0, id="full well"),
        pytest.param([white(15360.0, 16148, piles_up=False)], 15360.0, id="A6000: above the tag, no pile-up"),
        pytest.param([white(14558.0, 15070, piles_up=True)], 15070.0, id="6D: the tag of a straight response"),
        pytest.param([white(65535.0, 4095, piles_up=True), white(65535.0, 900, piles_up=False)], 4095.0, id="bits"),
        pytest.param([white(None, 3100, piles_up=True)], 3100.0, id="nothing declared"),
        pytest.param([white(None, 3100, piles_up=False)], None, id="nothing known"),
    ],
)
def test_the_digital_maximum_is_where_the_converter_ends(whites: list[WhiteLevel], maximum_dn: float | None) -> None:
    assert digital_maximum(whites) == maximum_dn


def level(quantity: str, channel: str, value: float) -> Row:
    told = Measured.exact(value, DN)
    return Row(quantity=quantity, channel=channel, method="measured", measured=told, source="x", flags=(RECOMMENDED,))


def test_a_camera_made_from_results_has_their_digital_maximum() -> None:
    """Twelve bits in numbers of sixteen: R and B do not pile up, and keep the white level of the file."""
    declared = [level("white_level", channel, 65535.0) for channel in "RB"]
    seen = [level("white_level", channel, 4095.0) for channel in ("G1", "G2")]
    study = {"cfa": "RGGB", "bit_depth": 16}
    known = Figures(study=study, rows=(level("digital_maximum", "all", 4095.0), *declared, *seen), curves={})
    assert known.digital_maximum(None) == 4095.0
    assert Figures(study=study, rows=(*declared, *seen), curves={}).digital_maximum(None) == 65535.0
    assert Figures(study=study, rows=(), curves={}).digital_maximum(None) == 65535.0
