"""Studies that one exposure for every series does not describe: several temperatures, and light that is varied."""

import json
from pathlib import Path

import pytest

from fullwell.figures.results import Results
from fullwell.frames.selection import Selection
from fullwell.glossary import RECOMMENDED
from fullwell.report.document import results_json
from fullwell.simulate.config import SimulationConfig
from fullwell.simulate.plan import plan
from fullwell.simulate.truth import true_values
from fullwell.testing import simulated_study, simulation
from fullwell.workflow.characterize import measure
from fullwell.workflow.loop.comparison import compared
from fullwell.workflow.options import Options
from fullwell.workflow.simulation.camera import camera_from_results

SMALL = {"width": 96, "height": 96, "cfa": "mono"}
LEVELS = (500.0, 1000.0, 2000.0, 3000.0, 4000.0, 9000.0)
"""The last of them saturates, and is on no curve."""


def _measured(study: Path) -> Results:
    return measure(study, options=Options(selection=Selection(), workers=1)).results


def test_several_temperatures_have_their_own_truth_and_are_simulated_again(tmp_path: Path) -> None:
    flats = [
        {"kind": "flat", "iso": 100, "exposure_s": level / 1e6, "electrons": level, "frames": 3, "temperature_c": 20.0}
        for level in LEVELS[:5]
    ]
    darks = [
        {"kind": "dark", "iso": 100, "exposure_s": time_s, "frames": 4, "temperature_c": warm}
        for warm in (20.0, 30.0, 40.0)
        for time_s in (0.5, 1.0, 2.0)
    ]
    camera = {**SMALL, "dark_current": 10.0, "dark_current_doubling_c": 7.0}
    config = simulation(seed=3, camera=camera, study={"series": [*flats, *darks]})
    simulated_study(tmp_path / "study", config)
    results = _measured(tmp_path / "study")
    found = [one for one in compared(results.rows, true_values(config)) if one.recommended]
    current = {
        one.row.temperature_c: one for one in found if one.figure[0] == "dark_current" and one.figure[3] == "e-/s"
    }
    assert {warm: one.truth for warm, one in current.items()} == pytest.approx(
        {20.0: 10.0, 30.0: 10.0 * 2 ** (10 / 7), 40.0: 10.0 * 2 ** (20 / 7)}
    )
    assert [one.truth for one in found if one.row.quantity == "dark_current_doubling"] == [7.0]
    # Two-sided p of a normal number above 1e-5, for each of fewer than 100 figures.
    assert [one for one in found if abs(one.pull or 0.0) > 4.5] == []
    again = camera_from_results(json.loads(results_json(results))).config
    (doubling,) = (row.measured for row in results.rows if row.quantity == "dark_current_doubling")
    assert again.sensor.dark_current_doubling_c == pytest.approx(doubling.value)
    assert _taken(again) == _taken(config)


def _taken(config: SimulationConfig) -> list[tuple[str, float, float | None]]:
    return sorted((one.kind.value, one.exposure.exposure_s, one.exposure.temperature_c or 0.0) for one in plan(config))


def test_light_that_was_varied_at_one_exposure_is_simulated_in_proportion(tmp_path: Path) -> None:
    study = {
        "flat": {"exposures_s": [level / 1e6 for level in LEVELS], "electrons": list(LEVELS), "frames": 3},
        "dark": {"exposures_s": [0.01, 0.5, 1.0], "frames": 3},
    }
    config = simulation(seed=4, camera={**SMALL, "dark_current": 0.0}, study=study)
    frames = simulated_study(tmp_path / "study", config).frames
    lines: list[str] = []
    for dark, time_s in ((True, 0.01), (True, 0.5), (True, 1.0), *((False, level / 1e6) for level in LEVELS)):
        named = [f"{one.name}.dng" for one in frames if one.exposure.exposure_s == time_s]
        lines += ["[[series]]", f'kind = "{"dark" if dark else "flat"}"', "iso = 100"]
        lines += [f"files = {named}"]
        lines += [f"exposure_s = {time_s if dark else 0.01}", *([] if dark else [f"photons = {2e6 * time_s}"])]
    (tmp_path / "study" / "study.toml").write_text("\n".join(lines) + "\n", encoding="utf-8")
    results = _measured(tmp_path / "study" / "study.toml")
    made = camera_from_results(json.loads(results_json(results)))
    flats = {one.exposure.exposure_s: one.exposure.electrons for one in plan(made.config) if one.kind.value == "flat"}
    assert list(flats) == pytest.approx([0.01 * level / LEVELS[-1] for level in LEVELS])
    (system_gain,) = (
        one.measured for one in results.rows if one.quantity == "system_gain" and RECOMMENDED in one.flags
    )
    # Electrons are DN by the system gain; the errors of levels and means are a tenth of its own at most.
    assert list(flats.values()) == pytest.approx(LEVELS, rel=4.0 * (system_gain.std_error or 0.0) / system_gain.value)
    assert any("in proportion to their photons" in said for said in made.said)
