"""Results side by side: read from their folders, compared, and written as a page, a document and a table."""

import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from string import ascii_uppercase
from typing import Final, cast

from fullwell.errors import UsageError
from fullwell.figures.results import Results, Row
from fullwell.figures.side_by_side import Comparison, Side, compare
from fullwell.files import RESULTS, foreign_in, holds_document, replaced_folder
from fullwell.glossary import RECOMMENDED
from fullwell.glossary.comparable import TRUTH
from fullwell.report.compare_document import DOCUMENT, SCHEMA, comparison_csv, comparison_json
from fullwell.report.compare_page import comparison_html
from fullwell.report.emva_xml_reading import read_reference_results
from fullwell.report.reading import read_results
from fullwell.units import Measured
from fullwell.workflow.simulation.simulate import SCHEMA as TRUTH_SCHEMA
from fullwell.workflow.simulation.simulate import TRUTH as TRUTH_FILE

_OWN: Final = frozenset({DOCUMENT, "compare.csv", "report.html"})
_Record = Mapping[str, object]


def compare_paths(paths: Sequence[Path], *, out: Path | None = None) -> Comparison:
    """Compare results and, where asked for, write what was found into a folder.

    Parameters
    ----------
    paths
        Result folders, results.json, truth.json of simulations, or result files of the package emva1288; two at
        least.
    out
        Folder to write: a missing or empty one, or one that holds an earlier comparison, which is replaced.

    Raises
    ------
    UsageError
        Where a path holds no results, or ``out`` must not be replaced.

    """
    if not 2 <= len(paths) <= len(ascii_uppercase):
        raise UsageError("Name two results to compare, or more: fullwell compare A B.")
    if out is not None:
        _require_replaceable(out)
    names = _names(paths)
    comparison = compare(
        [_side(path, label, name) for path, label, name in zip(paths, ascii_uppercase, names, strict=False)]
    )
    if out is not None:
        with replaced_folder(out) as folder:
            (folder / DOCUMENT).write_text(comparison_json(comparison), encoding="utf-8", newline="\n")
            (folder / "compare.csv").write_text(comparison_csv(comparison), encoding="utf-8", newline="\n")
            (folder / "report.html").write_text(comparison_html(comparison), encoding="utf-8", newline="\n")
    return comparison


def _side(path: Path, label: str, name: str) -> Side:
    if path.is_file() and path.suffix.lower() == ".xml":
        return Side(label=label, name=name, results=read_reference_results(path), source="emva1288")
    truth = path / TRUTH_FILE if path.is_dir() and not (path / RESULTS).exists() else path
    if truth.name == TRUTH_FILE and truth.is_file():
        return Side(label=label, name=name, results=_truth(truth), source=TRUTH)
    return Side(label=label, name=name, results=read_results(path))


def _names(paths: Sequence[Path]) -> list[str]:
    """Return the last part of each path, more of it where two would be called the same."""
    parts = [path.resolve().parts for path in paths]
    return ["/".join(part[-_depth(part, parts) :]) for part in parts]


def _depth(part: tuple[str, ...], parts: Sequence[tuple[str, ...]]) -> int:
    clashes = [other for other in parts if other != part]
    return next(
        (depth for depth in range(1, len(part)) if all(other[-depth:] != part[-depth:] for other in clashes)), 1
    )


def _truth(path: Path) -> Results:
    """Return the true values of a simulation as rows without an error."""
    wrong = UsageError(f"{path} is no truth document of Fullwell's ({TRUTH_SCHEMA}).")
    try:
        document = cast("_Record", json.loads(path.read_text(encoding="utf-8")))
        if document["schema"] != TRUTH_SCHEMA:
            raise wrong
        rows = [_true_row(record) for record in cast("Sequence[_Record]", document["truth"])]
        camera = cast("_Record", document["camera"])
    except (OSError, ValueError, KeyError, TypeError) as error:
        raise wrong from error
    return Results(study={"camera": {"name": camera.get("name")}}, rows=tuple(rows), findings=(), curves=())


def _true_row(record: _Record) -> Row:
    value, unit = float(cast("float", record["value"])), str(record["unit"])
    return Row(
        quantity=str(record["quantity"]),
        channel=str(record["channel"]),
        method=TRUTH,
        measured=Measured(value=value, unit=unit, std_error=0.0),
        iso=cast("float | None", record["iso"]),
        exposure_s=cast("float | None", record.get("exposure_s")),
        snr_threshold=cast("float | None", record["snr_threshold"]),
        flags=(RECOMMENDED,),
    )


def _require_replaceable(out: Path) -> None:
    target = out.resolve()
    if target.exists() and not target.is_dir():
        raise UsageError(f"{out} is a file; name a folder for the comparison with -o.")
    if not target.is_dir() or not any(target.iterdir()):
        return
    if foreign_in(target, _OWN) or not holds_document(target, DOCUMENT, schema=SCHEMA):
        raise UsageError(
            f"{out} holds something other than a comparison of Fullwell's and is left untouched; "
            "name a new or empty folder with -o."
        )
