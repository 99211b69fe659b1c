import csv
import io
import json

import pytest

from fullwell.figures.results import Results, Row
from fullwell.report.document import results_json
from fullwell.units import Measured


def written(folder, value):
    """Write the results document of a study of one file, with a figure."""
    row = Row(
        quantity="black_level",
        channel="mono",
        method="fused",
        measured=Measured.student(value, 0.01, 5.0, "DN"),
        iso=100.0,
        flags=("recommended",),
        source="METHOD 2.4",
    )
    study = {"files": [{"path": "a.tif", "xxh3_128": "00ff"}], "series": []}
    folder.mkdir()
    text = results_json(Results(study=study, rows=(row,), findings=(), curves=()))
    (folder / "results.json").write_text(text, encoding="utf-8")
    return folder


@pytest.fixture
def results(tmp_path):
    """Return two results of the same frames."""
    return written(tmp_path / "first", 10.0), written(tmp_path / "second", 10.5)


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
