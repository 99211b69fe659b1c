"""Dark frames at several temperatures: each has a dark current of its own, and together they tell its doubling."""

from pathlib import Path

import pytest

from fullwell.frames.selection import Selection
from fullwell.report.datasheet.build import build_datasheet
from fullwell.report.emva_xml import reference_files
from fullwell.testing import simulated_study, simulation
from fullwell.workflow.characterize import measure
from fullwell.workflow.options import Options

DOUBLING_C = 7.0
RATE = 50.0  # [e-/s] at 20 degrees


@pytest.fixture(scope="module")
def results(tmp_path_factory: pytest.TempPathFactory):
    """Measure flats at 20 degrees and darks at 20, 30 and 40."""
    flats = [
        {"kind": "flat", "exposure_s": 0.01 * k, "electrons": 1000.0 * k, "frames": 3, "temperature_c": 20.0}
        for k in range(1, 6)
    ]
    darks = [
        {"kind": "dark", "exposure_s": exposure_s, "frames": 4, "temperature_c": celsius}
        for celsius in (20.0, 30.0, 40.0)
        for exposure_s in (0.1, 0.2, 0.4, 0.8)
    ]
    config = simulation(
        camera={
            "width": 128,
            "height": 96,
            "dark_current": RATE,
            "dark_current_doubling_c": DOUBLING_C,
            "dark_current_reference_c": 20.0,
            "prnu": 0.0,
            "dsnu": 0.0,
        },
        study={"series": [{"iso": 100, **one} for one in (*flats, *darks)]},
    )
    study = simulated_study(tmp_path_factory.mktemp("temperatures") / "study", config)
    return measure(study.root, options=Options(selection=Selection(), workers=1)).results


def test_each_temperature_has_its_dark_current(results) -> None:
    found = {
        (row.temperature_c, row.channel): row.measured
        for row in results.rows
        if (row.quantity, row.method, row.measured.unit) == ("dark_current", "mean-slope", "e-/s")
    }
    assert {celsius for celsius, _ in found} == {20.0, 30.0, 40.0}
    for (celsius, channel), measured in found.items():
        true = RATE * 2.0 ** ((celsius - 20.0) / DOUBLING_C)
        low, high = measured.ci95
        assert abs(measured.value - true) < 2.5 * (high - low) / 2.0, (celsius, channel)


def test_together_they_tell_the_doubling(results) -> None:
    rows = [row for row in results.rows if row.quantity == "dark_current_doubling"]
    assert {row.channel for row in rows} == {"R", "G1", "G2", "B", "all"}
    for row in rows:
        assert abs(row.measured.value - DOUBLING_C) < 4.0 * row.measured.std_error
        assert row.measured.std_error < 0.02 * DOUBLING_C
        assert row.temperature_c is None


def test_other_figures_are_those_of_the_temperature_that_has_the_flats(results) -> None:
    elsewhere = {row.quantity for row in results.rows if row.temperature_c in {30.0, 40.0}}
    assert elsewhere == {"dark_current"}
    assert {finding.code for finding in results.findings} >= {"several-temperatures"}
    curve = next(one for one in results.curves if one.name == "dark_current_temperature")
    assert curve.column("temperature_c") == (20.0, 30.0, 40.0) * 4


def test_each_temperature_is_an_operation_point_of_emva_1288(tmp_path: Path) -> None:
    series = [
        {"iso": 100, "kind": kind, "exposure_s": 0.01 * k, "frames": 2, "temperature_c": celsius, **light}
        for celsius in (20.0, 40.0)
        for k in range(1, 10)
        for kind, light in (("flat", {"electrons": 800.0 * k}), ("dark", {}))
    ]
    config = simulation(camera={"width": 96, "height": 96, "cfa": "mono"}, study={"series": series})
    study = simulated_study(tmp_path / "study", config)
    options = Options(selection=Selection(), workers=1, profiles=("emva1288-4.0-linear",))
    results = measure(study.root, options=options).results
    profile = [row for row in results.rows if row.method == "emva1288-4.0-linear"]
    gains = {row.temperature_c: row.measured for row in profile if row.quantity == "system_gain"}
    assert sorted(gains) == [20.0, 40.0]
    for measured in gains.values():
        assert abs(measured.value - config.sensor.system_gain) < 4.0 * measured.std_error
    sheet = build_datasheet(results)
    assert [point.title for point in sheet.points] == ["ISO 100, 20 °C", "ISO 100, 40 °C"]
    graphs = [graph for point in sheet.points for graph in point.graphs if graph.name == "stability"]
    assert [len(graph.tables) for graph in graphs] == [1, 1]
    assert [name for name, _ in reference_files(results)] == ["mono_iso100_20c.xml", "mono_iso100_40c.xml"]
