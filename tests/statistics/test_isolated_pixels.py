"""Pixels that stand alone: planted ones are found, noise and light are not."""

import numpy as np
import pytest

from fullwell.statistics.isolated_pixels import isolated_pixels


@pytest.mark.parametrize("cell", [1, 2])
@pytest.mark.parametrize("spread", [0.3, 1.0, 5.0, 50.0])
def test_normal_noise_leaves_next_to_none(cell: int, spread: float) -> None:
    rng = np.random.default_rng(1)
    frame = np.round(rng.normal(1000.0, spread, (1000, 1500))).astype(np.uint16)
    found = isolated_pixels(frame, cell=cell)
    # fewer than 1e-6 of 1.5 million: more than seven would happen once in 4000 runs
    assert len(found.above) + len(found.below) <= 7


def test_planted_pixels_are_found_and_only_they() -> None:
    rng = np.random.default_rng(2)
    frame = np.round(rng.normal(1000.0, 8.0, (400, 600))).astype(np.uint16)
    rows, columns = np.meshgrid(np.arange(7, 390, 12), np.arange(9, 590, 13), indexing="ij")
    hot = (rows + columns) % 2 == 0
    frame[rows, columns] = np.where(hot, 1200, 700)
    found = isolated_pixels(frame, cell=2)
    assert {tuple(place) for place in found.above.tolist()} == set(
        zip(rows[hot].tolist(), columns[hot].tolist(), strict=True)
    )
    assert {tuple(place) for place in found.below.tolist()} == set(
        zip(rows[~hot].tolist(), columns[~hot].tolist(), strict=True)
    )


def test_spots_of_light_are_no_defects() -> None:
    rng = np.random.default_rng(3)
    y, x = np.mgrid[:400, :600]
    light = np.full((400, 600), 200.0)
    for _ in range(60):
        at_y, at_x = rng.uniform(5, 395), rng.uniform(5, 595)
        light += 4000.0 * np.exp(-((y - at_y) ** 2 + (x - at_x) ** 2) / (2.0 * 0.8**2))
    found = isolated_pixels(rng.poisson(light).astype(np.uint16), cell=2)
    assert len(found.above) + len(found.below) <= 2
