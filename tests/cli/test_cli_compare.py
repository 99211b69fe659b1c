import csv
import io
import json

import pytest


@pytest.fixture
def results(run, study, tmp_path):
    """Return two results: of one study, and of the same at another crop."""
    folders = tmp_path / "first", tmp_path / "second"
    assert run("characterize", study, "-o", folders[0], "--quiet").returncode == 0
    assert run("characterize", study, "-o", folders[1], "--crop", "0,0,32,32", "--quiet").returncode == 0
    return folders


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
    assert len(lines) == len(document["matches"]) > 20
    one = next(line for line in lines if (line["quantity"], line["method"]) == ("black_level", "fused"))
    assert float(one["difference_B"]) == float(one["value_B"]) - float(one["value_A"])
    assert one["p_value_B"] == ""
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
