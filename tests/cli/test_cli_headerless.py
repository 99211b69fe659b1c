"""Headerless files through the command line: option, presets, manifest, sidecars, guesses."""

import json
import subprocess
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

Run = Callable[..., "subprocess.CompletedProcess[str]"]

FORMAT = "width=96,height=64,bits=12,container=packed-mipi,cfa=RGGB"


@pytest.fixture(autouse=True)
def presets_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    path = tmp_path / "presets.toml"
    monkeypatch.setenv("FULLWELL_PRESETS", str(path))
    return path


def mipi_12(mosaic: np.ndarray) -> bytes:
    pairs = mosaic.reshape(-1, 2).astype(np.uint16)
    low = (pairs[:, 0] & 15) | (pairs[:, 1] & 15) << 4
    return np.stack([pairs[:, 0] >> 4, pairs[:, 1] >> 4, low], axis=1).astype(np.uint8).tobytes()


@pytest.fixture
def study(tmp_path: Path) -> Path:
    folder = tmp_path / "study"
    rng = np.random.default_rng(11)
    for kind, exposures_us in (("flat", (1000, 2000, 4000)), ("dark", (1000, 4000))):
        (folder / kind).mkdir(parents=True)
        for exposure_us in exposures_us:
            for n in range(3):
                light = 0.2 * exposure_us if kind == "flat" else 0.0
                mosaic = np.round(64.0 + rng.poisson(light, (64, 96)) + rng.normal(0.0, 3.0, (64, 96)))
                (folder / kind / f"exp{exposure_us}us_{n}.bin").write_bytes(mipi_12(mosaic.clip(0, 4095)))
    return folder


def measured(out: Path) -> list[object]:
    return json.loads((out / "results.json").read_text(encoding="utf-8"))["results"]


def test_option_preset_and_manifest_measure_the_same(run: Run, study: Path, tmp_path: Path) -> None:
    unknown = run("characterize", study, "-o", tmp_path / "none")
    assert unknown.returncode == 2
    option = run("characterize", study, "--headerless", FORMAT, "-o", tmp_path / "option", "--quiet")
    assert option.returncode == 0, option.stderr
    assert run("index", study, "--headerless", FORMAT, "-o", study / "study.toml").returncode == 0
    assert "[headerless]" in (study / "study.toml").read_text(encoding="utf-8")
    manifest = run("characterize", study / "study.toml", "-o", tmp_path / "manifest", "--quiet")
    assert manifest.returncode == 0, manifest.stderr
    (study / "study.toml").unlink()
    assert run("presets", "save", "bin", FORMAT).returncode == 0
    preset = run("characterize", study, "-o", tmp_path / "preset", "--quiet")
    assert preset.returncode == 0, preset.stderr
    rows = measured(tmp_path / "option")
    assert rows
    assert measured(tmp_path / "preset") == rows == measured(tmp_path / "manifest")


def test_a_wrong_geometry_ends_a_study_with_what_fits(run: Run, study: Path, tmp_path: Path) -> None:
    done = run("characterize", study, "--headerless", FORMAT.replace("64", "60"), "-o", tmp_path / "out")
    assert done.returncode == 2
    assert "What fits: height=64" in done.stderr
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize(
    ("key", "words"),
    [("width = 96", "height is missing"), ("width = 96\nheight = 64\nbit = 3", "bit is not known; the keys are")],
)
def test_a_manifest_says_what_is_wrong_with_its_geometry(run: Run, study: Path, key: str, words: str) -> None:
    manifest = f'[headerless]\n{key}\n[[series]]\nkind = "flat"\nfiles = ["flat/*.bin"]\n'
    (study / "study.toml").write_text(manifest, encoding="utf-8")
    done = run("characterize", study, "--dry-run")
    assert done.returncode == 2
    assert f"study.toml: [headerless]: {words}" in done.stderr


def test_a_sidecar_says_how_a_frame_is_stored(run: Run, tmp_path: Path) -> None:
    mosaic = np.random.default_rng(3).integers(0, 1024, (6, 8), dtype=np.uint16)
    path = tmp_path / "a.raw"
    path.write_bytes(mosaic.astype("<u2").tobytes())
    facts = {"PixelFormat": "BayerGB10", "Width": 8, "Height": 6}
    (tmp_path / "a.json").write_text(json.dumps(facts), encoding="utf-8")
    (document,) = json.loads(run("inspect", path, "--json").stdout)
    assert (document["format"], document["width"], document["height"]) == ("headerless", 8, 6)
    assert (document["cfa"], document["bit_depth"]) == ("GBRG", 10)
    assert run("presets", "save", "raw", "--headerless", "width=6,height=8,bits=12").returncode == 0
    (tmp_path / "a.json").write_text(json.dumps(facts | {"Width": 9}), encoding="utf-8")
    (document,) = json.loads(run("inspect", path, "--json").stdout)
    assert (document["width"], document["bit_depth"]) == (6, 12)


def test_guesses_are_listed_and_drawn(run: Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    y, x = np.mgrid[:240, :320]
    light = 900.0 + 600.0 * np.sin(x / 17.0) * np.cos(y / 11.0) + 300.0 * (np.hypot(x - 150, y - 90) < 60)
    path = tmp_path / "frame.bin"
    path.write_bytes(np.random.default_rng(1).poisson(light).astype("<u2").tobytes())
    done = run("inspect", path, "--guess")
    assert (done.returncode, done.stderr) == (0, "")
    assert "  1. --headerless width=320,height=240,bits=12,container=16,byte_order=little" in done.stdout
    with Image.open(tmp_path / "frame_guesses.png") as sheet:
        assert sheet.format == "PNG"
        assert min(sheet.size) > 200
        assert len(sheet.getcolors(256) or ()) > 50
    (document,) = json.loads(run("inspect", path, "--guess", "--json", "--sheet", tmp_path / "s.png").stdout)
    assert (tmp_path / "s.png").exists()
    best = document["guesses"][0]
    assert (best["rank"], best["width"], best["height"], best["container"]) == (1, 320, 240, "16")
    assert best["reason"]
    told = run("inspect", path, "--headerless", best["headerless"])
    assert "320 x 240" in told.stdout
    refused = run("inspect", path, "--headerless", "width=320,height=250,bits=12", "--json")
    assert refused.returncode == 2
    assert "The content speaks for width=320,height=240" in refused.stderr
    doubted = json.loads(run("inspect", path, "--headerless", "width=240,height=320,bits=12", "--json").stdout)
    assert "geometry-doubtful" in {finding["code"] for finding in doubted[0]["findings"]}


def test_nothing_is_guessed_of_a_file_that_tells(run: Run, tmp_path: Path) -> None:
    np.save(tmp_path / "a.npy", np.ones((8, 8), np.uint16))
    done = run("inspect", tmp_path / "a.npy", "--guess")
    assert done.returncode == 2
    assert "there is nothing to guess" in done.stderr


def test_presets_are_kept_shown_and_forgotten(run: Run, presets_file: Path) -> None:
    assert "No presets" in run("presets", "list").stdout
    assert run("presets", "save", ".raw", FORMAT, "--quiet").stdout == ""
    assert run("presets", "list").stdout == f"raw  {FORMAT}\n"
    assert json.loads(run("presets", "list", "--json").stdout)["raw"]["width"] == 96
    assert run("presets", "remove", "raw").returncode == 0
    assert presets_file.exists()
    assert "No presets" in run("presets", "list").stdout


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["save", "nef", FORMAT], "nef is the extension of a standard format"),
        (["save", "bin"], "Say once how files with the extension bin are stored"),
        (["save", "bin", "width=3"], "FORMAT: height is missing"),
        (["remove", "bin"], "There is no preset for bin; there are no presets"),
    ],
)
def test_bad_use_of_presets(run: Run, presets_file: Path, arguments: list[str], words: str) -> None:
    done = run("presets", *arguments)
    assert (done.returncode, done.stdout) == (2, "")
    assert words in done.stderr
    assert not presets_file.exists()
