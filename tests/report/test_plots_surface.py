"""Surfaces in space: facets lie where the values are, holes stay holes, and ranges of differences are symmetric."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from matplotlib.figure import Figure
from mpl_toolkits.mplot3d.art3d import Poly3DCollection

from fullwell.report.plots_surface import MOST_FACETS, Surface, draw_surfaces, space, symmetric_limit


def facets(values, **options):
    axes = space(Figure(), Figure().add_gridspec(1, 1)[0])
    rows, columns = (np.arange(size, dtype=float) for size in values.shape)
    draw_surfaces(axes, [Surface(rows=rows, columns=columns, values=values)], **options)
    (drawn,) = (one for one in axes.collections if isinstance(one, Poly3DCollection))
    return axes, len(drawn.get_facecolor())


@given(rows=st.integers(2, 90), columns=st.integers(2, 90))
def test_a_surface_has_as_many_facets_as_it_has_cells_or_the_most_allowed(rows, columns):
    _, count = facets(np.add.outer(np.arange(rows, dtype=float), np.arange(columns, dtype=float)))
    assert count == min(rows - 1, MOST_FACETS) * min(columns - 1, MOST_FACETS)


def test_a_point_that_is_unknown_leaves_its_four_facets_out():
    values = np.ones((5, 6)) * np.arange(6)
    values[2, 3] = np.nan
    assert facets(values)[1] == 4 * 5 - 4


@pytest.mark.parametrize("value", [0.0, 5.0])
def test_a_flat_surface_still_has_a_height_to_be_drawn_in(value):
    axes, count = facets(np.full((4, 4), value))
    assert count == 9
    assert axes.get_zlim() == pytest.approx((value - 0.5, value + 0.5))


def test_the_first_row_lies_at_the_back():
    low, high = facets(np.eye(4))[0].get_ylim()
    assert (low, high) == (3.0, 0.0)


def test_a_limit_is_the_magnitude_that_all_but_a_few_stay_below():
    values = np.array([-3.0, 1.0, 2.0, np.nan])
    assert symmetric_limit(values, share=100.0) == 3.0
    assert symmetric_limit(np.zeros(3), least=0.01) == 0.01
    assert symmetric_limit(np.array([np.nan])) > 0.0
