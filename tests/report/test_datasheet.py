import itertools
import re
import subprocess
import xml.etree.ElementTree as ET
from dataclasses import replace

import pytest
from synthetic_emva import CAMPAIGN, CORRECTED, METHOD, PACKAGE, synthetic_campaign

from fullwell.report.datasheet.build import build_datasheet
from fullwell.report.datasheet.graphs import Curves
from fullwell.report.datasheet.items import TEMPLATE, fixed, item_groups
from fullwell.report.datasheet.missing import missing_items
from fullwell.report.datasheet.pdf import datasheet_pdf
from fullwell.report.datasheet.tables import MOST_LINES, data_tables, thinned_places
from fullwell.report.emva_section import emva_section
from fullwell.report.emva_xml import reference_files
from fullwell.report.emva_xml_reading import read_reference_results
from fullwell.report.html import report_html
from fullwell.report.numbers import show
from fullwell.report.pivots import title_of
from fullwell.units import Measured


@pytest.fixture(scope="session")
def campaign():
    """Return two operation points of a monochrome camera."""
    return synthetic_campaign(isos=(100.0, 200.0))


@pytest.fixture(scope="session")
def sheet(campaign):
    return build_datasheet(campaign)


@pytest.fixture(scope="session")
def pdf(sheet):
    return datasheet_pdf(sheet)


def text_of(pdf, tmp_path):
    path = tmp_path / "sheet.pdf"
    path.write_bytes(pdf)
    try:
        found = subprocess.run(["pdftotext", "-layout", path, "-"], capture_output=True, text=True, check=True)
    except FileNotFoundError:
        pytest.skip("needs pdftotext to read the PDF")
    return found.stdout


def rows_at(results, iso=100.0, method=METHOD):
    return [row for row in results.rows if row.method == method and row.iso == iso]


def test_a_summary_has_the_template_s_order_and_decimals(sheet):
    lines = [line for group in sheet.points[0].channels[0].groups for line in group.lines]
    assert [(line.symbol, line.value, line.unit) for line in lines[:10]] == [
        ("η", "60.0", "%"),
        ("K", "0.400", "DN/e⁻"),
        ("1/K", "2.50", "e⁻/DN"),
        ("σ_{d}", "2.4", "e⁻"),
        ("σ_{y.dark}", "0.96", "DN"),
        ("SNR_{max}", "100", ""),
        ("SNR_{max}", "40.0", "dB"),
        ("1/SNR_{max}", "1.00", "%"),
        ("μ_{e.min}", "3.1", "e⁻"),
        ("μ_{e.min.area}", "0.26", "e⁻/µm²"),
    ]
    assert [line.symbol for line in lines[-3:]] == ["LE", "μ_{c.mean}", "μ_{c.var}"]
    assert [group.title for group in sheet.points[0].channels[0].groups] == [group.title for group in TEMPLATE]
    assert (lines[1].error, lines[-1].value, lines[-1].error) == ("0.00080", "−0.3", "1.1")


def test_a_negative_variance_is_a_limit_with_a_note_never_nan(sheet):
    channel = sheet.points[0].channels[0]
    row = next(line for group in channel.groups for line in group.lines if line.symbol == "DSNU_{1288.row}")
    assert row.value.startswith("< ")
    assert any(mark == row.note and "upper" in text for mark, text in channel.notes)
    assert "nan" not in str(sheet.points[0].channels).lower()


def test_all_figures_say_what_is_only_a_bound_as_the_report_does(campaign):
    full = Measured.exact(8300.0, "e-")
    bounded = [
        replace(row, measured=full, flags=(*row.flags, "lower-bound"))
        if (row.quantity, row.measured.unit) == ("saturation_capacity", "e-")
        else row
        for row in campaign.rows
    ]
    figures = build_datasheet(replace(campaign, rows=tuple(bounded))).points[0].channels[0].figures
    values = {(line.title, line.unit, line.method): line.value for line in figures}
    assert values["Saturation capacity", "e⁻", ""] == show(full, ("lower-bound",)) == "≥ 8300"
    below = next(row for row in rows_at(campaign) if row.quantity == "dsnu_row")
    assert values[title_of("dsnu_row"), "e⁻", ""] == show(below.measured, below.flags)
    assert values[title_of("dsnu_row"), "e⁻", ""].startswith("≤ ")


def test_the_corrected_figures_stand_beside_not_among_the_standard_s(campaign, sheet):
    channel = sheet.points[0].channels[0]
    by_hand = item_groups(TEMPLATE, rows_at(campaign), {})
    assert [line.value for group in channel.groups for line in group.lines] == [
        line.value for group in by_hand for line in group.lines
    ]
    corrected = next(row for row in campaign.rows if row.method == CORRECTED and row.quantity == "dsnu")
    assert channel.beside[0].lines[0].value == fixed(corrected.measured.value, 1)


def test_numbers_that_round_to_zero_have_no_minus():
    assert (fixed(-0.004, 2), fixed(-0.006, 2), fixed(12.0, 0)) == ("0.00", "−0.01", "12")


def test_what_is_missing_is_named_with_its_reason():
    results = synthetic_campaign(photons_known=False, campaign={})
    rows = [row for row in rows_at(results) if not row.quantity.startswith(("dsnu", "prnu"))]
    points = [("ISO 100", Curves(curves=results.curves, profile=METHOD, iso=100.0, temperature_c=None))]
    missing = {one.item: one.reason for one in missing_items(results, rows, points)}
    assert set(missing) == {
        "Quantum efficiency",
        "Responsivity",
        "DSNU",
        "PRNU",
        "Dark current from the mean",
        "Dark current from the variance",
        "Date of the measurement",
        "Type of data presented",
        "Wavelength of the light",
        "Spectral width of the light",
        "Non-uniformity of the light ΔE",
        "Irradiance calibration accuracy",
    }
    assert all(missing.values())
    assert "irradiance" in missing["Quantum efficiency"]


def test_a_whole_campaign_misses_nothing(campaign, sheet):
    assert sheet.missing == ()
    short = replace(
        campaign,
        curves=tuple(
            replace(curve, columns=tuple(replace(one, values=one.values[:40]) for one in curve.columns))
            if curve.name == "emva_sweep"
            else curve
            for curve in campaign.curves
        ),
    )
    points = [("ISO 100", Curves(curves=short.curves, profile=METHOD, iso=100.0, temperature_c=None))]
    found = missing_items(short, [row for row in short.rows if row.method == METHOD], points)
    assert [one.item for one in found] == ["ISO 100: exposure steps"]


def test_every_graph_of_the_standard_stands_there_with_its_data(sheet):
    names = [graph.name for graph in sheet.points[0].graphs]
    assert names[:9] == [
        "characteristic",
        "dark-mean",
        "stability",
        "photon-transfer",
        "snr",
        "linearity",
        "deviation",
        "dark-current-mean",
        "dark-current-variance",
    ]
    assert len(names) == len(set(names)) == 9 + 4 + 4 + 2 + 2
    for point in sheet.points:
        for graph in point.graphs:
            assert graph.drawing.startswith(b"<?xml")
            assert graph.tables[0].lines
            assert {len(line) for table in graph.tables for line in table.lines} == {len(graph.tables[0].head)}


def test_long_tables_are_thinned_evenly_and_say_so(campaign):
    assert thinned_places(5, 3) == [0, 2, 4]
    places = thinned_places(1000)
    assert (len(places), places[0], places[-1]) == (MOST_LINES, 0, 999)
    assert {b - a for a, b in itertools.pairwise(places)} <= {16, 17}
    profile = Curves(curves=campaign.curves, profile=METHOD, iso=100.0, temperature_c=None).table("emva_profile_dsnu")
    table = data_tables(profile, [("index", "index", ""), ("mean", "mean", "DN")])[0]
    assert (len(table.lines), table.total) == (MOST_LINES, 640 + 480)


def test_two_operation_points_have_a_summary_page_each(pdf, tmp_path):
    text = text_of(pdf, tmp_path)
    pages = text.split("\f")
    assert len([page for page in pages if "Quantum efficiency" in page and "Photon" not in page]) >= 2
    assert re.search(r"page 2 of \d+", text)
    assert "evaluated with profile emva1288-4.0-linear" in text
    assert "RC 2021-03-15" in text
    assert "does not claim" in text
    assert "ISO 200: Spectrogram PRNU, vertical" in text


def test_hostile_names_are_text_not_markup(pdf, tmp_path):
    text = text_of(pdf, tmp_path)
    for name in ("C-1 *beta* #1", "S$42_<7>", "Example Lab @ home"):
        assert name in text
    hostile = {**CAMPAIGN, "vendor": '#import "x" $', "model": "]] ``` </script><b>", "company": "// = \\ @ref"}
    results = synthetic_campaign(campaign=hostile)
    sheet = replace(build_datasheet(results), points=())
    assert '#import "x" $ ]] ``` </script><b>' in text_of(datasheet_pdf(sheet), tmp_path)


def test_the_same_results_give_the_same_bytes(campaign, sheet, pdf):
    assert datasheet_pdf(sheet) == pdf
    again = build_datasheet(replace(campaign, run={"time": "2030-01-01T00:00:00+00:00", "host": "another"}))
    assert again == sheet


def test_the_page_shows_the_same_chapter(campaign, sheet):
    section = emva_section(sheet)
    assert [part.title for part in section.parts[:3]] == ["Summary, ISO 100", "Summary, ISO 200", "General"]
    page = report_html(campaign, None, datasheet=sheet)
    assert 'id="emva-1288"' in page
    assert "σ_y.dark" in page
    assert page.count("Spectrogram DSNU, horizontal, ISO 200") >= 1


def test_the_page_tells_once_what_a_flag_means_that_stands_beside_others(campaign):
    of_few = {"system_gain": ("model-misfit",), "saturation_capacity": ("lower-bound", "model-misfit")}
    rows = tuple(replace(row, flags=(*row.flags, *of_few.get(row.quantity, ()))) for row in campaign.rows)
    section = emva_section(build_datasheet(replace(campaign, rows=rows)))
    note = section.parts[0].tables[0].note
    assert note.count("model-misfit: ") == note.count("lower-bound: ") == 1


def test_results_without_a_profile_have_no_datasheet(results):
    assert build_datasheet(results) is None


def test_the_package_s_file_holds_its_items_and_ours_apart(campaign, tmp_path):
    files = dict(reference_files(campaign))
    assert set(files) == {"mono_iso100.xml", "mono_iso200.xml"}
    root = ET.fromstring(files["mono_iso100.xml"])  # noqa: S314 - our own
    assert root.tag == "results"
    assert [section.tag for section in root][-1] == "toolkit"
    item = root.find("sensitivity/K")
    assert {field.tag: field.text for field in item} == {
        "section": "sensitivity",
        "short": "System gain",
        "symbol": "K",
        "unit": "$DN/e^-$",
        "latexname": "K",
        "value": "0.4",
    }
    assert root.findtext("spatial/DSNU1288_row/value") == "nan"
    assert float(root.findtext("toolkit/K_uncertainty/value")) == pytest.approx(8e-4)
    assert float(root.findtext("toolkit/linearity_error_percent/value")) == 0.14
    data = root.find("defect_pixel/histogram_DSNU/data")
    assert len(data.findtext("bins").split()) == len(data.findtext("values").split()) == 200
    for section in root:
        for entry in section:
            value = entry.findtext("value")
            assert value in {None, "None"} or isinstance(float(value), float)
    path = tmp_path / "result.xml"
    path.write_text(files["mono_iso100.xml"], encoding="utf-8")
    rows = read_reference_results(path).rows
    assert {row.method for row in rows} == {METHOD}
    assert next(row.measured for row in rows if row.quantity == "system_gain") == Measured.exact(0.4, "DN/e-")


def test_the_package_s_file_keeps_limits_with_their_values(campaign):
    floor = Measured.interval(0.49, None, (0.0, 0.49), "DN")
    full = Measured.exact(8300.0, "e-")
    bounds = {("dark_noise", "DN"): (floor, "upper-limit"), ("saturation_capacity", "e-"): (full, "lower-bound")}
    rows = []
    for row in campaign.rows:
        measured, *flags = bounds.get((row.quantity, row.measured.unit), (row.measured,))
        rows.append(replace(row, measured=measured, flags=(*row.flags, *flags)))
    files = dict(reference_files(replace(campaign, rows=tuple(rows))))
    root = ET.fromstring(files["mono_iso100.xml"])  # noqa: S314 - our own
    assert float(root.findtext("sensitivity/sigma_y_dark/value")) == 0.49  # EMVA 1288: noise below it is set to it
    assert float(root.findtext("toolkit/sigma_y_dark_upper_limit/value")) == 0.49
    assert float(root.findtext("sensitivity/u_e_sat/value")) == 8300.0
    assert float(root.findtext("toolkit/u_e_sat_lower_bound/value")) == 8300.0
    below = next(row for row in rows_at(campaign) if row.quantity == "dsnu_row")
    assert root.findtext("spatial/DSNU1288_row/value") == "nan"
    assert float(root.findtext("toolkit/DSNU1288_row_upper_limit/value")) == below.measured.ci95[1]
    assert root.find("toolkit/DSNU1288_row_uncertainty") is None


def test_the_package_s_profile_has_a_sheet_of_its_own():
    results = synthetic_campaign(method=PACKAGE)
    groups = item_groups(TEMPLATE, rows_at(results, method=PACKAGE), {})
    assert groups[0].lines[0].value == "60.0"
    assert all(row.method == PACKAGE for row in results.rows)
