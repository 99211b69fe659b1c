"""results.json is the contract: exact keys, the same bytes twice, no number that JSON does not know."""

import csv
import json
import math
from dataclasses import replace
from enum import Enum

import pyarrow.parquet as pq
import pytest
from hypothesis import given
from hypothesis import strategies as st
from synthetic_results import synthetic_results

from fullwell.figures.results import Column, Curve, Results, Row
from fullwell.report.document import ROW_KEYS, plain, results_json
from fullwell.report.tables import rows_csv, write_parquet
from fullwell.units import Measured

CONTRACT = (
    "quantity, channel, method, value, unit, std_error, dof, ci95_low, ci95_high, n, iso, exposure_s, temperature_c, "
    "region, snr_threshold, flags, source"
)
EMPTY = Results(study={}, rows=(), findings=(), curves=())


def row(measured: Measured) -> Row:
    return Row(quantity="read_noise", channel="G1", method="temporal-variance", measured=measured, source="METHOD 3.1")


def refuse(constant: str) -> float:
    pytest.fail(f"{constant} is not JSON")


def test_top_level_keys_and_schema(results):
    document = json.loads(results_json(results))
    assert list(document) == ["schema", "study", "results", "findings", "curves", "citations", "run"]
    assert document["schema"] == "fullwell-results/1"


def test_rows_have_exactly_the_keys_of_the_contract_in_order(results):
    document = json.loads(results_json(results))
    assert len(document["results"]) == len(results.rows)
    assert all(list(one) == CONTRACT.split(", ") for one in document["results"])


def test_findings_and_curves(results):
    document = json.loads(results_json(results))
    assert document["findings"][0] == {
        "code": "file-truncated",
        "severity": "error",
        "message": results.findings[0].message,
        "files": ["PRNU_DSNU/ISO_99/IMG_7.dng"],
    }
    for curve in results.curves:
        columns = document["curves"][curve.name]
        assert list(columns) == [column.name for column in curve.columns]
        assert all(columns[column.name]["unit"] == column.unit for column in curve.columns)
        assert all(columns[column.name]["values"] == list(column.values) for column in curve.columns)


def test_two_documents_of_the_same_input_are_the_same_bytes_but_for_run():
    first = synthetic_results()
    second = replace(synthetic_results(), run={"time": "later", "host": "another"})
    one, two = (results_json(results) for results in (first, second))
    assert one != two
    assert one[: one.index('\n"run"')] == two[: two.index('\n"run"')]


def test_every_part_empty_is_still_a_document():
    text = results_json(EMPTY)
    assert text.endswith("}\n")
    assert json.loads(text)["results"] == []


def test_what_is_not_finite_becomes_null_everywhere():
    curve = Curve(name="c", columns=(Column(name="x", unit="1", values=(math.nan, 1.0, None, -math.inf)),))
    measured = Measured(value=math.nan, unit="DN", std_error=math.inf, ci95=(-math.inf, 2.0))
    results = Results(
        study={"a": {"b": [math.nan]}}, rows=(row(measured),), findings=(), curves=(curve,), run={"s": math.inf}
    )
    document = json.loads(results_json(results), parse_constant=refuse)
    written = document["results"][0]
    assert (written["value"], written["std_error"], written["ci95_low"], written["ci95_high"]) == (
        None,
        None,
        None,
        2.0,
    )
    assert document["curves"]["c"]["x"]["values"] == [None, 1.0, None, None]
    assert document["study"] == {"a": {"b": [None]}}
    assert document["run"] == {"s": None}


@given(st.floats(allow_nan=False, allow_infinity=False))
def test_floats_survive_the_document_bit_for_bit(value):
    results = replace(EMPTY, rows=(row(Measured.exact(value, "DN")),))
    read = json.loads(results_json(results))["results"][0]["value"]
    assert math.copysign(1.0, read) == math.copysign(1.0, value)
    assert read == value


def test_citations_follow_from_the_rows(results):
    assert [one["key"] for one in json.loads(results_json(results))["citations"]] == ["METHOD"]


def test_what_json_has_no_word_for_is_refused():
    with pytest.raises(TypeError, match="cannot hold a object"):
        plain({"a": object()})


def test_enumerations_are_written_by_value():
    assert plain(Enum("Kind", {"FLAT": "flat"}).FLAT) == "flat"


def typed(text: str, key: str) -> object:
    if key == "flags":
        return text.split(";") if text else []
    if text == "":
        return "" if key == "source" else None
    if key == "n":
        return int(text)
    return text if key in ("quantity", "channel", "method", "unit", "region", "source") else float(text)


def test_csv_and_parquet_hold_the_same_rows_as_the_document(results, tmp_path):
    wanted = json.loads(results_json(results))["results"]
    reader = csv.reader(rows_csv(results.rows).splitlines())
    head = next(reader)
    assert tuple(head) == ROW_KEYS
    assert [{key: typed(text, key) for key, text in zip(head, line, strict=True)} for line in reader] == wanted
    write_parquet(results.rows, tmp_path / "rows.parquet")
    table = pq.read_table(tmp_path / "rows.parquet")
    assert table.to_pylist() == wanted
    assert str(table.schema.field("flags").type).startswith("list<")
    assert str(table.schema.field("n").type) == "int64"


def test_tables_of_no_rows_still_name_their_columns(tmp_path):
    assert rows_csv(()).splitlines() == [",".join(ROW_KEYS)]
    write_parquet((), tmp_path / "rows.parquet")
    assert pq.read_table(tmp_path / "rows.parquet").column_names == list(ROW_KEYS)
