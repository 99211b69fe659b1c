"""The demo lays truth beside measurement, honestly: pulls behave as normal numbers whatever the degrees of freedom."""

import json
from pathlib import Path

import numpy as np
import pytest
from scipy import stats

from fullwell import glossary
from fullwell.errors import UsageError
from fullwell.figures.calibration import pull
from fullwell.figures.results import Row
from fullwell.simulate.truth import TrueValue
from fullwell.testing import simulation
from fullwell.units import Measured
from fullwell.workflow import demo
from fullwell.workflow.loop.comparison import compared

STUDY = {
    "isos": [100, 400],
    "flat": {"exposures_s": [0.001, 0.002, 0.003, 0.004], "electrons": [800.0, 1600.0, 2400.0, 3200.0], "frames": 4},
    "dark": {"exposures_s": [0.5, 1.0, 2.0, 4.0], "frames": 4},
    "bias": {"exposures_s": [0.0001], "frames": 6},
    "scene": {"subjects": ["patches"]},
    "folders": {"flat": "PRNU_DSNU", "dark": "DarkCurrentRate", "bias": "ReadNoise", "scene": "Interesting"},
}


def test_pulls_with_few_degrees_of_freedom_are_put_on_the_normal_scale() -> None:
    t = np.random.default_rng(5).standard_t(3, size=2000)
    pulls = [pull(Measured.student(value, 1.0, 3, "DN"), 0.0) for value in t.tolist()]
    assert stats.kstest(pulls, "norm").pvalue > 1e-3
    assert pull(Measured.student(1e9, 1.0, 50, "DN"), 0.0) is not None
    assert np.isfinite(pull(Measured.student(-1e9, 1.0, 50, "DN"), 0.0) or np.nan)
    assert pull(Measured.normal(7.0, 2.0, "DN"), 4.0) == 1.5
    assert pull(Measured.exact(7.0, "DN"), 4.0) is None


def test_rows_meet_the_truth_of_their_own_unit_and_iso() -> None:
    measured = Measured.normal(2.2, 0.1, "DN")
    row = Row(quantity="read_noise", channel="R", method="m", measured=measured, iso=100.0, flags=("recommended",))
    elsewhere = Row(quantity="read_noise", channel="R", method="m", measured=measured, iso=200.0)
    tile = Row(quantity="read_noise", channel="R", method="m", measured=measured, iso=100.0, region="tile:0,0")
    bound = Row(quantity="read_noise", channel="R", method="b", measured=measured, iso=100.0, flags=("lower-bound",))
    truth = [
        TrueValue(quantity="read_noise", channel="R", unit="DN", iso=100.0, value=2.0),
        TrueValue(quantity="read_noise", channel="R", unit="e-", iso=100.0, value=4.0),
    ]
    found = compared([row, elsewhere, tile, bound], truth)
    assert [(one.row.method, one.truth, one.recommended) for one in found] == [("m", 2.0, True), ("b", 2.0, False)]
    assert found[0].pull == pytest.approx(2.0)
    assert found[1].pull is None


def test_a_small_demo_finds_the_truth_through_the_front_door(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    small = simulation(seed=11, study=STUDY, output={"compression": "lossless-jpeg"})
    monkeypatch.setattr(demo, "pixel_study", lambda: small)
    out = tmp_path / "out"
    outcome = demo.run_demo(out, full=True, workers=2)
    assert outcome.frames == 2 * (16 + 16 + 6) + 1
    assert len(list((out / "study").rglob("*.dng"))) == outcome.frames
    judged = [one for one in outcome.rows if one.recommended and one.pull is not None]
    assert {one.row.quantity for one in judged} >= {"black_level", "read_noise", "dark_current", "system_gain", "k_fpn"}
    # Two-sided p of a normal number above 1e-4, for each of about 250 figures of this one seed.
    assert [one for one in judged if abs(one.pull or 0.0) > 3.9] == []
    document = json.loads((out / "demo.json").read_text(encoding="utf-8"))
    assert document["schema"] == "fullwell-demo/1"
    assert len(document["rows"]) == len(outcome.rows)
    for name in ("results.json", "report.html"):
        assert ".partial" not in (out / name).read_text(encoding="utf-8")
    assert [path.name for path in tmp_path.iterdir()] == ["out"]
    cited = {part.split()[0] for row in outcome.results.rows for part in row.source.split(";")}
    assert cited <= {reference.key for reference in glossary.BIBLIOGRAPHY}
    assert all(glossary.method(row.method) and glossary.quantity(row.quantity) for row in outcome.results.rows)
    assert document_run(out)["study"] == str(out / "study")
    _fails_without_a_trace(out, monkeypatch)


def document_run(out: Path) -> dict[str, str]:
    return json.loads((out / "results.json").read_text(encoding="utf-8"))["run"]


def _fails_without_a_trace(out: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Stop a second demo at its last step: everything the first one wrote is still there."""
    before = {path: path.stat().st_mtime_ns for path in out.rglob("*")}

    def fail(*_rows: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(demo, "_comparison", fail)
    with pytest.raises(KeyboardInterrupt):
        demo.run_demo(out, full=True, workers=2)
    assert {path: path.stat().st_mtime_ns for path in out.rglob("*")} == before
    assert [path.name for path in out.parent.iterdir()] == ["out"]


def test_a_folder_with_something_else_in_it_is_left_untouched(tmp_path: Path) -> None:
    (tmp_path / "photo.dng").touch()
    with pytest.raises(UsageError, match="left untouched"):
        demo.run_demo(tmp_path, workers=1)
    assert [path.name for path in tmp_path.iterdir()] == ["photo.dng"]
