"""Camera facts."""

from pathlib import Path

import pytest

from fullwell.errors import UsageError
from fullwell.frames.cameras import camera_named, combined
from fullwell.frames.series import Camera


def test_the_studys_camera_is_built_in() -> None:
    camera = camera_named("pixel-4a")
    facts = (camera.voltage_swing_v, camera.pixel_pitch_um, camera.focal_length_mm, camera.base_iso)
    assert facts == (0.45907, 1.4, 4.38, 55.0)


def test_a_file_with_a_camera_table(tmp_path: Path) -> None:
    path = tmp_path / "camera.toml"
    path.write_text('seed = 1\n[camera]\nname = "Mine"\nblack_level = [1, 2, 3, 4]\n', encoding="utf-8")
    assert camera_named(path) == Camera(name="Mine", black_level=(1.0, 2.0, 3.0, 4.0))


def test_an_unknown_name_lists_the_known(tmp_path: Path) -> None:
    with pytest.raises(UsageError, match="pixel-4a"):
        camera_named(tmp_path / "none.toml")


def test_the_first_cameras_facts_outrank_the_seconds() -> None:
    both = combined(Camera(name="a", white_level=0.0), Camera(name="b", white_level=5.0, bit_depth=12))
    assert both == Camera(name="a", white_level=0.0, bit_depth=12)
