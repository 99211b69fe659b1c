"""Compiled loops over maps of pixels give the same bits as their readable twins."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fullwell.kernels import pixel_maps, pixel_maps_reference


@pytest.mark.parametrize("dtype", [np.uint32, np.float32])
@settings(deadline=None, max_examples=40)
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
