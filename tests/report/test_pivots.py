"""Small tables: a line per ISO, a column per channel, flags explained below."""

from dataclasses import replace

from fullwell.figures.results import Row
from fullwell.report.pivots import pivot
from fullwell.units import Measured

BASE = Row(
    quantity="dynamic_range",
    channel="R",
    method="noise-model",
    measured=Measured.normal(60.0, 0.01, "dB"),
    iso=100.0,
    snr_threshold=1.0,
    flags=("recommended",),
    source="METHOD 7",
)


def test_lines_ascend_and_channels_stand_in_cfa_order():
    rows = [replace(BASE, channel=channel, iso=iso) for iso in (800.0, 100.0) for channel in ("B", "all", "G1", "R")]
    table = pivot(rows, "dynamic_range", "dB")
    assert table is not None
    assert table.channels == ("R", "G1", "B", "all")
    assert [line.label for line in table.lines] == ["ISO 100", "ISO 800"]


def test_thresholds_are_named_only_where_they_differ():
    table = pivot([BASE, replace(BASE, snr_threshold=10.0)], "dynamic_range", "dB")
    assert table is not None
    assert [line.label for line in table.lines] == ["ISO 100, SNR 1", "ISO 100, SNR 10"]


def test_a_row_without_iso_belongs_to_all_only_where_another_knows_its_iso():
    fit = replace(BASE, quantity="read_noise_pre", iso=None)
    for rows, label in (([BASE, fit], "all ISOs"), ([fit], "unknown ISO")):
        table = pivot(rows, "read_noise_pre", "dB")
        assert table is not None
        assert [line.label for line in table.lines] == [label]


def test_flags_become_marks_that_are_explained():
    flagged = replace(BASE, flags=("adc-limited", "lower-bound", "recommended"))
    table = pivot([flagged, replace(BASE, channel="B")], "dynamic_range", "dB")
    assert table is not None
    assert [cell.marks for cell in table.lines[0].cells] == ["a b", ""]
    assert [note.text.partition(":")[0] for note in table.notes] == ["adc-limited", "lower-bound"]


def test_a_quantity_nobody_measured_has_no_table():
    assert pivot([BASE], "dsnu", "DN") is None
