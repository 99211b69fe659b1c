"""A crop moves what is visible: pixels, CFA and levels stay together."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
import tifffile
from PIL import Image

from fullwell.errors import UsageError
from fullwell.frames.selection import Selection
from fullwell.frames.study import load_study
from fullwell.raw.open import decode

MakeFrame = Callable[..., Path]


@pytest.mark.parametrize(
    ("region", "cfa", "black"),
    [
        ((2, 4, 6, 4), "RGGB", (1.0, 2.0, 3.0, 4.0)),
        ((1, 0, 5, 4), "GRBG", (2.0, 1.0, 4.0, 3.0)),
        ((0, 1, 6, 5), "GBRG", (3.0, 4.0, 1.0, 2.0)),
        ((3, 3, 4, 5), "BGGR", (4.0, 3.0, 2.0, 1.0)),
    ],
)
def test_the_cropped_pixels_are_those_of_the_region(
    tmp_path: Path, region: tuple[int, int, int, int], cfa: str, black: tuple[float, ...]
) -> None:
    mosaic = np.arange(8 * 12, dtype=np.uint16).reshape(8, 12)
    path = tmp_path / "flat" / "exp1ms.tif"
    path.parent.mkdir()
    tifffile.imwrite(path, mosaic, photometric="minisblack", metadata=None)
    study = load_study(tmp_path, Selection(cfa="RGGB", black_level=(1.0, 2.0, 3.0, 4.0), crop=region))
    header = study.series[0].frames[0].header
    x, y, width, height = region
    assert (study.width, study.height) == (header.width, header.height) == (width, height)
    assert study.cfa == header.cfa == cfa
    assert study.black_level is not None
    assert study.black_level.values == black
    np.testing.assert_array_equal(decode(header, path.read_bytes()), mosaic[y : y + height, x : x + width])


def test_a_region_reaches_at_most_to_the_edge(tmp_path: Path, make_dng: MakeFrame) -> None:
    make_dng(tmp_path / "flat/a.dng", height=8, width=12)
    assert load_study(tmp_path, Selection(crop=(2, 2, 10, 6))).width == 10
    with pytest.raises(UsageError, match="12 x 8"):
        load_study(tmp_path, Selection(crop=(2, 2, 11, 6)))


@pytest.mark.parametrize(("cfa", "least"), [("RGGB", 4), ("mono", 2)])
def test_a_region_holds_at_least_two_cells_each_way(tmp_path: Path, make_tiff: MakeFrame, cfa: str, least: int) -> None:
    make_tiff(tmp_path / "flat/exp1ms.tif", height=8, width=12)
    assert load_study(tmp_path, Selection(cfa=cfa, crop=(0, 0, least, least))).width == least
    for region in ((0, 0, least - 1, least), (0, 0, least, least - 1)):
        with pytest.raises(UsageError, match=f"--crop .* at least {least} pixels"):
            load_study(tmp_path, Selection(cfa=cfa, crop=region))


def test_png_frames_are_cropped_too(tmp_path: Path) -> None:
    (tmp_path / "flat").mkdir()
    mosaic = np.arange(96, dtype=np.uint16).reshape(8, 12)
    path = tmp_path / "flat/exp1ms.png"
    Image.fromarray(mosaic).save(path)
    study = load_study(tmp_path, Selection(cfa="mono", crop=(3, 1, 4, 5)))
    np.testing.assert_array_equal(decode(study.series[0].frames[0].header, path.read_bytes()), mosaic[1:6, 3:7])
