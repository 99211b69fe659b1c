"""convert and the pictures of inspect, as a user runs them."""

import json
import subprocess
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from fullwell.raw.cfa import MONO
from fullwell.raw.image import Levels, RawHeader
from fullwell.raw.open import read_header, read_raw
from fullwell.raw.write import write_dng
from fullwell.workflow.previews import orders_of, preview_of

Run = Callable[..., "subprocess.CompletedProcess[str]"]


@pytest.fixture
def frame(tmp_path: Path) -> Path:
    """Return a DNG of noise over black."""
    path = tmp_path / "frame.dng"
    mosaic = np.random.default_rng(3).normal(64, 6, (96, 128)).round().clip(0).astype(np.uint16)
    write_dng(path, mosaic, cfa="GRBG", black_level=(64,), white_level=1023, bit_depth=10, iso=100, exposure_s=0.01)
    return path


def test_one_file_is_converted_and_told(run: Run, frame: Path) -> None:
    out = frame.with_name("out.tif")
    done = run("convert", frame, "-o", out, "--json")
    (said,) = json.loads(done.stdout)["files"]
    assert (done.returncode, said["out"], said["black_level"]) == (0, str(out), [64.0] * 4)
    np.testing.assert_array_equal(read_raw(out).mosaic, read_raw(frame).mosaic)
    (document,) = json.loads(run("inspect", out, "--json").stdout)
    assert (document["cfa"], document["bit_depth"], document["black_level"]) == ("GRBG", 10, [64.0] * 4)
    assert (document["white_level"], document["iso"], document["exposure_s"]) == (1023.0, 100.0, 0.01)
    again = run("convert", frame, "-o", out)
    assert (again.returncode, again.stdout) == (2, "")
    assert "--overwrite" in again.stderr


def test_a_linearized_dark_is_measured_as_clipped(run: Run, tmp_path: Path) -> None:
    rng = np.random.default_rng(5)
    for n in range(4):
        path = tmp_path / f"study/dark/{n}.dng"
        path.parent.mkdir(parents=True, exist_ok=True)
        mosaic = rng.normal(64, 6, (96, 128)).round().clip(0).astype(np.uint16)
        write_dng(path, mosaic, cfa="GRBG", black_level=(64,), white_level=1023, bit_depth=10, iso=100, exposure_s=0.01)
    done = run("convert", tmp_path / "study", "-o", tmp_path / "linear", "--linearize")
    assert done.returncode == 0
    assert "lay below black" in done.stdout
    measured = run("characterize", tmp_path / "linear", "-o", tmp_path / "out", "--json")
    assert "black-clipped" in {one["code"] for one in json.loads(measured.stdout)["findings"]}


def test_pictures_are_drawn_one_per_file(run: Run, frame: Path, tmp_path: Path) -> None:
    other = tmp_path / "other.dng"
    other.write_bytes(frame.read_bytes())
    done = run("inspect", frame, other, "--preview", tmp_path / "look.png", "--cfa-sheet", tmp_path / "cfa.png")
    assert done.returncode == 0
    for name in ("look-frame.png", "look-other.png", "cfa-frame.png", "cfa-other.png"):
        with Image.open(tmp_path / name) as picture:
            assert picture.width > 1500
    wrong = run("inspect", frame, "--preview", tmp_path / "look.jpg")
    assert (wrong.returncode, wrong.stdout) == (2, "")


@pytest.mark.parametrize(
    ("cfa", "shape", "level"),
    [
        ("GRBG", (2, 2), "none"),
        ("BGGR", (1, 7), "white"),
        ("RGGB", (33, 201), "black"),
        (MONO, (100, 101), "black"),
        (None, (33, 200), "none"),
    ],
)
def test_every_mosaic_can_be_drawn(frame: Path, cfa: str | None, shape: tuple[int, int], level: str) -> None:
    known = read_header(frame)
    fields = {name: getattr(known, name) for name in known.__slots__} | {
        "active_area": known.active_area._replace(bottom=shape[0], right=shape[1]),
        "cfa": cfa,
        "black_level": None if level == "none" else Levels(values=(64.0,) * 4, source="metadata"),
        "white_level": Levels(values=(1023.0,) * 4, source="metadata") if level == "white" else None,
    }
    value = {"none": 0, "black": 64, "white": 1023}[level]
    header, mosaic = RawHeader(**fields), np.full(shape, value, np.uint16)
    assert preview_of(header, mosaic).startswith(b"\x89PNG")
    if min(shape) > 1:
        assert orders_of(header, mosaic).startswith(b"\x89PNG")
