"""The sums of the cosine-fourth law are those of its derivatives."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from fullwell.kernels.cosine_sums import cosine_sums
from fullwell.model.shading import CosineSurface, Plane


@given(st.integers(1, 12), st.integers(1, 12), st.integers(0, 2**32 - 1))
def test_the_sums_are_those_of_the_derivatives(rows: int, columns: int, seed: int) -> None:
    rng = np.random.default_rng(seed)
    plane = Plane(rows=301, columns=402)
    row, column = np.sort(rng.uniform(0.0, 300.0, rows)), np.sort(rng.uniform(0.0, 401.0, columns))
    parameters = np.array([500.0, *rng.uniform(-0.2, 0.2, 2), rng.uniform(0.0, 1.0)])
    law = CosineSurface(plane=plane)
    signal = law.value(row[:, None], column, parameters) + rng.normal(size=(rows, columns))
    weight = rng.uniform(0.0, 2.0, (rows, columns)) * rng.integers(0, 2, (rows, columns))
    slopes = law.jacobian(row[:, None], column, parameters) / np.array([[1.0], [-1000.0], [-1000.0], [-1000.0]])
    residual = (signal - law.value(row[:, None], column, parameters)).ravel()

    y, x = plane.centred(row, column)
    chi_square, *rest = cosine_sums(y, x, signal, weight, tuple(parameters.tolist()))
    gradient, information = np.array(rest[:4]), np.zeros((4, 4))
    information[np.triu_indices(4)] = information.T[np.triu_indices(4)] = rest[4:]

    weighted = slopes * weight.ravel()
    sizes = np.abs(weighted) @ np.abs(slopes.T), np.abs(weighted) @ np.abs(residual)
    assert (np.abs(information - weighted @ slopes.T) <= 1e-12 * sizes[0]).all()
    # residuals near 1 of signals near 500 are known to 1e-13
    assert (np.abs(gradient - weighted @ residual) <= 1e-12 * sizes[1] + 1e-12 * np.abs(weighted).sum(axis=1)).all()
    np.testing.assert_allclose(chi_square, weight.ravel() @ residual**2, rtol=1e-11, atol=1e-12)
