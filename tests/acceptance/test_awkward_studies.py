"""Studies that tempt a tool into a wrong number: the right one must come out, or a flag and a sentence."""

from dataclasses import replace
from pathlib import Path

import pytest
from independent_study import Truth, write_study
from scipy import stats

from fullwell.figures.results import Results, Row
from fullwell.workflow.characterize import measure
from fullwell.workflow.options import Options

SMALL = {"width": 192, "height": 128, "isos": (100,)}


def measured(folder: Path, truth: Truth, **plan: tuple[float, ...]) -> Results:
    write_study(folder, truth, seed=41, **plan)
    return measure(folder, options=Options(workers=1)).results


def recommended(results: Results, quantity: str, unit: str, channel: str = "G1") -> Row:
    (row,) = (
        one
        for one in results.rows
        if (one.quantity, one.measured.unit, one.channel) == (quantity, unit, channel) and "recommended" in one.flags
    )
    return row


def codes(results: Results) -> set[str]:
    return {finding.code for finding in results.findings}


def p_value(row: Row, truth: float) -> float:
    assert row.measured.std_error
    pull = abs(row.measured.value - truth) / row.measured.std_error
    law = stats.norm if row.measured.dof is None else stats.t(row.measured.dof)
    return float(2.0 * law.sf(pull))


def test_dark_signal_is_never_taken_for_black_level_nor_its_shot_noise_for_read_noise(tmp_path: Path) -> None:
    truth = Truth(**SMALL, biases=0)
    results = measured(tmp_path / "study", truth, dark_exposures_s=(4.0,))
    assert {"one-dark-exposure", "read-noise-mixed", "no-dark-frames"} <= codes(results)
    black = recommended(results, "black_level", "DN")
    assert "offset-not-identified" in black.flags
    assert p_value(black, truth.black) > 1e-4
    assert "mixed" in recommended(results, "read_noise", "DN").flags


def test_without_bias_frames_both_are_extrapolated_to_no_exposure(tmp_path: Path) -> None:
    truth = Truth(**SMALL, biases=0)
    results = measured(tmp_path / "study", truth, dark_exposures_s=(0.5, 1.0, 2.0, 3.0, 4.0))
    for channel in ("R", "G1", "G2", "B"):
        assert p_value(recommended(results, "black_level", "DN", channel), truth.black) > 1e-4
        assert p_value(recommended(results, "read_noise", "DN", channel), truth.read_noise_dn(100)) > 1e-4


def test_saturated_darks_are_left_out_by_name(tmp_path: Path) -> None:
    truth = Truth(**SMALL, dark_current=3000.0)
    results = measured(tmp_path / "study", truth, dark_exposures_s=(0.5, 1.0, 2.0, 4.0, 8.0))
    (finding,) = (one for one in results.findings if one.code == "dark-saturated")
    assert "dark 4 s, dark 8 s" in finding.message
    assert p_value(recommended(results, "dark_current", "DN/s"), 3000.0 * truth.system_gain) > 1e-4


def test_darks_clipped_at_black_give_neither_level_nor_dark_current(tmp_path: Path) -> None:
    truth = Truth(**SMALL, black=0, dsnu=0.0)
    results = measured(tmp_path / "study", truth)
    assert "black-clipped" in codes(results)
    assert "offset-not-identified" in recommended(results, "black_level", "DN").flags
    assert not [row for row in results.rows if row.quantity == "dark_current"]
    noise = recommended(results, "read_noise", "DN")
    assert noise.method == "censored-likelihood"
    assert p_value(noise, truth.read_noise_dn(100)) > 1e-4
    assert p_value(recommended(results, "system_gain", "DN/e-"), truth.system_gain) > 1e-4


def test_noise_below_the_converter_step_is_bounded_not_guessed(tmp_path: Path) -> None:
    quiet = {"read_noise_pre": 0.2, "read_noise_post": 0.05, "row_noise": 0.0, "dsnu": 0.1, "system_gain": 0.1}
    truth = Truth(**SMALL, **quiet)
    results = measured(tmp_path / "study", truth)
    noise = recommended(results, "read_noise", "DN")
    assert "quantization-limited" in noise.flags
    assert noise.measured.ci95 is not None
    low, high = noise.measured.ci95
    assert low <= truth.read_noise_dn(100) <= high
    for row in (recommended(results, "black_level", "DN"), recommended(results, "dark_current", "DN/s")):
        assert "quantization-limited" in row.flags
    assert p_value(recommended(results, "dark_current", "DN/s"), truth.dark_current * truth.system_gain) > 1e-4


@pytest.mark.parametrize("level", [150.0, 250.0])
def test_a_level_given_by_the_user_is_used_everywhere_and_contradicted(tmp_path: Path, level: float) -> None:
    truth = Truth(**SMALL)
    write_study(tmp_path / "study", truth, seed=41)
    options = Options(workers=1)
    given = replace(options, selection=replace(options.selection, black_level=(level,)))
    results = measure(tmp_path / "study", options=given).results
    for channel in ("R", "G1", "G2", "B", "all"):
        row = recommended(results, "black_level", "DN", channel)
        assert row.measured.value == level
        assert "user" in row.flags
    assert "black-levels-disagree" in codes(results)
