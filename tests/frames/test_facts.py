"""Facts about a camera that the files contradict."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from fullwell.findings import Finding, Severity
from fullwell.frames.cameras import camera_named
from fullwell.frames.selection import Selection
from fullwell.frames.series import Camera
from fullwell.frames.study import load_study
from fullwell.raw.write import write_dng

MakeFrame = Callable[..., Path]


def findings(folder: Path, selection: Selection, code: str) -> list[Finding]:
    return [one for one in load_study(folder, selection).findings if one.code == code]


def make_frames(folder: Path, *, make: str, model: str) -> None:
    (folder / "flat").mkdir()
    for n in range(2):
        write_dng(
            folder / f"flat/{n}.dng",
            np.full((8, 12), 100 + n, dtype=np.uint16),
            cfa="RGGB",
            black_level=(64.0,) * 4,
            white_level=1023,
            exposure_s=0.01,
            make=make,
            model=model,
        )


@pytest.mark.parametrize(
    ("make", "model", "differs"),
    [
        ("Google", "Pixel 4a", False),
        ("Google", "Google Pixel 4a", False),
        ("Google", "pixel-4A", False),
        ("Google", "Pixel 4a (5G)", True),
        ("Canon", "EOS 5D", True),
    ],
)
def test_a_built_in_camera_is_compared_with_the_files(
    tmp_path: Path,
    make: str,
    model: str,
    differs: bool,  # noqa: FBT001 - pytest hands its parameters by name
) -> None:
    make_frames(tmp_path, make=make, model=model)
    found = findings(tmp_path, Selection(camera=camera_named("pixel-4a")), "camera-differs")
    assert len(found) == differs
    for one in found:
        assert one.severity is Severity.WARNING
        assert "Pixel 4a," in one.message
        assert f"{make} {model}." in one.message
        assert one.files == ("flat/0.dng", "flat/1.dng")
    assert not findings(tmp_path, Selection(camera=Camera(name="Mine")), "camera-differs")


@pytest.mark.parametrize(
    ("serials", "differ"), [(("A1", "A1"), False), (("A1", None), False), ((None, None), False), (("A1", "B2"), True)]
)
def test_bodies_of_one_model_are_different_cameras(
    tmp_path: Path,
    make_dng: MakeFrame,
    serials: tuple[str | None, str | None],
    differ: bool,  # noqa: FBT001 - pytest hands its parameters by name
) -> None:
    for number, serial in enumerate(serials):
        make_dng(tmp_path / f"dark/{number}.dng", serial=serial)
    found = findings(tmp_path, Selection(), "cameras-differ")
    assert len(found) == differ
    assert all("A1" in one.message and "B2" in one.message for one in found)


def test_files_without_a_model_are_not_compared(tmp_path: Path, make_tiff: MakeFrame) -> None:
    make_tiff(tmp_path / "flat/exp1ms.tif")
    assert not findings(tmp_path, Selection(cfa="RGGB", camera=camera_named("pixel-4a")), "camera-differs")


@pytest.mark.parametrize(("bit_depth", "warned"), [(8, True), (9, True), (10, False), (None, False)])
def test_a_white_level_above_the_stated_bit_depth_is_named(
    tmp_path: Path,
    make_dng: MakeFrame,
    bit_depth: int | None,
    warned: bool,  # noqa: FBT001 - pytest hands its parameters by name
) -> None:
    make_dng(tmp_path / "flat/a.dng", white=1023)
    found = findings(tmp_path, Selection(camera=Camera(bit_depth=bit_depth)), "white-level-above-bit-depth")
    assert len(found) == warned
    for one in found:
        assert one.severity is Severity.WARNING
        assert "1023 DN (metadata)" in one.message
        assert f"bit depth {bit_depth}." in one.message
