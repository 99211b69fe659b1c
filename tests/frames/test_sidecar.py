"""What JSON sidecars say."""

import json
from pathlib import Path

import pytest

from fullwell.errors import UnreadableFileError
from fullwell.frames.sidecar import SidecarFacts, read_sidecar, sidecar_of


def facts_of(folder: Path, document: object) -> SidecarFacts:
    path = folder / "frame.json"
    path.write_text(json.dumps(document), encoding="utf-8")
    return read_sidecar(path)


def test_selected_settings_come_before_the_top_level_and_that_before_any_depth(tmp_path: Path) -> None:
    document = {
        "deep": {"ExposureTime": 1.0, "DeviceTemperature": 1.0, "PixelFormat": "Mono8"},
        "ExposureTime": 2.0,
        "DeviceTemperature": 2.0,
        "selected_settings": {"ExposureTime": 3.0},
    }
    facts = facts_of(tmp_path, document)
    assert (facts.exposure_s, facts.temperature_c, facts.bit_depth) == (3e-6, 2.0, 8)


def test_a_name_that_occurs_with_two_values_tells_nothing(tmp_path: Path) -> None:
    assert facts_of(tmp_path, {"a": {"ExposureTime": 1.0}, "b": [{"ExposureTime": 2.0}]}).exposure_s is None
    assert facts_of(tmp_path, {"a": {"ExposureTime": 2.0}, "b": [{"ExposureTime": 2.0}]}).exposure_s == 2e-6


@pytest.mark.parametrize(
    ("text", "cfa", "bits"),
    [
        ("Mono12", "mono", 12),
        ("Mono12p", "mono", 12),
        ("BayerRG12", "RGGB", 12),
        ("BayerGR10Packed", "GRBG", 10),
        ("BayerGB8", "GBRG", 8),
        ("BayerBG16", "BGGR", 16),
        ("RGB8", None, None),
        (12, None, None),
    ],
)
def test_pixel_formats(tmp_path: Path, text: object, cfa: str | None, bits: int | None) -> None:
    facts = facts_of(tmp_path, {"PixelFormat": text})
    assert (facts.cfa, facts.bit_depth) == (cfa, bits)


@pytest.mark.parametrize("value", [0.0, -1.0, True, "soon", None, [1.0]])
def test_what_is_no_exposure(tmp_path: Path, value: object) -> None:
    assert facts_of(tmp_path, {"ExposureTime": value}).exposure_s is None


@pytest.mark.parametrize("content", [b"{", b"[1]", b"\xff\xfe\x00", b"[" * 100_000])
def test_a_damaged_sidecar_is_named_as_such(tmp_path: Path, content: bytes) -> None:
    path = tmp_path / "frame.json"
    path.write_bytes(content)
    with pytest.raises(UnreadableFileError) as caught:
        read_sidecar(path)
    assert caught.value.code == "sidecar-unreadable"


def test_a_sidecar_has_its_frames_stem(tmp_path: Path) -> None:
    (tmp_path / "a.b.json").write_text("{}", encoding="utf-8")
    assert sidecar_of(tmp_path / "a.b.tiff") == tmp_path / "a.b.json"
    assert sidecar_of(tmp_path / "a.tiff") is None
