"""The report is one page that needs nothing else, says findings first, and leaves no number unexplained."""

import base64
import re
from dataclasses import replace
from html.parser import HTMLParser
from itertools import pairwise

import pytest
from synthetic_results import synthetic_pictures

from fullwell.figures.results import Results, Row
from fullwell.findings import Finding, Severity
from fullwell.report.html import report_html
from fullwell.report.pictures import Pictures
from fullwell.units import Measured


class Outline(HTMLParser):
    """Collects what a test asks about a page."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.loads: list[str] = []
        self.links: list[str] = []
        self.anchors: set[str] = set()
        self.pictures: list[dict[str, str | None]] = []
        self.headings: list[int] = []
        self.sections: list[dict[str, str | None]] = []
        self.feed(text)

    def handle_starttag(self, tag, attrs):
        values = dict(attrs)
        if values.get("id"):
            self.anchors.add(values["id"])
        if re.fullmatch("h[1-6]", tag):
            self.headings.append(int(tag[1]))
        elif tag == "section":
            self.sections.append(values)
        elif tag == "a":
            self.links.append(values["href"])
        elif tag == "img":
            self.pictures.append(values)
        if tag in ("script", "link", "iframe", "object", "embed", "source", "video", "audio"):
            self.loads += [values[key] for key in ("src", "href", "data") if key in values]


@pytest.fixture(scope="module")
def outline(page):
    return Outline(page)


def test_nothing_is_loaded_from_anywhere(page, outline):
    assert outline.loads == []
    assert all(picture["src"].startswith("data:image/") for picture in outline.pictures)
    style = page[page.index("<style>") : page.index("</style>")]
    assert "url(" not in style
    assert "@import" not in style
    script = page[page.index("<script>") :]
    assert "fetch(" not in script
    assert "http" not in script


def test_pictures_inside_load_nothing_either(outline):
    for picture in outline.pictures:
        kind, _, data = picture["src"].partition(";base64,")
        if kind == "data:image/svg+xml":
            svg = base64.b64decode(data).decode()
            assert all(link.startswith(("#", "data:")) for link in re.findall(r'href="([^"]*)"', svg))


def test_every_link_leads_to_a_place_on_the_page(outline):
    assert outline.links
    assert {link.removeprefix("#") for link in outline.links} <= outline.anchors


def test_every_picture_says_in_words_what_it_shows(outline):
    assert len(outline.pictures) >= 20
    assert all(len(picture["alt"] or "") > 20 for picture in outline.pictures)


def test_findings_stand_first_and_the_worst_before_the_others(page):
    places = [page.index(f'class="finding {severity}"') for severity in ("error", "warning", "info")]
    assert places == sorted(places)
    assert page.index('id="findings"') < page.index('id="summary"') < page.index('id="photon-transfer"')


def test_every_measurement_has_its_section(outline):
    wanted = "findings summary against-iso photon-transfer snr saturation read-noise row-column-noise dark-current"
    wanted += (
        " black-level lens-shading nonuniformity differences exposure-series drift published rows inventory definitions"
    )
    assert set(wanted.split()) <= outline.anchors


def test_headings_skip_no_level_and_every_section_is_named_by_its_own(outline):
    steps = [(above, below) for above, below in pairwise(outline.headings) if below > above + 1]
    assert outline.headings[0] == 1
    assert not steps
    for section in outline.sections:
        assert section["aria-labelledby"] in outline.anchors


def test_every_quantity_shown_is_defined(results, outline):
    shown = {row.quantity.removesuffix("_variance") for row in results.rows}
    assert {f"def-{name}" for name in shown} <= outline.anchors


def test_the_published_flows_say_why_they_differ(page):
    assert "10.6 %" in page
    assert "read noise −8.9 % (burst-mean)" in page
    assert "low by √((n−1)/n)" in page


def test_the_title_names_camera_and_study_and_hashes_are_shortened(page):
    assert "<h1>Google Pixel 4a (IMX363)</h1>" in page
    assert "Study pixel-4a." in page
    assert "2025-11-23 16:00 UTC" in page
    assert f"{'0' * 16}…" in page
    assert "0" * 17 not in page


def test_six_isos_stay_small(page):
    assert len(page) < 12_000_000


def test_a_study_that_tells_nothing_names_the_missing_captures():
    finding = Finding(code="no-dark-frames", severity=Severity.WARNING, message="no dark frames at ISO 99: none taken")
    page = report_html(Results(study={}, rows=(), findings=(finding,), curves=()), None)
    for words in ("No dark frames at ISO 99", "capture dark bursts", "capture flat frames", "capture a burst of bias"):
        assert words in page


def test_what_comes_from_files_cannot_become_markup():
    evil = "<script>alert(1)</script>"
    finding = Finding(code="x", severity=Severity.ERROR, message=evil, files=(evil,))
    row = Row(quantity=evil, channel="G1", method=evil, measured=Measured.exact(1.0, "DN"), source=evil)
    study = {"camera": {"name": evil}, "files": [{"path": evil}]}
    page = report_html(Results(study=study, rows=(row,), findings=(finding,), curves=(), run={"command": evil}), None)
    assert evil not in page


def test_one_unknown_iso_and_one_channel_draw_without_complaint(results):
    def mono(values):
        return tuple("mono" if value in ("R", "G1", "G2", "B") else value for value in values)

    curves = []
    for curve in results.curves:
        wanted = {"iso": 55.0, "channel": "G1"}
        found = [column for column in curve.columns if column.name in wanted]
        keep = [
            i
            for i in range(len(curve.columns[0].values))
            if all(column.values[i] == wanted[column.name] for column in found)
        ]
        columns = tuple(
            replace(
                column,
                values=mono(tuple(None if column.name == "iso" else column.values[i] for i in keep)),
            )
            for column in curve.columns
        )
        curves.append(replace(curve, columns=columns))
    rows = tuple(
        replace(row, iso=None, channel="mono") for row in results.rows if row.iso == 55.0 and row.channel == "G1"
    )
    few = synthetic_pictures()
    pictures = Pictures(
        shading=tuple(mono_picture(one) for one in few.shading if one.iso == 55.0 and one.channel == "G1"),
        shading_differences=tuple(
            replace(one, iso=None, base_iso=None) for one in few.shading_differences[1:] if one.iso == 55.0
        ),
        responses=tuple(replace(one, iso=None, channel="mono") for one in few.responses if one.iso == 55.0),
    )
    page = report_html(replace(results, rows=rows, curves=tuple(curves)), pictures)
    assert "unknown ISO" in page
    assert "Lens shading at unknown ISO" in page


def mono_picture(picture):
    return replace(picture, iso=None, channel="mono", cos4=None, legacy=None)


def test_lens_shading_says_every_step(page):
    titles = (
        "The map of each plane",
        "The stacked map",
        "What every model says",
        "Does exposure or ISO change the map?",
        "The cosine-fourth law",
        "The published polynomial",
        "Profiles before and after correction",
    )
    places = [page.index(f'<h3 class="part">{title}</h3>') for title in titles]
    assert places == sorted(places)


def test_fixed_pattern_says_every_step(page):
    titles = "PRNU of each channel|Against ISO|Rows, columns, pixels|PRNU of each tile|Response of the pixels"
    for title in (*titles.split("|"), "Standard deviation against exposure"):
        assert f'<h3 class="part">{title}</h3>' in page


def test_constancy_is_told_in_words(page):
    assert "the same at every ISO, as far as the errors can tell" in page
    assert "in doubt" in page
    assert "not the same at every ISO" in page


def test_a_study_without_flats_and_darks_names_what_fixed_pattern_and_shading_need():
    page = report_html(Results(study={}, rows=(), findings=(), curves=()), None)
    assert "No lens shading: capture bursts of evenly lit flat frames below saturation." in page
    assert "No PRNU: capture" in page
    assert "No DSNU: capture bursts of dark frames." in page


def test_many_rows_are_left_to_the_tables():
    row = Row(
        quantity="read_noise", channel="G1", method="anova", measured=Measured.exact(1.0, "DN"), region="tile:0,0"
    )
    whole = replace(row, region=None)
    page = report_html(Results(study={}, rows=(*[row] * 4500, whole), findings=(), curves=()), None)
    assert "4500 rows stand only there" in page


def test_findings_of_one_kind_share_a_box():
    def at(iso):
        return Finding(
            code="saturation-not-reached", severity=Severity.WARNING, message=f"flats at ISO {iso} stay dark"
        )

    page = report_html(Results(study={}, rows=(), findings=(at(55), at(99)), curves=()), None)
    assert page.count('class="finding warning"') == 1
    assert "2 warnings" in page
    assert page.index("Flats at ISO 55") < page.index("Flats at ISO 99")


def test_each_threshold_of_a_figure_is_drawn_in_a_panel_of_its_own(results):
    rows = [row for row in results.rows if row.quantity == "dynamic_range"]
    rows += [replace(row, snr_threshold=10.0) for row in rows]
    page = report_html(Results(study={}, rows=tuple(rows), findings=(), curves=()), None)
    assert "Dynamic range of the sensor, SNR 1, Dynamic range of the sensor, SNR 10 against ISO" in page


def test_columns_of_numbers_are_sorted_by_their_numbers_and_not_by_their_words():
    measured = Measured.normal(2.0, 0.1, "DN")
    rows = [
        Row(
            quantity="dsnu",
            channel="R",
            method="dark-stack",
            measured=measured,
            n=n,
            exposure_s=seconds,
            source="METHOD 5",
        )
        for n, seconds in ((1_200_000, 0.02), (600_000, 1.0))
    ]
    page = report_html(Results(study={}, rows=tuple(rows), findings=(), curves=()), Pictures())
    cells = re.findall(r'<td data-sort="([^"]*)">([^<]*)</td>', page)
    assert ("1200000", "1\N{NARROW NO-BREAK SPACE}200\N{NARROW NO-BREAK SPACE}000") in cells
    assert {("0.02", "20 ms"), ("1.0", "1 s")} <= set(cells)
