"""The public names are where docs/python.md says, and its examples do what it says."""

import ast
import doctest
import re
from pathlib import Path

import pytest

import fullwell

PAGE = Path(__file__).parents[1] / "docs" / "python.md"


def test_the_examples_of_the_page_are_true(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("COLUMNS", "120")
    page = re.sub(r"^```.*$", "", PAGE.read_text("utf-8"), flags=re.MULTILINE)
    examples = doctest.DocTestParser().get_doctest(page, {}, PAGE.name, str(PAGE), 0)
    assert len(examples.examples) >= PAGE.read_text("utf-8").count(">>> ")
    assert doctest.DocTestRunner().run(examples).failed == 0


def test_every_public_name_is_on_the_page_and_documented() -> None:
    told = set(re.findall(r"`(\w+)[`(]", PAGE.read_text("utf-8")))
    names = set(fullwell.__all__) - {"__version__"}
    assert names <= told
    assert [name for name in names if not getattr(fullwell, name).__doc__] == []
    assert set(dir(fullwell)) >= names


def test_type_checkers_are_told_the_same_names() -> None:
    stub = Path(fullwell.__file__).with_suffix(".pyi").read_text("utf-8")
    told = {
        alias.asname: f"{node.module}"
        for node in ast.parse(stub).body
        if isinstance(node, ast.ImportFrom)
        for alias in node.names
    }
    assert set(told) == set(fullwell.__all__) - {"__version__"}
    assert {name: getattr(fullwell, name).__module__ for name in told} == told


def test_what_is_not_there_is_said() -> None:
    with pytest.raises(AttributeError, match="no attribute 'nothing'"):
        _ = fullwell.nothing
