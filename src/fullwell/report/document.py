"""The results document: everything a run found as one JSON text, the same for the same input to the last byte.

One row, finding and curve column stands on each line, so that two documents can be compared with any diff.
Numbers are written with the shortest digits that read back as the same float; what is not finite becomes null.
"""

import json
import math
from collections.abc import Mapping, Sequence
from enum import Enum
from pathlib import PurePath
from typing import Final, TypeAlias

import numpy as np

from fullwell import glossary
from fullwell.figures.results import Curve, Results, Row
from fullwell.files import RESULTS_SCHEMA
from fullwell.findings import Finding

EMVA_FOLDER: Final = "emva1288"
"""Folder of the result files of the reference package."""

_ENCODER: Final = json.JSONEncoder(ensure_ascii=False, allow_nan=False)

Plain: TypeAlias = "str | int | float | bool | list[Plain] | dict[str, Plain] | None"
"""What JSON can hold."""

ROW_KEYS: Final = (
    "quantity",
    "channel",
    "method",
    "value",
    "unit",
    "std_error",
    "dof",
    "ci95_low",
    "ci95_high",
    "n",
    "iso",
    "exposure_s",
    "temperature_c",
    "region",
    "snr_threshold",
    "flags",
    "source",
)


def results_json(results: Results) -> str:
    """Return the document of RESULTS section 2, ending with a newline.

    Raises
    ------
    TypeError
        Where ``study`` or ``run`` holds something JSON has no word for.

    """
    parts = (
        ("schema", json.dumps(RESULTS_SCHEMA)),
        ("study", _indented(plain(results.study))),
        ("results", _lines([row_record(row) for row in results.rows])),
        ("findings", _lines([_finding(finding) for finding in results.findings])),
        ("curves", _curves(results.curves)),
        ("citations", _lines([plain(citation) for citation in citations(results)])),
        ("run", _indented(plain(results.run))),
    )
    return "{\n" + ",\n".join(f"{json.dumps(name)}: {text}" for name, text in parts) + "\n}\n"


def row_record(row: Row) -> dict[str, Plain]:
    """Return one row with exactly the keys of `ROW_KEYS`, in that order."""
    measured = row.measured
    low, high = (None, None) if measured.ci95 is None else measured.ci95
    values: tuple[object, ...] = (
        row.quantity,
        row.channel,
        row.method,
        measured.value,
        measured.unit,
        measured.std_error,
        measured.dof,
        low,
        high,
        row.n,
        row.iso,
        row.exposure_s,
        row.temperature_c,
        row.region,
        row.snr_threshold,
        row.flags,
        row.source,
    )
    return {key: plain(value) for key, value in zip(ROW_KEYS, values, strict=True)}


def citations(results: Results) -> tuple[Mapping[str, str], ...]:
    """Return the bibliography of the results: their own where they bring one, else what their rows cite."""
    if results.citations:
        return results.citations
    cited = glossary.citations(row.source for row in results.rows)
    return tuple({"key": entry.key, "text": entry.text} for entry in cited)


def plain(value: object) -> Plain:  # noqa: PLR0911 - one return per kind of value reads best
    """Return a value as JSON can hold it: tuples as lists, enumerations and paths as text, NaN and infinity as null.

    Raises
    ------
    TypeError
        Where there is no such word.

    """
    if type(value) is float:  # most values are, and the questions below take their time
        return value if math.isfinite(value) else None
    if isinstance(value, Enum):
        return plain(value.value)
    if value is None or isinstance(value, (str, bool, int)):
        return value
    if isinstance(value, float):
        return float(value) if math.isfinite(value) else None
    if isinstance(value, np.generic):
        return plain(value.item())
    if isinstance(value, Mapping):
        return {str(key): plain(item) for key, item in value.items()}
    if isinstance(value, (Sequence, np.ndarray)):
        return [plain(item) for item in value]
    if isinstance(value, PurePath):
        return value.as_posix()
    message = f"results cannot hold a {type(value).__name__}: give text, numbers, lists or mappings"
    raise TypeError(message)


def _finding(finding: Finding) -> Plain:
    return {
        "code": finding.code,
        "severity": finding.severity.value,
        "message": finding.message,
        "files": list(finding.files),
    }


def _curves(curves: Sequence[Curve]) -> str:
    """Return the curves as ``{name: {column: {unit, values}}}``, one column a line."""
    if not curves:
        return "{}"
    return "{\n" + ",\n".join(f"{json.dumps(curve.name)}: {_columns(curve)}" for curve in curves) + "\n}"


def _columns(curve: Curve) -> str:
    lines = (
        f'{json.dumps(column.name)}: {{"unit": {_compact(column.unit)}, "values": {_values(column.values)}}}'
        for column in curve.columns
    )
    return "{\n" + ",\n".join(lines) + "\n}"


def _values(values: Sequence[object]) -> str:
    """Return a column as it is, which is quick, unless it holds what JSON has no word for."""
    try:
        return _compact(values)
    except (TypeError, ValueError):
        return _compact(plain(values))


def _lines(items: Sequence[Plain]) -> str:
    return "[\n" + ",\n".join(_compact(item) for item in items) + "\n]" if items else "[]"


def _compact(item: object) -> str:
    return _ENCODER.encode(item)


def _indented(item: Plain) -> str:
    return json.dumps(item, ensure_ascii=False, allow_nan=False, indent=1)
