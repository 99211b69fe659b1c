"""``fullwell demo``: a camera of known truth is simulated, measured through the front door, and compared."""

import os
import sys
from pathlib import Path
from typing import Annotated

import typer

from fullwell.cli.options import Quiet, Verbose, Version, Workers, path_from
from fullwell.cli.progress import shown_progress
from fullwell.cli.status import guarded, status_of


def demo(
    *,
    out: Annotated[
        Path, typer.Option("--out", "-o", parser=path_from, metavar="FOLDER", help="Folder for frames and results.")
    ] = Path("fullwell-demo"),
    full: Annotated[bool, typer.Option("--full", help="The real camera's size: four times the pixels.")] = False,
    workers: Workers = None,
    quiet: Quiet = False,
    verbose: Verbose = False,
    _version: Version = False,
) -> None:
    """Run the demonstration."""
    with guarded(verbose=verbose):
        from fullwell.workflow.demo import run_demo  # noqa: PLC0415 - heavy, and `--help` does not need it

        with shown_progress(quiet=quiet) as progress:
            outcome = run_demo(out, full=full, workers=workers or os.cpu_count() or 1, progress=progress)
        if not quiet:
            from rich.console import Console  # noqa: PLC0415 - as above

            from fullwell.cli.demo_summary import print_outcome  # noqa: PLC0415 - as above

            print_outcome(Console(file=sys.stdout), outcome, out=out)
        raise typer.Exit(status_of(outcome.findings))
