"""The results folder: whose it may take the place of, and the files in it that every verb writes."""

import os
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import TYPE_CHECKING, Final

from fullwell.errors import UsageError
from fullwell.figures.results import Results
from fullwell.files import RESULTS, RESULTS_SCHEMA, foreign_in, holds_document
from fullwell.findings import listed
from fullwell.report.document import EMVA_FOLDER, results_json

if TYPE_CHECKING:
    from fullwell.report.datasheet.contents import Datasheet
    from fullwell.report.pictures import Pictures

OWN: Final = frozenset(
    {
        RESULTS,
        "results.csv",
        "results.parquet",
        "report.html",
        "report.pdf",
        "tables",
        "maps",
        "demo.json",
        EMVA_FOLDER,
        "loop.json",
        "repeats",
        "study",
    }
)
"""Everything that a results folder of ours may hold (RESULTS 2), the demo and the loop included."""


def check_target(out: Path) -> None:
    """Say before the work starts whether its results could be written to ``out``.

    Raises
    ------
    UsageError
        Where ``out`` is a file, a folder with anything else in it than our own results, or cannot be written.

    """
    target = out.resolve()
    if target.exists() and not target.is_dir():
        message = f"{out} is a file; name a folder for the results with -o"
        raise UsageError(message)
    if target.is_dir():
        _require_own(out, target)
    for folder in (target, target.parent) if target.is_dir() else (_lowest_there(target),):
        if not folder.is_dir():
            message = f"{out} cannot be written: {folder} is a file; name another folder with -o"
            raise UsageError(message)
        if not os.access(folder, os.W_OK | os.X_OK):
            message = f"{out} cannot be written: no permission to write in {folder}; choose another folder with -o"
            raise UsageError(message)


def _require_own(out: Path, target: Path) -> None:
    """See that a folder that is there is one that results may take the place of."""
    if os.path.ismount(target):
        message = f"{out} is where a disk is mounted, which nothing can take the place of; name a folder in it with -o"
        raise UsageError(message)
    if any(target.iterdir()) and not holds_document(target, RESULTS, schema=RESULTS_SCHEMA):
        message = (
            f"{out} holds something other than Fullwell's results and is left untouched; "
            "name a new or empty folder with -o"
        )
        raise UsageError(message)
    foreign = foreign_in(target, OWN)
    if foreign:
        message = (
            f"{out} would be replaced, but beside Fullwell's results it holds {listed(foreign)}; move that away or "
            "name another folder with -o"
        )
        raise UsageError(message)


def _lowest_there(target: Path) -> Path:
    return next(folder for folder in target.parents if folder.exists())


def write_files(results: Results, folder: Path, *, pictures: "Pictures | None" = None) -> None:
    """Write results.json, results.csv, results.parquet and report.html into a folder that is there already.

    Results by a profile of EMVA 1288 get report.pdf, the datasheet, printed while the page is drawn, and emva1288.xml,
    a result file of the reference package.
    """
    from fullwell.report.datasheet.build import build_datasheet  # noqa: PLC0415 - all that draws loads when used
    from fullwell.report.html import report_html  # noqa: PLC0415 - as above
    from fullwell.report.tables import rows_csv, write_parquet  # noqa: PLC0415 - as above

    datasheet = build_datasheet(results)
    with ThreadPoolExecutor(1) as thread:
        done = None if datasheet is None else thread.submit(_write_datasheet, datasheet, results, folder)
        (folder / RESULTS).write_text(results_json(results), encoding="utf-8", newline="\n")
        (folder / "results.csv").write_text(rows_csv(results.rows), encoding="utf-8", newline="\n")
        write_parquet(results.rows, folder / "results.parquet")
        page = report_html(results, pictures, datasheet=datasheet)
        (folder / "report.html").write_text(page, encoding="utf-8", newline="\n")
        if done is not None:
            done.result()


def _write_datasheet(datasheet: "Datasheet", results: Results, folder: Path) -> None:
    from fullwell.report.datasheet.pdf import datasheet_pdf  # noqa: PLC0415 - Typst loads for a datasheet alone
    from fullwell.report.emva_xml import reference_files  # noqa: PLC0415 - as above

    (folder / EMVA_FOLDER).mkdir()
    for name, text in reference_files(results):
        (folder / EMVA_FOLDER / name).write_text(text, encoding="utf-8", newline="\n")
    (folder / "report.pdf").write_bytes(datasheet_pdf(datasheet))
