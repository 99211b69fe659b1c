import sys
from pathlib import Path

import numpy as np
import pytest

from fullwell.errors import UnreadableFileError, UsageError
from fullwell.frames.source import RAW_SUFFIXES
from fullwell.raw.headerless_format import parse_format
from fullwell.raw.open import read_header, read_raw
from fullwell.raw.presets import (
    STANDARD_EXTENSIONS,
    extension_from,
    presets_path,
    read_presets,
    remove_preset,
    save_preset,
)

SMALL = parse_format("width=4,height=3,bits=12,offset=2,cfa=BGGR")


@pytest.fixture(autouse=True)
def presets_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    path = tmp_path / "settings" / "presets.toml"
    monkeypatch.setenv("FULLWELL_PRESETS", str(path))
    return path


def test_presets_come_back_until_they_are_removed(presets_file: Path) -> None:
    assert read_presets() == {}
    other = parse_format("width=6,height=3,bits=10,container=packed-mipi")
    assert save_preset(".RAW", SMALL) == presets_file
    save_preset("bin", SMALL)
    save_preset("bin", other)
    assert read_presets() == {"bin": other, "raw": SMALL}
    remove_preset("raw")
    assert read_presets() == {"bin": other}
    with pytest.raises(UsageError, match="no preset for raw; there are presets for bin"):
        remove_preset(".raw")
    assert [path.name for path in presets_file.parent.iterdir()] == ["presets.toml"]


def test_a_file_is_read_by_the_preset_for_its_extension(tmp_path: Path) -> None:
    path = tmp_path / "a.BIN"
    mosaic = np.arange(12, dtype="<u2").reshape(3, 4)
    path.write_bytes(b"hi" + mosaic.tobytes())
    save_preset("bin", SMALL)
    image = read_raw(path)
    np.testing.assert_array_equal(image.mosaic, mosaic)
    assert image.header.cfa == "BGGR"
    assert "the preset for .bin" in image.header.findings[0].message
    stated = parse_format("width=3,height=4,bits=12,trailer=2")
    assert read_header(path, headerless=stated).layout == stated
    (tmp_path / "a.dat").write_bytes(path.read_bytes())
    with pytest.raises(UnreadableFileError, match="not a raw file"):
        read_header(tmp_path / "a.dat")


@pytest.mark.parametrize("extension", ["dng", ".TIF", "png", "NEF", "fits", "npy", "", ".", "a/b", "a.b"])
def test_standard_and_impossible_extensions_are_refused(extension: str) -> None:
    with pytest.raises(UsageError):
        save_preset(extension, SMALL)


def test_every_format_that_is_read_by_its_ending_is_standard() -> None:
    assert {suffix.removeprefix(".") for suffix in RAW_SUFFIXES} - STANDARD_EXTENSIONS == {"raw"}
    assert extension_from("raw") == "raw"


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("[bin\n", "not valid TOML"),
        ("bin = 3\n", "bin is no table"),
        ("[bin]\nwidth = 3\n", r"\[bin\]: height is missing"),
        ("[bin]\nwidth = 3\nheight = 2.5\n", "height=2.5 is not a whole number"),
        ("[dng]\nwidth = 3\nheight = 2\n", "dng is the extension of a standard format"),
    ],
)
def test_a_damaged_file_is_named_and_never_overwritten(presets_file: Path, text: str, words: str) -> None:
    presets_file.parent.mkdir()
    presets_file.write_text(text, encoding="utf-8")
    with pytest.raises(UsageError, match=words):
        save_preset("raw", SMALL)
    assert presets_file.read_text(encoding="utf-8") == text


@pytest.mark.parametrize(
    ("platform", "variable", "below"),
    [
        ("linux", "XDG_CONFIG_HOME", "fullwell"),
        ("win32", "APPDATA", "fullwell"),
        ("darwin", "HOME", "Library/Application Support/fullwell"),
    ],
)
def test_presets_stand_where_the_platform_keeps_settings(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, platform: str, variable: str, below: str
) -> None:
    monkeypatch.delenv("FULLWELL_PRESETS")
    monkeypatch.setattr(sys, "platform", platform)
    monkeypatch.setenv(variable, str(tmp_path))
    assert presets_path() == tmp_path / below / "presets.toml"
