"""index and --dry-run: what would be read and measured."""

import json
import subprocess
from collections.abc import Callable
from pathlib import Path

import pytest

Run = Callable[..., "subprocess.CompletedProcess[str]"]
Shared = Callable[[str], Path]


def test_a_dry_run_shows_series_and_writes_nothing(run: Run, study: Path) -> None:
    before = sorted(study.rglob("*"))
    done = run("characterize", study, "--dry-run")
    assert (done.returncode, done.stderr) == (0, "")
    assert "48 x 32, mono, 12 bit, black level 10 DN (sidecar)" in done.stdout
    assert "8 frames in 4 series" in done.stdout
    assert sorted(study.rglob("*")) == before


def test_a_dry_run_as_json(run: Run, study: Path) -> None:
    (study / "dark" / "bad.dng").write_text("no raw file", encoding="utf-8")
    done = run("characterize", study, "--dry-run", "--json", "--only", "dark", "--exposure", "2ms", "--iso", "")
    document = json.loads(done.stdout)
    assert done.returncode == 1
    assert document["series"] == [
        {
            "kind": "dark",
            "iso": None,
            "exposure_s": 0.002,
            "temperature_c": 20.0,
            "photons": None,
            "files": ["dark/exp2000us_0.tiff", "dark/exp2000us_1.tiff"],
        }
    ]
    assert [one["name"] for one in document["excluded"]] == ["dark/bad.dng"]
    assert [one["severity"] for one in document["findings"]] == ["error"]


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (["--cfa", "RGBG"], "RGGB, GRBG, GBRG, BGGR, mono"),
        (["--only", "flats"], "flat, dark, bias, chart, scene"),
        (["--crop", "1,2,3"], "x,y,width,height"),
        (["--crop", "0,0,0,5"], "x,y,width,height"),
        (["--black", "dark"], "--black dark"),
        (["--crop", "0,0,1,1"], "--crop 0,0,1,1: give x,y,width,height"),
        (["--black", "1,2"], "four"),
        (["--black", "-1"], "--black -1: give a level from 0 to 65535 DN"),
        (["--black", "65536"], "--black 65536: give a level from 0 to 65535 DN"),
        (["--black", "inf"], "--black inf"),
        (["--white", "inf"], "--white inf: give a level from 1 to 65535 DN"),
        (["--white", "nan"], "--white nan: give a level from 1 to 65535 DN"),
        (["--white", "1e300"], "--white 1e+300: give a level from 1 to 65535 DN"),
        (["--white", "0.5"], "--white 0.5: give a level from 1 to 65535 DN"),
        (["--exposure", "soon"], "--exposure soon"),
        (["--exposure", "-1ms"], "--exposure"),
        (["--iso", "0"], "--iso 0"),
        (["--iso", "nan"], "--iso nan"),
        (["--camera", "nobody"], "pixel-4a"),
        (["--exposure", "1h"], "--exposure 1h"),
        (["--iso", "100"], "ISO unknown"),
        (["--only", "bias"], "dark, flat"),
    ],
)
def test_options_that_are_not_allowed(run: Run, study: Path, options: list[str], words: str) -> None:
    done = run("characterize", study, "--dry-run", *options)
    assert (done.returncode, done.stdout) == (2, "")
    assert words in done.stderr
    assert "Traceback" not in done.stderr


@pytest.mark.parametrize("content", ["empty", "jpeg", "missing"])
def test_nothing_to_measure_is_status_2_and_one_sentence(run: Run, tmp_path: Path, content: str) -> None:
    folder = tmp_path / "folder"
    if content != "missing":
        (folder / "flat").mkdir(parents=True)
    if content == "jpeg":
        (folder / "flat" / "a.jpg").write_bytes(b"\xff\xd8\xff")
    done = run("characterize", folder, "-o", tmp_path / "out")
    assert done.returncode == 2
    assert done.stderr.startswith("fullwell: ")
    assert done.stderr.count("\n") == 1
    assert not (tmp_path / "out").exists()


def test_verbose_adds_the_traceback(run: Run, tmp_path: Path) -> None:
    assert "Traceback" in run("characterize", tmp_path / "none", "--dry-run", "--verbose").stderr


def test_results_need_a_folder(run: Run, study: Path) -> None:
    done = run("characterize", study)
    assert done.returncode == 2
    assert "-o OUT" in done.stderr


def test_index_writes_what_characterize_reads(run: Run, study: Path) -> None:
    def plan(path: Path) -> dict[str, object]:
        document = json.loads(run("characterize", path, "--dry-run", "--json").stdout)
        del document["camera"]
        return document

    before = plan(study)
    done = run("index", study)
    assert (done.returncode, done.stderr) == (0, "")
    assert str(study / "study.toml") in done.stdout
    assert plan(study) == before
    assert plan(study / "study.toml") == before


def test_index_overwrites_only_when_told(run: Run, study: Path) -> None:
    (study / "study.toml").write_text("mine", encoding="utf-8")
    done = run("index", study)
    assert done.returncode == 2
    assert "--force" in done.stderr
    assert (study / "study.toml").read_text(encoding="utf-8") == "mine"
    assert run("index", study, "--force", "--quiet").returncode == 0
    assert "[[series]]" in (study / "study.toml").read_text(encoding="utf-8")
    assert not list(study.glob(".*"))


def test_index_needs_a_folder_to_read_and_one_to_write_into(run: Run, study: Path, tmp_path: Path) -> None:
    assert run("index", tmp_path / "none").returncode == 2
    assert run("index", study, "-o", tmp_path / "none" / "study.toml").returncode == 2
    assert run("index", study, "-o", tmp_path).returncode == 2


def test_index_tells_of_errors_by_its_status(run: Run, study: Path) -> None:
    (study / "flat" / "bad.dng").write_text("no raw file", encoding="utf-8")
    done = run("index", study)
    assert done.returncode == 1
    assert "flat/bad.dng" in done.stdout
    assert "# flat/bad.dng" in (study / "study.toml").read_text(encoding="utf-8")


def test_imx541_is_indexed_alike_through_folder_and_manifest(run: Run, shared_data: Shared, tmp_path: Path) -> None:
    folder = shared_data("imx541")
    manifest = tmp_path / "study.toml"
    assert run("index", folder, "-o", manifest, "-q").returncode == 0
    plans = [json.loads(run("characterize", path, "--dry-run", "--json").stdout) for path in (folder, manifest)]
    for plan in plans:
        for series in plan["series"]:
            series["files"] = [Path(name).name for name in series["files"]]
        del plan["findings"], plan["camera"]
    assert plans[0] == plans[1]
    assert len(plans[0]["series"]) == 11
