"""Compiled loops that lay fixed patterns on an array give the same bits as their readable twins."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from fullwell.kernels import fixed_patterns, fixed_patterns_reference


@settings(max_examples=40)
@given(st.integers(1, 9), st.integers(1, 40), st.floats(0.0, 2.0), st.integers(0, 2**32 - 1))
def test_patterns_equal_their_twins(rows: int, width: int, scale: float, seed: int) -> None:
    rng = np.random.default_rng(seed)
    pattern = rng.normal(size=(rows, width)).astype(np.float32)
    of_rows, of_columns = rng.normal(size=rows), rng.normal(size=width)
    fast = rng.normal(size=(rows, width))
    slow = fast.copy()
    fixed_patterns.add_pattern(scale, pattern, of_rows, of_columns, fast)
    fixed_patterns_reference.add_pattern(scale, pattern, of_rows, of_columns, slow)
    np.testing.assert_array_equal(fast, slow)
    fixed_patterns.multiply_by_response(scale, pattern, of_rows, of_columns, fast)
    fixed_patterns_reference.multiply_by_response(scale, pattern, of_rows, of_columns, slow)
    np.testing.assert_array_equal(fast, slow)


def test_no_response_is_negative() -> None:
    out = np.ones((1, 3))
    pattern = np.array([[-3.0, 0.0, 3.0]], dtype=np.float32)
    fixed_patterns.multiply_by_response(0.5, pattern, np.zeros(1), np.zeros(3), out)
    assert out.tolist() == [[0.0, 1.0, 2.5]]
