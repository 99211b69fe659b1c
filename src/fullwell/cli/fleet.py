"""``fullwell fleet``: many studies, each a results folder, all of them one table."""

import os
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from fullwell.cli.options import (
    Cache,
    Dask,
    Json,
    NoCache,
    Quiet,
    Recheck,
    Verbose,
    Version,
    Workers,
    path_from,
    source_from,
)
from fullwell.cli.status import DONE, DONE_WITH_ERRORS, guarded

if TYPE_CHECKING:
    from fullwell.workflow.fleet import Entry


def fleet(
    studies: Annotated[
        list[Path],
        typer.Argument(parser=source_from, metavar="STUDY", help="Study folders, or study.toml files; also URLs."),
    ],
    *,
    out: Annotated[
        Path,
        typer.Option(
            "--out",
            "-o",
            parser=path_from,
            metavar="FOLDER",
            help="Folder for the results: one folder a study, and a table.",
        ),
    ],
    resume: Annotated[
        bool, typer.Option("--resume", help="Leave studies alone whose results are there already.")
    ] = False,
    workers: Workers = None,
    dask: Dask = None,
    cache: Cache = None,
    no_cache: NoCache = False,
    recheck: Recheck = False,
    as_json: Json = False,
    quiet: Quiet = False,
    verbose: Verbose = False,
    _version: Version = False,
) -> None:
    """Measure many sensors."""
    with guarded(verbose=verbose):
        from fullwell.cli.parsing import cache_from  # noqa: PLC0415 - heavy, `--help` does not need it
        from fullwell.workflow.fleet import INDEX, characterize_fleet  # noqa: PLC0415 - as above
        from fullwell.workflow.options import Options  # noqa: PLC0415 - as above

        options = Options(
            workers=workers or os.cpu_count() or 1,
            dask=dask,
            cache=cache_from(cache, no_cache=no_cache, out=out, recheck=recheck),
        )
        told = None if quiet or as_json else _tell
        entries = characterize_fleet(studies, out, options=options, resume=resume, told=told)
        if as_json:
            sys.stdout.write((out / INDEX).read_text(encoding="utf-8"))
        raise typer.Exit(DONE_WITH_ERRORS if any(entry.errors for entry in entries) else DONE)


def _tell(entry: "Entry") -> None:
    """Print a line for a study that is done."""
    found = f"{entry.errors} errors, {entry.warnings} warnings, {entry.duration_s:.1f} s"
    said = {"done": found, "kept": "kept", "failed": entry.reason}[entry.state]
    sys.stdout.write(f"{entry.name}: {said}\n")
    sys.stdout.flush()
