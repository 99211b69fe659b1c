"""Regions of the mosaic: inside it, even, and alike at every size."""

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fullwell.raw.write import write_dng
from fullwell.workflow.characterize import measure
from fullwell.workflow.measure.regions import central_crop, central_tiles
from fullwell.workflow.options import Options

SIDES = st.integers(min_value=64, max_value=12000)


@given(width=SIDES, height=SIDES)
def test_regions_lie_inside_on_even_pixels(width: int, height: int) -> None:
    crop = central_crop(width=width, height=height)
    assert 0 <= crop.x <= crop.x + crop.width <= width
    assert 0 <= crop.y <= crop.y + crop.height <= height
    for tile in central_tiles(width=width, height=height):
        assert crop.x <= tile.x <= tile.x + tile.width <= crop.x + crop.width
        assert crop.y <= tile.y <= tile.y + tile.height <= crop.y + crop.height
        assert all(number % 2 == 0 for number in (tile.x, tile.y, tile.width, tile.height, crop.x, crop.y))


def test_the_crop_is_in_the_middle_and_its_tiles_do_not_overlap() -> None:
    crop = central_crop(width=4032, height=3024)
    assert (crop.x + crop.width / 2, crop.y + crop.height / 2) == (2015.0, 1512.0)
    tiles = central_tiles(width=4032, height=3024)
    assert len(tiles) == 16
    assert {(tile.width, tile.height) for tile in tiles} == {(64, 64)}
    assert len({(tile.x // 64, tile.y // 64) for tile in tiles}) == 16


@pytest.mark.parametrize("shape", [(65, 97), (25, 25)])
def test_a_corner_tile_of_one_pixel_tells_nothing_and_spoils_nothing(tmp_path: Path, shape: tuple[int, int]) -> None:
    """At 97 by 65 pixels and tiles of 8 the last tile has one pixel: it knows no variance; at 25 it is a region."""
    rng = np.random.default_rng(0)
    for kind, electrons in (("bias", 0.0), ("flat", 400.0), ("flat", 800.0)):
        exposure = 0.0001 if kind == "bias" else electrons / 4000.0
        folder = tmp_path / "study" / kind / "ISO_100"
        folder.mkdir(parents=True, exist_ok=True)
        for number in range(4):
            codes = np.rint(64.0 + rng.normal(electrons, np.sqrt(9.0 + electrons), shape))
            write_dng(
                folder / f"{kind}_exp{round(exposure * 1e6):09d}us_{number}.dng",
                codes.clip(0, 4095).astype(np.uint16),
                cfa="mono",
                black_level=[64],
                white_level=4095,
                iso=100.0,
                exposure_s=exposure,
            )
    results = measure(tmp_path / "study", options=Options(workers=1)).results
    (read_noise,) = (
        row
        for row in results.rows
        if row.quantity == "read_noise" and "recommended" in row.flags and row.measured.unit == "DN"
    )
    assert read_noise.measured.std_error
    assert abs(read_noise.measured.value - 3.0) < 4.0 * read_noise.measured.std_error
