"""The results document read back: what `document` wrote becomes `Results` again."""

import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import cast

from fullwell.errors import UsageError
from fullwell.figures.results import Column, Curve, Results, Row
from fullwell.files import RESULTS, RESULTS_SCHEMA
from fullwell.findings import Finding, Severity
from fullwell.units import Measured

_Record = Mapping[str, object]


def read_results(path: Path) -> Results:
    """Return the results of a document; rows without a value are left out.

    Parameters
    ----------
    path
        results.json, or the folder that holds it.

    Raises
    ------
    UsageError
        Where it is not there, or is no results document of ours.

    """
    return read_document(path)[1]


def read_document(path: Path) -> tuple[Mapping[str, object], Results]:
    """Return a document as JSON has it, and the results it holds; arguments and errors as `read_results`."""
    if not path.exists():
        raise UsageError(f"{path} does not exist.")
    if path.is_dir():
        if not (path / RESULTS).is_file():
            raise UsageError(f"{path} holds no {RESULTS}; name the folder that `fullwell characterize` wrote.")
        path = path / RESULTS
    try:
        document: object = json.loads(path.read_text(encoding="utf-8"))
        return cast("_Record", document), results_of(document)
    except (OSError, ValueError, RecursionError) as error:
        raise UsageError(f"{path} is no results document of Fullwell's ({RESULTS_SCHEMA}).") from error


def results_of(document: object) -> Results:
    """Return the results of a document as JSON has it; rows without a value are left out.

    Raises
    ------
    ValueError
        Where it is something else.

    """
    if not isinstance(document, dict) or cast("_Record", document).get("schema") != RESULTS_SCHEMA:
        raise ValueError(f"no results document of Fullwell's ({RESULTS_SCHEMA})")
    try:
        return _results(cast("_Record", document))
    except (AttributeError, KeyError, TypeError) as error:
        raise ValueError(f"no results document of Fullwell's ({RESULTS_SCHEMA})") from error


def _results(document: _Record) -> Results:
    records = cast("Sequence[_Record]", document["results"])
    findings = cast("Sequence[_Record]", document.get("findings") or ())
    curves = cast("Mapping[str, Mapping[str, _Record]]", document.get("curves") or {})
    return Results(
        study=cast("_Record", document.get("study") or {}),
        rows=tuple(_row(record) for record in records if record["value"] is not None),
        findings=tuple(_finding(record) for record in findings),
        curves=tuple(_curve(name, columns) for name, columns in curves.items()),
        run=cast("_Record", document.get("run") or {}),
    )


def _row(record: _Record) -> Row:
    low, high = _number(record["ci95_low"]), _number(record["ci95_high"])
    return Row(
        quantity=str(record["quantity"]),
        channel=str(record["channel"]),
        method=str(record["method"]),
        measured=Measured(
            value=float(cast("float", record["value"])),
            unit=str(record["unit"]),
            std_error=_number(record["std_error"]),
            dof=_number(record["dof"]),
            ci95=None if low is None or high is None else (low, high),
        ),
        n=cast("int | None", record["n"]),
        iso=_number(record["iso"]),
        exposure_s=_number(record["exposure_s"]),
        temperature_c=_number(record["temperature_c"]),
        region=cast("str | None", record["region"]),
        snr_threshold=_number(record["snr_threshold"]),
        flags=tuple(str(flag) for flag in cast("Sequence[object]", record["flags"])),
        source=str(record["source"]),
    )


def _number(value: object) -> float | None:
    return None if value is None else float(cast("float", value))


def _finding(record: _Record) -> Finding:
    return Finding(
        code=str(record["code"]),
        severity=Severity(str(record["severity"])),
        message=str(record["message"]),
        files=tuple(str(name) for name in cast("Sequence[object]", record["files"])),
    )


def _curve(name: str, columns: Mapping[str, _Record]) -> Curve:
    return Curve(
        name=name,
        columns=tuple(
            Column(
                name=column,
                unit=str(record["unit"]),
                values=tuple(cast("Sequence[float | int | str | None]", record["values"])),
            )
            for column, record in columns.items()
        ),
    )
