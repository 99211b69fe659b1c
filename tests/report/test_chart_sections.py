"""The chapters on charts: there where a chart was measured and nowhere else, drawn from the numbers."""

import re
from dataclasses import replace
from html import unescape

import numpy as np
import pytest
from drawn import photographs
from synthetic_chart import (
    BLACK,
    DARK,
    DENSITIES,
    FIXED,
    MAXIMUM,
    SHOT,
    chart_curves,
    chart_pictures,
    chart_results,
    chart_rows,
)

from fullwell.figures.results import Column, Curve, Results
from fullwell.report import plots_chart, plots_chart_levels, plots_chart_scene
from fullwell.report.chart_sections import chart_sections, charts_alone
from fullwell.report.chart_tables import (
    black_level_table,
    coefficient_facts,
    coefficients_table,
    one_curve,
    range_table,
    range_words,
    rows_of_charts,
    show_figure,
)
from fullwell.report.curves import Table, table_named
from fullwell.report.html import report_html
from fullwell.report.material import Section, material_of
from fullwell.report.plots_chart_model import NoiseCurve, common_lines, leading_curve, noise_curves, patches_of
from fullwell.report.sections import build_sections
from fullwell.units import ONE, Measured

ANCHORS = ["chart", "noise-model", "tonal-response", "noise-against-exposure", "chart-black-level", "chart-range"]


def table(name: str, curves: tuple[Curve, ...] | None = None) -> Table:
    found = table_named(curves or chart_curves(), name)
    assert found is not None
    return found


def with_column(curve: Curve, name: str, value: float | str | None) -> Curve:
    columns = tuple(
        Column(name=one.name, unit=one.unit, values=(value,) * len(one.values)) if one.name == name else one
        for one in curve.columns
    )
    return replace(curve, columns=columns)


@pytest.fixture(scope="module")
def sections() -> dict[str, Section]:
    return {section.anchor: section for section in build_sections(chart_results(), chart_pictures())}


def test_a_report_of_charts_has_their_chapters_and_asks_for_nothing_else(sections: dict[str, Section]) -> None:
    assert list(sections) == ANCHORS
    assert not any(section.missing for section in sections.values())
    pictures = [one for section in sections.values() for part in (section, *section.parts) for one in part.pictures]
    assert len(pictures) == 8
    assert all(one.alt and one.caption.endswith(".") for one in pictures)


def test_a_study_without_charts_has_none_of_their_chapters(results: Results) -> None:
    material = material_of(results, None)
    assert chart_sections(material) == ()
    assert not charts_alone(material)


def test_a_study_with_a_chart_keeps_its_own_chapters(results: Results) -> None:
    study = replace(results, rows=(), curves=tuple(one for one in results.curves if one.name == "read_noise_iso"))
    both = replace(study, curves=(*study.curves, *chart_curves((55.0,))), rows=chart_rows((55.0,)))
    before = [section.anchor for section in build_sections(study, None)]
    assert "read-noise" in before
    assert [section.anchor for section in build_sections(both, None)] == [*before, *ANCHORS[1:]]


def test_a_report_of_nothing_is_not_one_of_charts() -> None:
    assert not charts_alone(material_of(Results(study={}, rows=(), findings=(), curves=()), None))


def test_chapters_appear_only_with_their_curves() -> None:
    points = with_column(chart_curves()[0], "density", None)
    alone = replace(chart_results(), rows=(), curves=(points, chart_curves()[1]))
    assert [section.anchor for section in build_sections(alone, None)] == ["noise-model", "chart-black-level"]


def test_one_exposure_has_no_bracket_to_draw() -> None:
    results = chart_results(ratios=(1.0,))
    (section,) = (one for one in build_sections(results, None) if one.anchor == "chart-black-level")
    assert section.parts == ()
    assert len(section.pictures) == 1


def test_several_isos_go_into_tabs() -> None:
    sections = {one.anchor: one for one in build_sections(chart_results((100.0, 400.0)), chart_pictures(400.0))}
    assert [tab.label for tab in sections["noise-model"].tabs] == ["ISO 100", "ISO 400"]
    assert sections["noise-model"].pictures == ()
    (developed,) = sections["noise-model"].parts
    assert len(developed.pictures) == 1
    assert "ISO 400" in developed.pictures[0].caption
    assert sections["chart-range"].tables[0].head[0] == "ISO"
    assert {line[0] for line in sections["chart-range"].tables[0].lines} == {"100", "400"}


def test_page_is_complete_in_itself_and_says_why_a_developed_picture_is_jumbled() -> None:
    page = report_html(chart_results(), chart_pictures())
    assert re.findall(r'(?:src|href)="(?!data:|#)[^"]*"', page) == []
    text = unescape(page)
    assert "no longer on the level alone: the curve is jumbled" in text
    assert "located in the image with a confidence of 0.87 of 1" in text
    assert "No photon transfer" not in text
    assert "1.6720 × 10⁻⁴" in text or "(1.6720 ± 0.0033) × 10⁻⁴" in text


def test_powers_stand_behind_value_and_error_each() -> None:
    page = report_html(chart_results(), None)
    assert re.search(r'<td[^>]*>2\.400 × 10⁻⁴<small class="pm"> ± 0\.020 × 10⁻⁴</small>', page)
    assert not re.search(r"<td[^>]*>\([\d.]+<small", page)


def test_model_is_the_sum_of_its_parts_and_meets_the_signal_where_it_should() -> None:
    curve = noise_curves(table("chart_noise_model"))["all"]
    dark, shot, fixed = curve.coefficients
    assert (dark, shot, fixed) == pytest.approx((1.672e-4, 5.554e-3, 5.477e-3), rel=1e-12)
    signal = np.geomspace(1e-6, 1.0, 40)
    assert curve.noise(signal) ** 2 == pytest.approx(dark**2 + shot**2 * signal + (fixed * signal) ** 2, rel=1e-12)
    share = 1.0 - FIXED
    crossing = (SHOT + (SHOT**2 + 4.0 * DARK * share) ** 0.5) / (2.0 * share) / MAXIMUM
    assert curve.detection == pytest.approx(crossing, rel=8.0 * np.log(10.0) / 4000.0)


def test_parts_that_came_out_negative_are_not_drawn() -> None:
    curve = NoiseCurve(
        channel="all", dark=-1.0, shot=SHOT, fixed_pattern=-1e-9, black_level=0.0, digital_maximum=MAXIMUM
    )
    dark, shot, fixed = curve.coefficients
    assert np.isnan(dark)
    assert shot > 0.0
    assert np.isnan(fixed)
    assert np.isnan(curve.noise(np.array([1e-9]))).all()
    models = with_column(with_column(chart_curves()[1], "fixed_pattern", -1e-9), "dark", -1.0)
    points, negative = table("chart_points"), table("chart_noise_model", (models,))
    assert plots_chart.noise_curve(points, negative, 100.0, facts=(), one_curve=True)
    assert plots_chart.snr_curve(points, negative, 100.0, facts=(), saturation=None, range_text="")


def test_without_any_model_nothing_is_drawn_beside_it() -> None:
    empty = Table(columns=())
    assert leading_curve(noise_curves(empty)) is None
    assert plots_chart.noise_curve(table("chart_points"), empty, 100.0, facts=(), one_curve=False) is None
    assert plots_chart_levels.clustering(table("chart_points"), empty, 100.0) is None


def test_one_line_for_all_channels_or_one_each() -> None:
    curves = dict(noise_curves(table("chart_noise_model")))
    assert [one.channel for one in common_lines(curves)] == ["all"]
    del curves["all"]
    assert sorted(one.channel for one in common_lines(curves)) == ["B", "G1", "G2", "R"]


def test_patches_are_normalized_and_know_what_took_part() -> None:
    points = table("chart_points")
    every = {one.channel: one for one in patches_of(points, MAXIMUM)}
    assert list(every) == ["R", "G1", "G2", "B"]
    one, (_, part) = every["B"], next(pair for pair in points.split("channel") if pair[0] == "B")
    assert one.signal * MAXIMUM == pytest.approx(part.numbers("signal"), rel=1e-12)
    assert (one.noise * MAXIMUM) ** 2 == pytest.approx(part.numbers("variance"), rel=1e-12)
    assert (~one.used).sum() == 1
    assert one.brightest.sum() == len(DENSITIES)
    positive = one.signal > 0.0
    assert 10.0 ** (one.snr[positive] / 20.0) == pytest.approx((one.signal / one.noise)[positive], rel=1e-12)
    assert np.isnan(one.snr[~positive]).all()


def test_caption_claims_one_curve_only_where_there_is_one() -> None:
    rows = chart_rows()
    assert one_curve(rows, 100.0)
    differ = tuple(
        replace(row, flags=(*row.flags, "channels-differ")) if row.quantity == "k_fpn" and row.channel == "all" else row
        for row in rows
    )
    assert not one_curve(differ, 100.0)
    points, models = table("chart_points"), table("chart_noise_model")
    said = [plots_chart.noise_curve(points, models, 100.0, facts=(), one_curve=same) for same in (True, False)]
    assert ["every colour lies on one curve" in one.caption for one in said if one] == [True, False]


def test_clustering_names_the_level_and_needs_one() -> None:
    points, curves = table("chart_points"), chart_curves()
    drawn = plots_chart_levels.clustering(points, table("chart_noise_model"), 100.0)
    assert drawn is not None
    without = with_column(curves[1], "black_level", 0.0)
    assert plots_chart_levels.clustering(points, table("chart_noise_model", (without,)), 100.0) is None


def test_chart_is_brightened_until_its_lightest_used_patch_is_nearly_white() -> None:
    (picture,) = chart_pictures().charts
    drawn = plots_chart_scene.annotated_chart(picture)
    (shown,) = photographs(drawn)
    assert shown.shape == picture.image.shape
    name, x, y, width, height = picture.patches[1]
    middle = shown[round(y) : round(y + height), round(x) : round(x + width)]
    assert name == "P2"
    assert float(np.median(middle)) == pytest.approx(235.0, abs=2.0)
    assert "Orange" in drawn.caption


def test_a_black_picture_is_not_brightened_without_end() -> None:
    (picture,) = chart_pictures().charts
    drawn = plots_chart_scene.annotated_chart(replace(picture, image=np.zeros_like(picture.image), confidence=None))
    assert "placed as given" in drawn.caption


def test_tables_put_evidence_and_published_fits_side_by_side() -> None:
    (evidence,) = black_level_table(chart_rows())
    assert evidence.head == ("Evidence", "R", "G1", "G2", "B", "all", "Flags")
    assert [line[0] for line in evidence.lines] == ["fused", "exposure-bracket", "metadata", "legacy-offset-ratio"]
    assert evidence.lines[0][5] == "511.6200 ± 0.0060"
    assert evidence.lines[2][1] == "512"
    (fits,) = coefficients_table(chart_rows())
    assert len(fits.lines) == 15
    assert fits.lines[-3][:2] == ("all", "gamma-likelihood")
    (ranges,) = range_table(chart_rows())
    assert [line[:2] for line in ranges.lines] == [("0 dB", "1"), ("10 dB", "3.16"), ("20 dB", "10")]
    assert ranges.lines[0][2:] == ("73.830 ± 0.010", "12.2629 ± 0.0020", "72.930 ± 0.010", "12.1134 ± 0.0020", "77.83")
    assert range_words(chart_rows(), 100.0) == "dynamic range 73.83 dB = 12.26 EV"


def test_tables_of_no_rows_are_none() -> None:
    assert black_level_table(()) == coefficients_table(()) == range_table(()) == ()
    assert coefficient_facts((), None) == ()
    assert range_words((), None) == ""


def test_a_figure_that_hangs_on_an_unknown_level_is_an_interval() -> None:
    measured = Measured(value=1.69e-4, unit=ONE, std_error=2e-6, ci95=(1.65e-4, 1.73e-4))
    row = next(one for one in chart_rows() if one.quantity == "k_dark" and one.method == "gamma-likelihood")
    unknown = replace(row, measured=measured, flags=("offset-not-identified",))
    assert show_figure(unknown) == "(1.650 to 1.730) × 10⁻⁴"
    assert show_figure(replace(unknown, flags=())) == "(1.690 ± 0.020) × 10⁻⁴"


def test_a_charts_own_rows_stand_before_those_of_the_study_it_is_part_of() -> None:
    study = next(one for one in chart_rows() if one.quantity == "black_level" and one.method == "fused")
    own = replace(study, region="chart", measured=Measured.normal(BLACK + 1.0, 0.1, "DN"))
    tile = replace(study, region="tile:0,0")
    assert rows_of_charts((study, own, tile)) == (own,)
    assert rows_of_charts((study, tile)) == (study,)
