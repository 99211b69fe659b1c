"""A comparison as a document and as a table."""

import csv
import io
import json
from typing import Final, cast

from fullwell import glossary
from fullwell.figures.differences import Difference
from fullwell.figures.emva_against_chart import Line, Told
from fullwell.figures.matching import Crossing, Match
from fullwell.figures.results import Row
from fullwell.figures.side_by_side import Comparison, Side, TenFigures
from fullwell.report.document import Plain, plain, row_record
from fullwell.units import Measured

SCHEMA: Final = "fullwell-compare/1"
DOCUMENT: Final = "compare.json"

_CONDITIONS: Final = (
    "quantity",
    "channel",
    "method",
    "unit",
    "iso",
    "exposure_s",
    "temperature_c",
    "region",
    "snr_threshold",
)


def comparison_json(comparison: Comparison) -> str:
    """Return the whole comparison as one JSON text."""
    document = {
        "schema": SCHEMA,
        "sides": [_side(side) for side in comparison.sides],
        "matches": [_match(match, comparison) for match in comparison.matches],
        "across_methods": [_crossing(crossing, comparison) for crossing in comparison.crossings],
        "emva_against_chart": [_ten(ten) for ten in comparison.tens],
        "definitions": _definitions(comparison),
        "findings": [
            {"code": one.code, "severity": one.severity, "message": one.message, "files": one.files}
            for one in comparison.findings
        ],
    }
    return json.dumps(plain(document), indent=1, ensure_ascii=False, allow_nan=False) + "\n"


def comparison_csv(comparison: Comparison) -> str:
    """Return the figures by the same method, one line a figure, with values, errors and differences of every side."""
    text = io.StringIO()
    table = csv.writer(text, lineterminator="\n")
    labels = [side.label for side in comparison.sides]
    head: list[str] = [*_CONDITIONS]
    for label in labels:
        head += [f"value_{label}", f"std_error_{label}"]
    for label in labels[1:]:
        head += [f"difference_{label}", f"difference_std_error_{label}", f"statistic_{label}", f"p_value_{label}"]
    table.writerow(head)
    for match in comparison.matches:
        record = row_record(match.reference)
        cells: list[object] = [record[key] for key in _CONDITIONS]
        for row in match.rows:
            cells += [None, None] if row is None else [row.measured.value, row.measured.std_error]
        for one in match.differences[1:]:
            cells += _cells(one)
        table.writerow(["" if cell is None else cell for cell in cells])
    return text.getvalue()


def _cells(one: Difference | None) -> list[object]:
    if one is None:
        return [None] * 4
    return [one.measured.value, one.measured.std_error, one.statistic, one.p_value]


def _side(side: Side) -> Plain:
    run = side.results.run
    return plain(
        {
            "label": side.label,
            "name": side.name,
            "source": side.source,
            "camera": side.camera or None,
            "bodies": side.bodies,
            "simulated": side.simulated,
            "emva_profile": side.emva,
            "chart": side.chart,
            "isos": side.isos,
            "version": run.get("version"),
            "time": run.get("time"),
        }
    )


def _match(match: Match, comparison: Comparison) -> Plain:
    record = row_record(match.reference)
    labels = [side.label for side in comparison.sides]
    return plain(
        {
            **{key: record[key] for key in _CONDITIONS},
            "values": {label: _figure(row) for label, row in zip(labels, match.rows, strict=True)},
            "differences": {
                label: _difference(one) for label, one in zip(labels, match.differences, strict=True) if one is not None
            },
        }
    )


def _figure(row: Row | None) -> Plain:
    return None if row is None else plain({**_measured(row.measured), "flags": row.flags})


def _measured(measured: Measured) -> dict[str, object]:
    low, high = (None, None) if measured.ci95 is None else measured.ci95
    return {
        "value": measured.value,
        "std_error": measured.std_error,
        "dof": measured.dof,
        "ci95_low": low,
        "ci95_high": high,
    }


def _difference(one: Difference | None) -> Plain:
    if one is None:
        return None
    return plain({**_measured(one.measured), "ratio": one.ratio, "statistic": one.statistic, "p_value": one.p_value})


def _crossing(crossing: Crossing, comparison: Comparison) -> Plain:
    sides = comparison.sides
    return plain(
        {
            "figures": {
                sides[at].label: row_record(row)
                for at, row in zip((crossing.first, crossing.second), crossing.rows, strict=True)
            },
            "difference": _difference(crossing.difference),
            "comparable": crossing.verdict.kinship,
            "reason": crossing.verdict.reason,
        }
    )


def _ten(ten: TenFigures) -> Plain:
    return plain(
        {
            "emva": ten.emva,
            "chart": ten.chart,
            "profile": ten.profile,
            "channel": ten.channel,
            "iso": ten.iso,
            "figures": [_line(line) for line in ten.lines],
        }
    )


def _line(line: Line) -> Plain:
    return plain(
        {
            "figure": line.title,
            "unit": line.unit,
            "emva": _told(line.emva),
            "chart": _told(line.chart),
            "difference": _difference(line.difference),
            "note": line.note or None,
        }
    )


def _told(told: Told) -> Plain:
    measured = {} if told.measured is None else _measured(told.measured)
    return plain({"definition": told.definition, **measured, "flags": told.flags, "reason": told.reason or None})


def _definitions(comparison: Comparison) -> Plain:
    names = dict.fromkeys(match.reference.quantity for match in comparison.matches)
    names |= dict.fromkeys(crossing.rows[0].quantity for crossing in comparison.crossings)
    entries = {name: glossary.quantity(name) for name in names}
    return cast(
        "Plain",
        {
            name: {"title": one.title, "symbol": one.symbol, "definition": one.definition, "equation": one.equation}
            for name, one in entries.items()
            if one is not None
        },
    )
