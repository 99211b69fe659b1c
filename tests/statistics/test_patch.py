import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fullwell.statistics.patch import patch_statistics

DEGREES = {1: 0, 3: 1, 6: 2}


def _by_least_squares(values, terms):
    rows, columns = values.shape
    v, u = (axis.ravel() for axis in np.mgrid[0.0:rows, 0.0:columns])
    degree = DEGREES[terms]
    design = np.stack([v**i * u**j for i in range(3) for j in range(3) if i + j <= degree], axis=1)
    solution, _, rank, _ = np.linalg.lstsq(design, values.ravel(), rcond=None)
    dof = values.size - int(rank)
    return dof, float(np.sum((values.ravel() - design @ solution) ** 2)) / dof if dof else np.nan


@given(
    rows=st.integers(1, 12),
    columns=st.integers(1, 12),
    terms=st.sampled_from([1, 3, 6]),
    seed=st.integers(0, 2**32 - 1),
)
@settings(max_examples=150)
def test_variance_is_that_about_the_least_squares_surface(rows, columns, terms, seed):
    values = np.random.default_rng(seed).normal(100.0, 3.0, (rows, columns))
    found = patch_statistics(values, terms=terms)
    dof, variance = _by_least_squares(values, terms)
    assert (found.n, found.dof) == (rows * columns, dof)
    assert found.mean == pytest.approx(values.mean(), rel=1e-12)
    assert found.variance == pytest.approx(variance, rel=1e-9, abs=1e-9, nan_ok=True)


@given(coefficients=st.lists(st.floats(-3.0, 3.0), min_size=6, max_size=6))
def test_a_surface_of_its_own_terms_leaves_nothing_and_changes_nothing(coefficients):
    v, u = np.mgrid[-1.0:1.0:9j, -1.0:1.0:14j]
    surface = sum(c * term for c, term in zip(coefficients, (1.0, u, v, u * u, u * v, v * v), strict=True))
    noise = np.random.default_rng(4).normal(size=v.shape)
    assert patch_statistics(surface + 0.0 * v).variance <= 1e-24
    assert patch_statistics(noise + surface).variance == pytest.approx(patch_statistics(noise).variance, rel=1e-9)


def test_codes_are_read_as_they_come():
    codes = np.random.default_rng(5).integers(60_000, 65_536, (7, 8)).astype(np.uint16)
    assert patch_statistics(codes[:, ::2], terms=1).variance == pytest.approx(codes[:, ::2].var(ddof=1), rel=1e-12)


def test_an_empty_patch_is_refused():
    with pytest.raises(ValueError, match="at least one pixel"):
        patch_statistics(np.empty((0, 3)))
