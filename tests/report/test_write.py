"""The results folder appears whole or not at all, and never in the place of somebody else's files."""

import json
import os
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import pytest

from fullwell.errors import UsageError
from fullwell.figures.results import Results
from fullwell.files import replaced_folder
from fullwell.report import html, tables
from fullwell.report.write import check_target, write_files

SMALL = Results(study={"name": "a"}, rows=(), findings=(), curves=())
FILES = ["report.html", "results.csv", "results.json", "results.parquet"]


def names(folder):
    return sorted(path.name for path in folder.iterdir())


def write_results(results, out):
    """Do what every verb does."""
    check_target(out)
    with replaced_folder(out) as fresh:
        write_files(results, fresh)


def test_a_missing_folder_is_made_with_its_parents(tmp_path):
    out = tmp_path / "deep" / "er" / "out"
    write_results(SMALL, out)
    assert names(out) == FILES
    assert names(out.parent) == ["out"]


def test_an_empty_folder_is_filled(tmp_path):
    out = tmp_path / "out"
    out.mkdir()
    write_results(SMALL, out)
    assert names(out) == FILES


def test_our_own_results_are_replaced_with_all_that_stood_there(tmp_path):
    out = tmp_path / "out"
    write_results(SMALL, out)
    (out / "maps").mkdir()
    (out / "maps" / "stale.npz").write_bytes(b"old map")
    (out / ".DS_Store").write_bytes(b"left by a desktop")
    write_results(replace(SMALL, study={"name": "b"}), out)
    assert names(out) == FILES
    assert json.loads((out / "results.json").read_text())["study"] == {"name": "b"}
    assert names(tmp_path) == ["out"]


@pytest.mark.parametrize(
    ("name", "content"),
    [
        ("thesis.tex", "years of work"),
        ("results.json", '{"schema": "somebody-elses/1"}'),
        ("results.json", '["fullwell-results/1"]'),
        ("results.json", "not JSON"),
    ],
)
def test_a_folder_of_somebody_else_is_refused_and_untouched(tmp_path, name, content):
    out = tmp_path / "out"
    out.mkdir()
    (out / name).write_text(content)
    for act in (lambda: check_target(out), lambda: write_results(SMALL, out)):
        with pytest.raises(UsageError, match="name a new or empty folder"):
            act()
    assert (out / name).read_text() == content
    assert names(tmp_path) == ["out"]


@pytest.mark.parametrize("name", ["notes.txt", "results.xlsx", "my maps"])
def test_a_users_file_beside_our_results_is_not_lost(tmp_path, name):
    out = tmp_path / "out"
    write_results(SMALL, out)
    (out / name).write_text("years of work")
    for act in (lambda: check_target(out), lambda: write_results(SMALL, out)):
        with pytest.raises(UsageError, match=f"holds {name}; move"):
            act()
    assert names(out) == sorted([*FILES, name])
    assert names(tmp_path) == ["out"]


def test_a_file_in_the_place_of_the_folder_is_refused(tmp_path):
    out = tmp_path / "out"
    out.write_text("a file")
    with pytest.raises(UsageError, match="is a file"):
        check_target(out)


def test_a_file_in_the_place_of_a_parent_is_refused(tmp_path):
    (tmp_path / "file").write_text("a file")
    with pytest.raises(UsageError, match=r"cannot be written: .*file is a file"):
        check_target(tmp_path / "file" / "out")


def test_checking_a_target_makes_nothing(tmp_path):
    check_target(tmp_path / "a" / "b")
    assert names(tmp_path) == []


def test_what_cannot_be_replaced_is_said_before_the_work(tmp_path, monkeypatch):
    """The system would refuse it afterwards; a protected folder only when another already stood in its place."""
    out = tmp_path / "out"
    write_results(SMALL, out)
    with monkeypatch.context() as protected:
        protected.setattr(os, "access", lambda path, _mode: Path(path) != out)
        with pytest.raises(UsageError, match=f"no permission to write in {out}"):
            check_target(out)
        with pytest.raises(PermissionError), replaced_folder(out):
            pytest.fail("the work began")
    monkeypatch.setattr(os.path, "ismount", lambda path: Path(path) == out)
    with pytest.raises(UsageError, match="disk is mounted"):
        check_target(out)
    with pytest.raises(OSError, match="busy"), replaced_folder(out):
        pytest.fail("the work began")
    assert names(out) == FILES


@pytest.mark.parametrize("failure", [KeyboardInterrupt, OSError])
@pytest.mark.parametrize(("module", "moment"), [(tables, "rows_csv"), (tables, "write_parquet"), (html, "report_html")])
def test_a_failure_at_any_moment_leaves_what_was_there(tmp_path, monkeypatch, failure, module, moment):
    out = tmp_path / "out"
    write_results(SMALL, out)
    before = (out / "results.json").read_bytes()

    def fail(*_arguments, **_options):
        raise failure

    monkeypatch.setattr(module, moment, fail)
    for target in (out, tmp_path / "new"):
        with pytest.raises(failure):
            write_results(replace(SMALL, study={"name": "b"}), target)
    assert names(tmp_path) == ["out"]
    assert names(out) == FILES
    assert (out / "results.json").read_bytes() == before


def test_the_tables_are_the_same_bytes_twice(tmp_path, results):
    few = replace(results, rows=results.rows[:50], curves=())
    for name in ("a", "b"):
        write_results(few, tmp_path / name)
    for file in ("results.json", "results.csv", "results.parquet", "report.html"):
        assert (tmp_path / "a" / file).read_bytes() == (tmp_path / "b" / file).read_bytes()


def test_nothing_that_draws_loads_with_the_measurement():
    heavy = ("fullwell.report.drawing", "typst", "pydantic", "jinja2", "pyarrow", "scipy.optimize", "scipy.ndimage")
    code = f"import sys, fullwell.workflow.characterize; print([name for name in {heavy!r} if name in sys.modules])"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout == "[]\n"
