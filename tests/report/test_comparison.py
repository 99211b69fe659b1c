"""Published beside recommended: a ratio where it means something, standard errors where not."""

from dataclasses import replace

from fullwell.figures.results import Row
from fullwell.report.comparison import comparisons
from fullwell.units import Measured


def pair(value, error, published):
    best = Row(
        quantity="dark_current",
        channel="G1",
        method="mean-slope",
        measured=Measured.normal(value, error, "DN/s"),
        iso=55.0,
        flags=("recommended",),
    )
    legacy = replace(best, method="legacy-frame-slope", measured=Measured.exact(published, "DN/s"), flags=())
    return best, legacy


def test_a_figure_well_off_zero_is_compared_in_per_cent():
    (found,) = comparisons(pair(2.0, 0.1, 1.5))
    assert found.pairs[0].ratio == "−25.0 %"
    assert found.summary == "published against recommended: −25.0 %"
    assert "covers 50 %" in found.bias


def test_a_figure_that_may_be_zero_is_compared_in_standard_errors():
    (found,) = comparisons(pair(-0.04, 0.5, 1.46))
    assert found.pairs[0].ratio == "+3.0 standard errors"
    assert "cannot be told from zero" in found.summary


def test_only_figures_of_the_same_channel_iso_and_unit_are_compared():
    best, legacy = pair(2.0, 0.1, 1.5)
    for other in (
        replace(legacy, iso=99.0),
        replace(legacy, channel="G2"),
        replace(legacy, measured=Measured.exact(1.5, "e-/s")),
        replace(legacy, region="tile:0,0"),
    ):
        assert comparisons((best, other)) == ()


def test_the_second_unit_of_a_figure_is_not_compared_again():
    first, second = pair(2.0, 0.1, 1.5), pair(5.0, 0.25, 3.75)
    electrons = tuple(replace(row, measured=row.measured.scaled(1.0, "e-/s")) for row in second)
    assert [found.unit for found in comparisons((*first, *electrons))] == ["DN/s"]
