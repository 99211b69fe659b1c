"""Compiled loops over maps of pixels give the same bits as their readable twins."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fullwell.kernels import pixel_bins, pixel_bins_reference, pixel_maps, pixel_maps_reference
from fullwell.kernels.pixel_bins import BinSums, Limits


@pytest.mark.parametrize("dtype", [np.uint32, np.float32])
@settings(max_examples=40)
@given(st.data())
def test_combinations_equal_their_twins(dtype: type, data: st.DataObject) -> None:
    rows, width = data.draw(st.integers(1, 9)), data.draw(st.integers(1, 40))
    cell, made, top = data.draw(st.sampled_from((1, 2))), data.draw(st.integers(1, 3)), data.draw(st.integers(0, 5))
    rng = np.random.default_rng(data.draw(st.integers(0, 2**32 - 1)))
    maps = tuple(rng.integers(0, 2**32, (rows, width)).astype(dtype) for _ in range(4))
    coefficients = rng.normal(size=(made, 4, cell, cell))
    fast = rng.normal(size=(made, rows + data.draw(st.integers(0, 2)), width))
    slow = fast.copy()
    a, b, c, d = maps
    pixel_maps.add_four((a, b, c, d), top, coefficients, fast)
    pixel_maps_reference.add_four((a, b, c, d), top, coefficients, slow)
    pixel_maps.add_one(a, top, coefficients[:, 0], fast)
    pixel_maps_reference.add_one(a, top, coefficients[:, 0], slow)
    np.testing.assert_array_equal(fast, slow)


@settings(max_examples=60)
@given(st.data())
def test_bins_equal_their_twin(data: st.DataObject) -> None:
    size = data.draw(st.integers(1, 9))
    shape = data.draw(st.integers(1, 30)), data.draw(st.integers(1, 30))
    rng = np.random.default_rng(data.draw(st.integers(0, 2**32 - 1)))
    low, high = data.draw(st.sampled_from(((0, 2**32), (0, 3), (500, 540), (2**32 - 20, 2**32))))
    mosaic = rng.integers(low, high, (2 * shape[0], 2 * shape[1]), dtype=np.uint32)
    hot = rng.random(mosaic.shape) < data.draw(st.sampled_from((0.0, 0.05, 0.4)))
    mosaic[hot] = rng.integers(0, 2**32, int(hot.sum()), dtype=np.uint32)
    plane = mosaic[1::2, ::2]
    limits = Limits(
        data.draw(st.sampled_from((0.0, 3.0, 40.0))), data.draw(st.sampled_from((np.inf, 2.0, 530.0, 2.0**32 - 10)))
    )
    grid = -(-shape[0] // size), -(-shape[1] // size)
    fast, slow = (
        BinSums(*(np.zeros(grid, dtype) for dtype in (np.int64, np.uint64, np.int64, np.bool_))) for _ in range(2)
    )
    pixel_bins.bin_rows(plane, size, (0, grid[0]), limits, fast)
    pixel_bins_reference.bin_rows(plane, size, (0, grid[0]), limits, slow)
    for name, mine, its in zip(fast._fields, fast, slow, strict=True):
        np.testing.assert_array_equal(mine, its, err_msg=name)
