"""Pictures of charts: every patch where it belongs, every part of the model named, the figures beside the curve."""

import re
from dataclasses import replace

import numpy as np
import pytest
from drawn import areas, lines, photographs, points
from synthetic_chart import BLACK, RESPONSE, chart_curves, chart_pictures

from fullwell.report.curves import Table, table_named
from fullwell.report.drawing.style import PAPER, QUIET
from fullwell.report.plots import Picture, color_of
from fullwell.report.plots_chart import jumbled, noise_curve, snr_curve
from fullwell.report.plots_chart_levels import clustering, proportional_exposures, tonal_response
from fullwell.report.plots_chart_model import DARK, FIXED, MODEL_GRAY, SHOT
from fullwell.report.plots_chart_scene import against_density, annotated_chart

LIT = 15
"""Patches of the chart that are far above black, as no limit of a picture cuts them off."""


def table(name: str, **changed: float) -> Table:
    found = table_named(chart_curves(), name)
    assert found is not None
    columns = tuple(
        (name, (changed[name],) * len(values)) if name in changed else (name, values) for name, values in found.columns
    )
    return Table(columns=columns)


def lit(name: str = "chart_points") -> Table:
    found = table(name)
    return found.chosen(int(str(patch)[1:]) <= LIT for patch in found.values("patch"))


def noise(models: Table, **options) -> Picture:
    drawn = noise_curve(lit(), models, 100.0, facts=options.get("facts", ()), one_curve=True)
    assert drawn is not None
    return drawn


@pytest.mark.parametrize(("channel", "left_out"), [("R", 0), ("B", 1)])
def test_every_patch_is_a_circle_on_the_curve_and_one_in_the_residuals(channel: str, left_out: int) -> None:
    drawn, color = noise(table("chart_noise_model")), color_of(channel)
    in_legend = 1
    assert points(drawn, stroke=color, fill=color) == 2 * (LIT - left_out) + in_legend
    assert points(drawn, stroke=color, fill=PAPER) == 2 * LIT


def test_a_patch_that_took_no_part_is_a_cross_without_a_residual() -> None:
    in_legend = 2
    assert points(noise(table("chart_noise_model")), stroke=QUIET, fill="none") == 1 + in_legend


def test_parts_of_the_noise_are_dashed_and_named(words: list[str]) -> None:
    drawn = noise(table("chart_noise_model"), facts=(("k_{dark}", "1.672 × 10⁻⁴"), ("read noise", "5.4 e⁻")))
    assert [len(lines(drawn, stroke=color, dashed=True)) for color in (DARK, SHOT, FIXED)] == [1, 1, 1]
    assert len(lines(drawn, stroke=MODEL_GRAY, dashed=False)) == 2  # the one that all share, and the legend
    assert {"dark noise", "shot noise  ∝ √V", "fixed pattern  ∝ V", "noise model"} <= set(words)
    assert {"k_{dark}", "1.672 × 10⁻⁴", "read noise", "5.4 e⁻"} <= set(words)
    assert {"Normalized noise  σ / D", "Residual [σ]"} <= set(words)
    assert words.count("Normalized signal above black  V = S / D") == 1


def test_a_part_that_is_not_there_has_no_line_and_no_name(words: list[str]) -> None:
    drawn = noise(table("chart_noise_model", fixed_pattern=-1e-9))
    assert lines(drawn, stroke=FIXED) == []
    assert not any("fixed pattern" in word for word in words)
    assert "but none is seen" in drawn.caption


def test_range_is_an_arrow_from_snr_1_to_saturation(words: list[str]) -> None:
    models = table("chart_noise_model")
    both = [
        snr_curve(lit(), models, 100.0, facts=(), saturation=saturation, range_text="dynamic range 73 dB")
        for saturation in (0.9, None)
    ]
    assert words.count("dynamic range 73 dB") == 1
    heads = [len(areas(one, fill="#1f2933")) for one in both if one]
    assert heads == [2, 0]
    assert {"dark noise alone", "shot noise alone", "Signal / noise [dB]", "0", "40"} <= set(words)


def test_developed_picture_stands_beside_the_raw_file(words: list[str]) -> None:
    (rendered,) = chart_pictures().rendered
    drawn = jumbled(lit(), table("chart_noise_model"), 100.0, rendered)
    assert drawn is not None
    assert points(drawn, stroke=color_of("G"), fill=color_of("G")) == LIT + 36 + 1  # G1 has the colour of G
    assert points(drawn, stroke=color_of("R"), fill=color_of("R")) == LIT + 35 + 1  # one noise is unknown
    assert {"Raw file: one curve", "Developed picture: no curve"} <= set(words)


def test_clustering_shows_where_the_black_level_is(words: list[str]) -> None:
    drawn = clustering(lit(), table("chart_noise_model"), 100.0)
    assert drawn is not None
    assert {"Black level left in", f"{BLACK:.5g} DN taken off", "500 of 511.62 DN taken off"} <= set(words)
    assert len(lines(drawn, stroke=QUIET, dashed=True)) == 2
    assert words.count("Normalized noise") == 1
    assert words.count("10^{\N{MINUS SIGN}3}") >= 1
    assert points(drawn, stroke=color_of("R"), fill=color_of("R")) == 3 * LIT + 1


def test_tonal_response_has_slope_1_once_in_both_panels(words: list[str]) -> None:
    drawn = tonal_response(table("chart_tonal_response"), {"all": BLACK}, 100.0)
    color = color_of("G2")
    seen = len(table("chart_tonal_response").values("channel")) // len(RESPONSE)
    slopes = seen - 2
    assert 2 * LIT + slopes < points(drawn, stroke=color, fill=color) <= 2 * seen + slopes + 1
    assert len(lines(drawn, stroke=QUIET, dashed=True)) == 2 + 1 + 1  # slope 1 twice, level 1, the legend
    assert words.count("log_{10} exposure  (−density)") == 3
    assert f"({BLACK:.5g} DN)" in drawn.caption


def test_every_darker_exposure_is_a_panel(words: list[str]) -> None:
    drawn = proportional_exposures(lit("chart_bracket"), 100.0)
    assert drawn is not None
    assert "Exposure × 0.125" in words
    assert points(drawn, stroke=color_of("G1"), fill=color_of("G1")) == LIT + 1


def test_noise_against_density_is_filled_at_the_brightest_exposure(words: list[str]) -> None:
    drawn = against_density(lit(), 100.0)
    assert drawn is not None
    color = color_of("G1")
    assert points(drawn, stroke=color, fill=color) == 2 * LIT + 1
    assert points(drawn, stroke=color, fill=PAPER) == 2 * LIT
    assert {"Noise", "Signal-to-noise ratio", "darker exposure"} <= set(words)


def test_every_patch_of_a_chart_has_its_outline_and_its_name(words: list[str]) -> None:
    (chart,) = chart_pictures().charts
    drawn = annotated_chart(chart)
    assert len(lines(drawn, stroke="#ffe14d")) == 35
    assert len(lines(drawn, stroke="#ff7a45")) == 1
    assert len(lines(drawn, stroke="#ffffff", dashed=True)) == 1
    assert [word for word in words if re.fullmatch(r"P\d+", word)] == [f"P{number}" for number in range(1, 37)]
    (photograph,) = photographs(drawn)
    assert photograph.shape == chart.image.shape


def test_an_outline_lies_where_its_patch_does() -> None:
    (chart,) = chart_pictures().charts
    path = lines(annotated_chart(chart), stroke="#ff7a45")[0]
    places = np.array(re.findall(r"(-?[\d.]+) (-?[\d.]+)", path), float)
    scale = 9.2 * 72.0 / chart.image.shape[1]
    _, x, y, wide, high = chart.patches[0]
    assert places.min(axis=0) == pytest.approx((scale * x, scale * y), abs=0.02)
    assert np.ptp(places, axis=0) == pytest.approx((scale * wide, scale * high), abs=0.02)


def test_tiny_patches_have_outlines_without_names(words: list[str]) -> None:
    (chart,) = chart_pictures().charts
    small = replace(chart, patches=tuple((name, x, y, 2.0, 2.0) for name, x, y, _, _ in chart.patches))
    assert len(lines(annotated_chart(small), stroke="#ffe14d")) == 35
    assert words == []
