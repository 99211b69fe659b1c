"""Empty sums of frames, and what makes two of them the same."""

import numpy as np

from fullwell.kernels import moments_reference
from fullwell.kernels.stack import Band, FrameSums, SeriesSums, Stack


def empty_sums(stack: Stack, band: Band, height: int) -> tuple[SeriesSums, FrameSums]:
    step, sites, frames = band.cell * band.tile, band.cell**2, stack.starts.size
    shape, grid = (height, stack.width), (sites, -(-height // step), -(-stack.width // step))
    series = SeriesSums(
        np.zeros(shape, np.uint32),
        np.zeros(shape, np.uint32),
        np.zeros(shape, np.uint64),
        np.zeros(height, np.int64),
        np.full(grid, 65535, np.uint16),
        np.zeros(grid, np.uint16),
        np.zeros(grid, np.int64),
        np.zeros(grid, np.int64),
    )
    sums = FrameSums(
        np.zeros((frames, height, band.cell), np.uint64),
        np.zeros((frames, band.cell, stack.width), np.uint64),
        np.zeros((frames, *grid), np.uint64),
        np.zeros((frames, band.cell, stack.width), np.uint32),
    )
    return series, sums


def assert_same(one: tuple[SeriesSums, FrameSums], other: tuple[SeriesSums, FrameSums]) -> None:
    """Compare sums, whatever width their squares are kept in."""
    (mine, of_mine), (its, of_its) = one, other
    np.testing.assert_array_equal(moments_reference.squares_of(mine), moments_reference.squares_of(its))
    for name in set(SeriesSums._fields) - {"squares", "wide", "held"}:
        np.testing.assert_array_equal(getattr(mine, name), getattr(its, name), err_msg=name)
    for a, b in zip(of_mine, of_its, strict=True):
        np.testing.assert_array_equal(a, b)
