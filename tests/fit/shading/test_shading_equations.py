"""The surfaces themselves: derivatives, identities, and an independent implementation."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.interpolate import BSpline

from fullwell.model.shading import (
    CosineSurface,
    FixedCosineSurface,
    Plane,
    RadialSurface,
    cubic_splines,
    legendre,
    polynomial_surface,
    spline_surface,
)

PLANE = Plane(rows=301, columns=402)
SURFACES = {
    "polynomial": (polynomial_surface(PLANE, 3), np.linspace(-1.0, 2.0, 10)),
    "spline": (spline_surface(PLANE, (5, 6)), np.linspace(1.0, 2.0, 30)),
    "cosine": (CosineSurface(plane=PLANE), np.array([500.0, 0.03, -0.05, 0.6])),
    "fixed": (FixedCosineSurface(plane=PLANE, focal_length_pixels=320.0), np.array([500.0])),
    "radial": (
        RadialSurface(plane=PLANE, powers=5),
        np.array([500.0, -300.0, 60.0, 20.0, -9.0, 3.0, 0.02, -0.01, 155.0, 190.0]),
    ),
}


@pytest.mark.parametrize("name", SURFACES)
def test_derivatives_are_those_of_the_surface(name):
    surface, parameters = SURFACES[name]
    rng = np.random.default_rng(1)
    row, column = rng.uniform(0.0, 300.0, 40), rng.uniform(0.0, 401.0, 40)
    slopes = surface.jacobian(row, column, parameters)
    assert slopes.shape == (len(surface.parameter_names), 40) == (parameters.size, 40)
    for at, parameter in enumerate(parameters):
        step = 1e-5 * max(abs(parameter), 1.0)
        move = np.zeros(parameters.size)
        move[at] = step
        up, down = (surface.value(row, column, parameters + sign * move) for sign in (1.0, -1.0))
        # the step's square and rounding of values near 500, over the step
        bound = 1e-6 * np.abs(slopes[at]).max() + 500.0 * 4e-16 / step
        np.testing.assert_allclose((up - down) / (2.0 * step), slopes[at], rtol=0.0, atol=bound)


@pytest.mark.parametrize("name", SURFACES)
def test_a_grid_is_its_places_one_by_one(name):
    surface, parameters = SURFACES[name]
    row, column = np.linspace(0.0, 300.0, 7), np.linspace(0.0, 401.0, 9)
    grid = surface.value(row[:, None], column[None, :], parameters)
    single = surface.value(np.repeat(row, 9), np.tile(column, 7), parameters)
    np.testing.assert_allclose(grid.ravel(), single, rtol=1e-13)


@pytest.mark.parametrize("terms", [4, 5, 12])
def test_splines_are_scipys_and_add_up_to_one(terms):
    size = 77
    place = np.linspace(-0.5, size - 0.5 - 1e-9, 200)
    knots = np.arange(-3, terms + 1) * size / (terms - 3)
    oracle = BSpline.design_matrix(place + 0.5, knots, 3).toarray()
    found = cubic_splines(place, size, terms)
    np.testing.assert_allclose(found, oracle, atol=1e-14)
    np.testing.assert_allclose(found.sum(axis=1), 1.0, rtol=1e-14)


def test_legendre_polynomials_span_the_axis_from_edge_to_edge():
    found = legendre(np.array([-0.5, 49.5, 99.5]), 100, 2)
    np.testing.assert_allclose(found, [[1.0, -1.0, 1.0], [1.0, 0.0, -0.5], [1.0, 1.0, 1.0]], atol=1e-15)


@settings(max_examples=50)
@given(
    row=st.floats(-200.0, 500.0),
    column=st.floats(-300.0, 700.0),
    focal=st.floats(100.0, 5000.0),
)
def test_the_quadratic_is_the_cosine_fourth_law_about_its_axis(row, column, focal):
    scale = PLANE.half_diagonal
    y, x = PLANE.centred(row, column)
    reach2 = (focal / scale) ** 2
    level = 1.0 + float(y * y + x * x) / reach2
    quadratic = np.array([-2.0 * float(y), -2.0 * float(x), 1.0]) / reach2 / level
    surface = CosineSurface(plane=PLANE)
    at_row, at_column = np.array([0.0, 150.0, 300.0]), np.array([401.0, 10.0, 200.0])
    law = (1.0 + ((at_row - row) ** 2 + (at_column - column) ** 2) / focal**2) ** -2.0
    found = surface.value(at_row, at_column, np.array([level**-2.0, *quadratic]))
    np.testing.assert_allclose(found, law, rtol=1e-11)
    np.testing.assert_allclose(surface.axis(np.array([1.0, *quadratic])), (row, column, focal), rtol=1e-6, atol=1e-6)


def test_nothing_that_shades_has_no_axis():
    surface = CosineSurface(plane=PLANE)
    assert surface.axis(np.array([500.0, 0.0, 0.0, 0.0])) is None
    assert surface.axis(np.array([500.0, 0.1, 0.0, -0.2])) is None
    assert surface.axis(np.array([500.0, 3.0, 0.0, 0.5])) is None
    np.testing.assert_allclose(surface.value(3.0, 4.0, np.array([500.0, 0.0, 0.0, 0.0])), 500.0)
