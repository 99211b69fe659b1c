"""Regions of the mosaic: inside it, even, and alike at every size."""

from hypothesis import given
from hypothesis import strategies as st

from fullwell.workflow.measure.regions import central_crop, central_tiles

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
