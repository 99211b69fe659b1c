"""inspect: the fields of RESULTS 5."""

import json
import subprocess
from collections.abc import Callable
from pathlib import Path

import pytest

Run = Callable[..., "subprocess.CompletedProcess[str]"]
Shared = Callable[[str], Path]

FIELDS = {
    *("path", "format", "make", "model", "width", "height", "raw_width", "raw_height", "active_area", "cfa"),
    *("bit_depth", "effective_bits", "black_level", "white_level", "iso", "exposure_s", "compression"),
    *("masked_areas", "noise_profile", "findings"),
}


def test_a_dng_with_margins_and_without_exposure(run: Run, shared_data: Shared) -> None:
    path = shared_data("colorchecker-550d/colorchart.dng")
    done = run("inspect", path, "--json")
    (document,) = json.loads(done.stdout)
    assert (done.returncode, done.stderr) == (0, "")
    assert set(document) >= FIELDS
    assert document["path"] == str(path)
    assert (document["width"], document["height"], document["cfa"]) == (1734, 1156, "RGGB")
    assert (document["raw_width"], document["raw_height"]) == (1888, 1182)
    assert document["active_area"] == [26, 152, 1182, 1886]
    assert (document["bit_depth"], document["effective_bits"]) == (14, 14)
    assert (document["black_level"], document["white_level"]) == ([2056.0] * 4, 15000.0)
    assert document["iso"] is None
    assert document["exposure_s"] is None
    human = run("inspect", path).stdout
    assert "BlackLevel" in human
    assert "1734 x 1156" in human


def test_a_lossy_dng_is_described_and_refused(run: Run, shared_data: Shared) -> None:
    done = run("inspect", shared_data("lossy-6d/canon_eos_6d.dng"), "--json")
    (document,) = json.loads(done.stdout)
    assert done.returncode == 1
    assert document["noise_profile"][0] == pytest.approx([3.31406676e-5, 9.2130e-8], rel=1e-4)
    assert {"lossy-compression", "linear-dng"} <= {one["code"] for one in document["findings"]}


def test_several_files_are_a_table(run: Run, study: Path) -> None:
    frames = sorted(study.rglob("*.tiff"))
    done = run("inspect", *frames)
    assert done.returncode == 0
    assert done.stdout.count("48 x 32") == len(frames)


def test_a_file_that_cannot_be_read(run: Run, study: Path) -> None:
    (study / "text.dng").write_text("no raw file", encoding="utf-8")
    good = next(study.rglob("*.tiff"))
    done = run("inspect", study / "text.dng", good, "--json")
    assert done.returncode == 1
    assert [one["format"] for one in json.loads(done.stdout)] == [None, "tiff"]
    alone = run("inspect", study / "text.dng", "--json")
    assert (alone.returncode, alone.stdout) == (2, "")
    assert "not a raw file" in alone.stderr


@pytest.mark.parametrize("path", ["none.dng", "."])
def test_what_is_no_file(run: Run, path: str) -> None:
    assert run("inspect", path).returncode == 2


def test_a_closed_pipe_is_no_drama(program: list[str], study: Path) -> None:
    frames = sorted(map(str, study.rglob("*.tiff"))) * 200
    command = [*program, "inspect", "--json", *frames]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE) as process:
        assert process.stdout is not None
        assert process.stderr is not None
        process.stdout.close()
        assert process.stderr.read() == b""
    assert process.returncode == 0
