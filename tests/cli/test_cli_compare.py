import csv
import io
import json

import pytest

from fullwell.figures.results import Results, Row
from fullwell.report.document import results_json
from fullwell.units import Measured
from fullwell.workflow.simulation.simulate import SCHEMA as TRUTH_SCHEMA


def figure(quantity, method, value, exposure_s=None):
    """Return a recommended figure in DN at ISO 100."""
    return Row(
        quantity=quantity,
        channel="mono",
        method=method,
        measured=Measured.student(value, 0.01, 5.0, "DN"),
        iso=100.0,
        exposure_s=exposure_s,
        flags=("recommended",),
        source="METHOD 2.4",
    )


def written(folder, *rows):
    """Write the results document of a study of one file."""
    study = {"files": [{"path": "a.tif", "xxh3_128": "00ff"}], "series": []}
    folder.mkdir()
    text = results_json(Results(study=study, rows=rows, findings=(), curves=()))
    (folder / "results.json").write_text(text, encoding="utf-8")
    return folder


@pytest.fixture
def results(tmp_path):
    """Return two results of the same frames."""
    levels = {"first": 10.0, "second": 10.5}
    return tuple(written(tmp_path / name, figure("black_level", "fused", level)) for name, level in levels.items())


def test_two_results_are_set_side_by_side(run, results, tmp_path):
    out = tmp_path / "compared"
    done = run("compare", *results, "-o", out)
    assert done.returncode == 0, done.stderr
    assert "black level" in done.stdout
    document = json.loads((out / "compare.json").read_text(encoding="utf-8"))
    assert document["schema"] == "fullwell-compare/1"
    assert [side["name"] for side in document["sides"]] == ["first", "second"]
    assert [finding["code"] for finding in document["findings"]] == ["frames-shared"]
    lines = list(csv.DictReader(io.StringIO((out / "compare.csv").read_text(encoding="utf-8"))))
    assert len(lines) == len(document["matches"]) == 1
    assert float(lines[0]["difference_B"]) == 0.5
    assert lines[0]["p_value_B"] == ""
    page = (out / "report.html").read_text(encoding="utf-8")
    assert "Figures by the same method" in page
    assert "http://" not in page.replace("http://www.w3.org", "")
    assert run("compare", *results, "-o", out, "--quiet").returncode == 0


def test_figures_of_several_exposures_stand_beside_the_truth_of_their_own(run, tmp_path):
    dark_s = (0.5, 2.0)
    told = [
        ("dsnu", None),
        *(("dsnu", time_s) for time_s in dark_s),
        *(("total_dark_noise", time_s) for time_s in dark_s),
    ]
    truth = [
        {
            "quantity": quantity,
            "channel": "mono",
            "unit": "DN",
            "iso": 100.0,
            "value": 3.0 + (time_s or 0.0),
            "snr_threshold": None,
            "exposure_s": time_s,
        }
        for quantity, time_s in told
    ]
    simulated = tmp_path / "truth.json"
    document = {"schema": TRUTH_SCHEMA, "truth": truth, "camera": {"name": "one"}}
    simulated.write_text(json.dumps(document), encoding="utf-8")
    noises = [figure("total_dark_noise", "noise-model", 3.0 + time_s, time_s) for time_s in dark_s]
    measured = written(tmp_path / "measured", figure("dsnu", "dark-stack", 3.0), *noises)
    out = tmp_path / "compared"
    done = run("compare", simulated, measured, "-o", out)
    assert done.stdout.count("dsnu") == 1
    assert done.stdout.count("total dark noise") == 2
    assert "500 ms" in done.stdout
    page = (out / "report.html").read_text(encoding="utf-8")
    assert [text in page for text in ("mono, ISO 100<", "mono, ISO 100, 500 ms<", "mono, ISO 100, 2 s<")] == [True] * 3


def test_json_alone_on_stdout(run, results):
    done = run("compare", *results, "--json")
    assert json.loads(done.stdout)["schema"] == "fullwell-compare/1"


def test_what_cannot_be_compared_is_refused_with_a_sentence(run, results, tmp_path):
    alone = run("compare", results[0])
    assert alone.returncode == 2
    assert "Name two results" in alone.stderr
    missing = run("compare", results[0], tmp_path / "nowhere")
    assert missing.returncode == 2
    assert "does not exist" in missing.stderr
    other = tmp_path / "other"
    other.mkdir()
    (other / "notes.txt").write_text("mine", encoding="utf-8")
    kept = run("compare", *results, "-o", other)
    assert kept.returncode == 2
    assert "left untouched" in kept.stderr
    assert [path.name for path in other.iterdir()] == ["notes.txt"]
    truth = tmp_path / "truth.json"
    truth.write_text("{}", encoding="utf-8")
    assert "no truth document" in run("compare", results[0], truth).stderr
