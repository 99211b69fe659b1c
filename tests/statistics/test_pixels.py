"""Maps per pixel are the linear combinations and the lines they claim to be."""

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from fullwell.statistics.pixels import combine, line_coefficients

SINGLE = float(np.finfo(np.float32).eps)


@pytest.mark.parametrize("workers", [1, 2, 7])
@pytest.mark.parametrize("count", [1, 2, 4, 5, 8, 11])
@pytest.mark.parametrize("cell", [1, 2])
def test_combinations_equal_numpy(workers: int, count: int, cell: int) -> None:
    rng = np.random.default_rng(count)
    height, width = 75, 51
    sums = [rng.integers(0, 5000, (height, width), dtype=np.uint32) for _ in range(count)]
    coefficients = rng.normal(size=(3, count, cell**2))
    site = cell * (np.arange(height)[:, np.newaxis] % cell) + np.arange(width) % cell
    expected = sum(coefficients[:, k, site] * one for k, one in enumerate(sums))
    # One rounding to float32; float64 in between adds nothing that shows, but where terms of up to 5000 cancel.
    slack = 5000 * 4 * count * float(np.finfo(np.float64).eps)
    found = combine(sums, coefficients, cell=cell, workers=workers)
    np.testing.assert_allclose(found, expected, rtol=SINGLE, atol=slack)


def test_views_and_read_only_maps_are_taken() -> None:
    mosaic = np.random.default_rng(1).integers(0, 900, (40, 60), dtype=np.uint32)
    mosaic.flags.writeable = False
    found = combine([mosaic[::2, 1::2], mosaic[1::2, ::2]], np.array([[[1.0], [-1.0]]]), cell=1)
    expected = mosaic[::2, 1::2].astype(np.float32) - mosaic[1::2, ::2].astype(np.float32)
    np.testing.assert_array_equal(found[0], expected)


def test_threads_do_not_matter_to_the_bit() -> None:
    rng = np.random.default_rng(2)
    sums = [rng.integers(0, 2**32, (131, 64), dtype=np.uint32) for _ in range(7)]
    coefficients = rng.normal(size=(2, 7, 4))
    one, three = (combine(sums, coefficients, cell=2, workers=workers) for workers in (1, 3))
    np.testing.assert_array_equal(one, three)


@settings(max_examples=50)
@given(
    st.lists(st.floats(1e-4, 10.0), min_size=2, max_size=8, unique=True),
    st.floats(-1e4, 1e4),
    st.floats(-100.0, 100.0),
    st.data(),
)
def test_lines_are_recovered(times: list[float], slope: float, intercept: float, data: st.DataObject) -> None:
    t = np.array(times)
    assume(np.ptp(t) >= 1e-3)
    weights = data.draw(st.lists(st.floats(0.1, 10.0), min_size=t.size, max_size=t.size))
    found = line_coefficients(times, weights) @ (intercept + slope * t)
    # Errors of the sums are carried by at most the range's inverse, and back over the times.
    scale = (abs(intercept) + abs(slope) * t.max()) * float(np.finfo(np.float64).eps) * 100 * t.size
    reach = np.max(weights) / np.min(weights) / np.ptp(t)
    least = np.finfo(np.float64).tiny  # below it numbers lose digits
    assert abs(found[0] - slope) <= scale * reach + least
    assert abs(found[1] - intercept) <= scale * (1 + reach * t.max()) + least


@pytest.mark.parametrize("weighted", [False, True])
def test_lines_of_maps_are_least_squares(*, weighted: bool) -> None:
    rng = np.random.default_rng(3)
    times = np.array([0.002, 0.004, 0.006, 0.01, 0.012])
    means = (60.0 + 40_000.0 * times[:, np.newaxis, np.newaxis] + rng.normal(0, 3, (5, 30, 44))).astype(np.float32)
    weights = (1.0 / (4.0 + 20.0 * times / times.max())).tolist() if weighted else None
    root = np.ones(5) if weights is None else np.sqrt(weights)
    design = root[:, np.newaxis] * np.stack((times, np.ones(5)), axis=1)
    solution, *_rest = np.linalg.lstsq(
        design, root[:, np.newaxis] * means.reshape(5, -1).astype(np.float64), rcond=None
    )
    coefficients = line_coefficients(times.tolist(), weights)[:, :, np.newaxis]
    slope, intercept = combine(list(means), coefficients, cell=1, workers=2)
    np.testing.assert_allclose(slope.ravel(), solution[0], rtol=SINGLE)
    np.testing.assert_allclose(intercept.ravel(), solution[1], rtol=SINGLE)


def test_weights_count_by_the_variance_of_the_line() -> None:
    times, variances = np.array([1.0, 2.0, 3.0, 5.0]), np.array([1.0, 2.0, 4.0, 9.0])
    design = np.stack((times, np.ones(4)), axis=1)
    covariance = np.linalg.inv(design.T @ np.diag(1 / variances) @ design)
    coefficients = line_coefficients(times.tolist(), (1 / variances).tolist())
    np.testing.assert_allclose(coefficients @ np.diag(variances) @ coefficients.T, covariance, rtol=1e-12)


def test_a_line_needs_two_times() -> None:
    with pytest.raises(ValueError, match="two exposure times"):
        line_coefficients([0.01, 0.01, 0.01])


def test_coefficients_must_fit_the_maps() -> None:
    with pytest.raises(ValueError, match="coefficients of shape"):
        combine([np.ones((4, 4), np.uint32)], np.ones((1, 2, 1)), cell=1)
