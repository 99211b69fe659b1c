"""A folder is replaced whole or not at all; what stood there is deleted only when the new one stands in its place."""

import errno
import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from fullwell.files import holds_document, replaced_folder


@pytest.fixture
def out(tmp_path):
    folder = tmp_path / "out"
    folder.mkdir()
    (folder / "former").write_text("years of work")
    return folder


def contents(out):
    return {path.name: path.read_text() for path in out.iterdir()}


def replace(out, *, failure=None):
    with replaced_folder(out) as fresh:
        (fresh / "new").write_text("new")
        if failure:
            raise failure


def test_a_folder_takes_the_place_of_the_former_one(tmp_path, out):
    replace(out)
    replace(tmp_path / "deep" / "er")
    assert contents(out) == contents(tmp_path / "deep" / "er") == {"new": "new"}
    assert sorted(path.name for path in tmp_path.iterdir()) == ["deep", "out"]


@pytest.mark.parametrize("failure", [KeyboardInterrupt, OSError])
def test_a_failure_while_it_is_filled_leaves_what_was_there(tmp_path, out, failure):
    for target in (out, tmp_path / "new"):
        with pytest.raises(failure):
            replace(target, failure=failure)
    assert contents(out) == {"former": "years of work"}
    assert [path.name for path in tmp_path.iterdir()] == ["out"]


def test_a_failure_between_the_two_renames_brings_the_former_back(tmp_path, out, monkeypatch):
    rename = Path.rename

    def interrupted(self, target):
        if self.name == "fresh":
            raise KeyboardInterrupt
        return rename(self, target)

    monkeypatch.setattr(Path, "rename", interrupted)
    with pytest.raises(KeyboardInterrupt):
        replace(out)
    assert contents(out) == {"former": "years of work"}
    assert [path.name for path in tmp_path.iterdir()] == ["out"]


def test_the_former_survives_even_where_it_cannot_be_brought_back(tmp_path, out, monkeypatch):
    rename = Path.rename

    def refused(self, target):
        if Path(target) == out:
            raise OSError("no permission")
        return rename(self, target)

    monkeypatch.setattr(Path, "rename", refused)
    with pytest.raises(OSError, match="no permission"):
        replace(out)
    assert [contents(folder) for folder in tmp_path.iterdir()] == [{"former": "years of work"}]


@pytest.mark.parametrize(
    ("text", "ours"),
    [('{"schema": "a/1"}', True), ('{"schema": "b/1"}', False), ('["a/1"]', False), ("not JSON", False)],
)
def test_a_document_of_ours_is_told_by_its_schema(tmp_path, text, ours):
    (tmp_path / "a.json").write_text(text)
    assert holds_document(tmp_path, "a.json", schema="a/1") is ours
    assert not holds_document(tmp_path / "missing", "a.json", schema="a/1")


KILLED = """
import os, signal, sys
from pathlib import Path
from fullwell.files import replaced_folder
moment, out = sys.argv[1], Path(sys.argv[2])
rename = Path.rename
def killed(self, target):
    if self.name == "fresh":
        os.kill(os.getpid(), signal.SIGKILL)
    return rename(self, target)
Path.rename = killed
with replaced_folder(out) as fresh:
    (fresh / "new").write_text("new")
    if moment == "filling":
        os.kill(os.getpid(), signal.SIGKILL)
"""


def age(tmp_path):
    for left in tmp_path.glob(".out-*.partial"):
        os.utime(left, (1e9, 1e9))


@pytest.mark.skipif(sys.platform == "win32", reason="folders cannot be held there")
@pytest.mark.parametrize("moment", ["filling", "renaming"])
def test_what_a_killed_process_left_is_removed_and_what_stood_there_comes_back(tmp_path, out, moment):
    done = subprocess.run([sys.executable, "-c", KILLED, moment, str(out)], check=False, timeout=60)
    assert done.returncode == -signal.SIGKILL
    assert out.exists() == (moment == "filling")
    age(tmp_path)
    with pytest.raises(KeyboardInterrupt):
        replace(out, failure=KeyboardInterrupt)
    assert contents(out) == {"former": "years of work"}
    assert [path.name for path in tmp_path.iterdir()] == ["out"]


@pytest.mark.skipif(sys.platform == "win32", reason="folders cannot be held there")
def test_what_another_process_is_at_work_on_is_left_alone(tmp_path, out):
    with replaced_folder(out) as fresh:
        age(tmp_path)
        replace(out)
        (fresh / "newer").write_text("newer")
    assert contents(out) == {"newer": "newer"}
    assert [path.name for path in tmp_path.iterdir()] == ["out"]


@pytest.mark.parametrize(("number", "name"), [(errno.ENOSPC, "out"), (errno.EIO, None)])
def test_a_full_disk_is_told_with_what_was_written_to(out, number, name):
    with pytest.raises(OSError, match=os.strerror(number)) as raised, replaced_folder(out):
        raise OSError(number, os.strerror(number))
    assert raised.value.filename == (name and str(out))
    assert contents(out) == {"former": "years of work"}
