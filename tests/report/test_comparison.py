"""Published beside corrected: a ratio where it means something, standard errors where not, greens and all matched."""

from dataclasses import replace

import pytest

from fullwell.figures.results import Row
from fullwell.report.comparison import published_beside
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


def prnu(channel, value, iso=55.0):
    return Row(
        quantity="prnu",
        channel=channel,
        method="flat-dark-stack",
        measured=Measured.normal(value, 0.01, "%"),
        iso=iso,
        flags=("recommended",),
    )


def slope_spread(channel, value, region=None):
    return replace(
        prnu(channel, value),
        method="legacy-slope-std",
        measured=Measured.exact(value, "%"),
        flags=(),
        region=region,
    )


def only_line(rows, models=None):
    chapter = published_beside(rows, models or {})
    assert chapter is not None
    (iso,) = chapter.isos
    (block,) = iso.blocks
    (line,) = block.lines
    return line


def test_a_figure_well_off_zero_is_compared_in_per_cent():
    assert only_line(pair(2.0, 0.1, 1.5)).difference == "−25.0 %"
    chapter = published_beside(pair(2.0, 0.1, 1.5), {})
    assert chapter is not None
    assert chapter.summary == "dark current −25.0 % (frame-slope)."
    assert "single frames" in chapter.verdicts[0].reason


def test_a_figure_many_times_too_large_is_told_as_a_multiple():
    assert only_line(pair(2.0, 0.1, 42.0)).difference == "21 times"


def test_a_figure_that_may_be_zero_is_compared_in_standard_errors():
    assert only_line(pair(-0.04, 0.5, 1.46)).difference == "+3.0 standard errors"
    chapter = published_beside(pair(-0.04, 0.5, 1.46), {})
    assert chapter is not None
    assert "may as well be zero" in chapter.verdicts[0].summary
    assert chapter.summary == ""


def test_only_figures_of_the_same_channel_iso_and_unit_are_compared():
    best, legacy = pair(2.0, 0.1, 1.5)
    for other in (
        replace(legacy, iso=99.0),
        replace(legacy, channel="G2"),
        replace(legacy, measured=Measured.exact(1.5, "e-/s")),
        replace(legacy, region="tile:0,0"),
    ):
        assert published_beside((best, other), {}) is None


def test_the_second_unit_of_a_figure_is_not_compared_again():
    first, second = pair(2.0, 0.1, 1.5), pair(5.0, 0.25, 3.75)
    electrons = tuple(replace(row, measured=row.measured.scaled(1.0, "e-/s")) for row in second)
    chapter = published_beside((*first, *electrons), {})
    assert chapter is not None
    assert [block.unit for block in chapter.isos[0].blocks] == ["DN/s"]


def test_the_studys_green_stands_beside_both_greens_and_against_their_mean():
    line = only_line([prnu("G1", 0.6), prnu("G2", 0.8), prnu("R", 5.0), slope_spread("G", 1.4)])
    assert line.corrected == ("G1 0.600 (0.580 to 0.620)", "G2 0.800 (0.780 to 0.820)")
    assert line.difference == "+100 %"


def test_a_figure_of_all_pixels_stands_beside_the_range_over_channels():
    rows = [prnu(channel, value) for channel, value in (("R", 0.7), ("G1", 0.6), ("G2", 0.8), ("B", 0.7))]
    line = only_line([*rows, slope_spread("all", 25.2)])
    assert line.corrected == ("0.600 to 0.800", "over the channels")
    assert line.difference == "36 times"


def test_crop_and_tiles_are_two_lines_each_with_its_reason():
    rows = [prnu("G1", 0.6), prnu("G2", 0.8), slope_spread("G", 1.4), slope_spread("G", 2.1, "917,1505,1318,968")]
    chapter = published_beside(rows, {})
    assert chapter is not None
    assert [one.title for one in chapter.verdicts] == ["PRNU, tiles", "PRNU, whole crop"]
    tiles, crop = (one.reason for one in chapter.verdicts)
    assert "averaging G1 and G2 lowers green by √2" in tiles
    assert "Over the whole crop" not in tiles
    assert "Over the whole crop" in crop


@pytest.mark.parametrize("chosen", ["p-spline", "radial"])
def test_the_published_map_stands_beside_the_chosen_model_of_the_longest_exposure(chosen):
    def corner(model, value, exposure_s):
        return Row(
            quantity="shading_corner",
            channel="R",
            method=model,
            measured=Measured.normal(value, 0.001, "1"),
            iso=55.0,
            exposure_s=exposure_s,
        )

    rows = [
        corner(model, value, exposure_s)
        for exposure_s in (0.01, 0.03)
        for model, value in (("p-spline", 0.4), ("radial", 0.5), ("legacy-poly22", 0.3))
    ]
    line = only_line(rows, {(55.0, 0.01, "R"): chosen, (55.0, 0.03, "R"): chosen})
    assert line.difference == {"p-spline": "−25.0 %", "radial": "−40.0 %"}[chosen]
    assert published_beside(rows, {}) is None
