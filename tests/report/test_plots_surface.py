"""Surfaces in space: facets lie where the values are, holes stay holes, and ranges of differences are symmetric."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fullwell.report.drawing import Axes
from fullwell.report.drawing.facets import Facets
from fullwell.report.plots_surface import MOST_FACETS, Surface, draw_surfaces, space, symmetric_limit


def facets(values, **options):
    """Return the corners of the facets as drawn, the farthest first, shape (facets, 4, 2)."""
    axes = Axes()
    space(axes)
    rows, columns = (np.arange(size, dtype=float) for size in values.shape)
    draw_surfaces(axes, [Surface(rows=rows, columns=columns, values=values)], **options)
    (drawn,) = [mark for mark in axes.marks if isinstance(mark, Facets)]
    return drawn.corners


@given(rows=st.integers(2, 90), columns=st.integers(2, 90))
def test_a_surface_has_as_many_facets_as_it_has_cells_or_the_most_allowed(rows, columns):
    corners = facets(np.add.outer(np.arange(rows, dtype=float), np.arange(columns, dtype=float)))
    assert len(corners) == min(rows - 1, MOST_FACETS) * min(columns - 1, MOST_FACETS)


def test_a_point_that_is_unknown_leaves_its_four_facets_out():
    values = np.ones((5, 6)) * np.arange(6)
    values[2, 3] = np.nan
    assert len(facets(values)) == 4 * 5 - 4


@pytest.mark.parametrize("value", [0.0, 5.0])
def test_a_flat_surface_is_drawn_at_half_the_height(value):
    corners = facets(np.full((4, 4), value))
    assert len(corners) == 9
    other = facets(np.full((4, 4), value), limits=(value - 3.0, value + 3.0))
    assert corners == pytest.approx(other)


def test_facets_are_drawn_from_the_back_and_the_first_row_lies_there():
    middle = facets(np.zeros((6, 2))).mean(axis=1)
    assert np.all(np.diff(middle[:, 1]) < 0.0)
    rising = np.zeros((6, 2))
    rising[0] = 1.0
    lifted = facets(rising, limits=(-0.5, 0.5)).mean(axis=1)
    assert lifted[:, 1].max() > middle[:, 1].max()
    assert lifted[:, 1].min() == pytest.approx(middle[:, 1].min())


def test_a_higher_point_is_seen_higher():
    low, high = (facets(np.full((2, 2), value), limits=(0.0, 1.0)) for value in (0.2, 0.7))
    assert np.all(high[..., 1] > low[..., 1])
    assert high[..., 0] == pytest.approx(low[..., 0])


def test_a_limit_is_the_magnitude_that_all_but_a_few_stay_below():
    values = np.array([-3.0, 1.0, 2.0, np.nan])
    assert symmetric_limit(values, share=100.0) == 3.0
    assert symmetric_limit(np.zeros(3), least=0.01) == 0.01
    assert symmetric_limit(np.array([np.nan])) > 0.0
