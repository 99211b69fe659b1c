"""The results folder: written beside its target and renamed into place, or not at all."""

import json
import os
import tempfile
from pathlib import Path
from typing import Final, cast

from fullwell.errors import UsageError
from fullwell.figures.results import Results
from fullwell.report.document import SCHEMA, results_json
from fullwell.report.html import report_html
from fullwell.report.pictures import Pictures
from fullwell.report.tables import rows_csv, write_parquet

DOCUMENT: Final = "results.json"


def check_target(out: Path) -> None:
    """Say before the work starts whether its results could be written to ``out``.

    Raises
    ------
    UsageError
        Where ``out`` is a file, a folder with something else in it than our own results, or cannot be written.

    """
    target = out.resolve()
    if target.exists() and not target.is_dir():
        message = f"{out} is a file; name a folder for the results with -o"
        raise UsageError(message)
    if target.is_dir() and any(target.iterdir()) and not _holds_results(target):
        message = (
            f"{out} holds something other than Fullwell's results and is left untouched; "
            "name a new or empty folder with -o"
        )
        raise UsageError(message)
    ancestor = next(folder for folder in target.parents if folder.exists())
    if not ancestor.is_dir() or not os.access(ancestor, os.W_OK | os.X_OK):
        message = f"{out} cannot be written: no permission to write in {ancestor}; choose another folder with -o"
        raise UsageError(message)


def write_results(results: Results, out: Path, *, pictures: Pictures | None = None) -> None:
    """Write results.json, results.csv, results.parquet and report.html into ``out``.

    Everything is written into a folder beside ``out`` first and renamed into place at the end; an error or an
    interruption at any moment leaves what was at ``out`` before.

    Parameters
    ----------
    results
        Everything the run found.
    out
        A missing or empty folder, or one that holds our own results: it is replaced.
    pictures
        Arrays the report shows as pictures.

    Raises
    ------
    UsageError
        As `check_target`.

    """
    check_target(out)
    target = out.resolve()
    target.parent.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(
        prefix=f".{target.name}-", suffix=".partial", dir=target.parent, ignore_cleanup_errors=True
    ) as workshop:
        fresh = Path(workshop) / "fresh"
        fresh.mkdir()
        _fill(fresh, results, pictures)
        _replace(target, fresh, aside=Path(workshop) / "former")


def _fill(folder: Path, results: Results, pictures: Pictures | None) -> None:
    (folder / DOCUMENT).write_text(results_json(results), encoding="utf-8", newline="\n")
    (folder / "results.csv").write_text(rows_csv(results.rows), encoding="utf-8", newline="\n")
    write_parquet(results.rows, folder / "results.parquet")
    (folder / "report.html").write_text(report_html(results, pictures), encoding="utf-8", newline="\n")


def _replace(target: Path, fresh: Path, *, aside: Path) -> None:
    """Put ``fresh`` in the place of ``target``; what was there goes ``aside``, and comes back if that fails."""
    if not target.exists():
        fresh.rename(target)
        return
    try:
        target.rename(aside)
        fresh.rename(target)
    except BaseException:
        if aside.exists() and not target.exists():
            aside.rename(target)
        raise


def _holds_results(folder: Path) -> bool:
    """Tell whether a folder holds a results document of ours."""
    try:
        document: object = json.loads((folder / DOCUMENT).read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return False
    return isinstance(document, dict) and cast("dict[str, object]", document).get("schema") == SCHEMA
