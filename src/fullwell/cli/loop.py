"""``fullwell loop``: a camera is simulated as it was measured, measured again, and laid beside its truth."""

import os
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from fullwell.cli.options import MOST_WORKERS, Json, Out, Quiet, Verbose, Version, path_from
from fullwell.cli.progress import shown_progress
from fullwell.cli.status import guarded, status_of

if TYPE_CHECKING:
    from fullwell.findings import Finding
    from fullwell.workflow.loop.loop import LoopOptions, LoopOutcome


def loop(
    what: Annotated[
        Path,
        typer.Argument(
            parser=path_from,
            metavar="RESULTS.json|CONFIG.toml",
            help="Results of a measurement or their folder, a camera's config, a TOML file of [figures] (k's, EMVA "
            "1288), or the name of a camera that comes with Fullwell.",
        ),
    ],
    *,
    out: Out = None,
    repeat: Annotated[
        int, typer.Option("--repeat", min=1, metavar="N", help="Cameras: from 2 on, bias and coverage of every figure.")
    ] = 1,
    full: Annotated[bool, typer.Option("--full", help="Frames as large as the source's.")] = False,
    keep: Annotated[bool, typer.Option("--keep", help="Keep the simulated raw files.")] = False,
    seed: Annotated[
        int | None,
        typer.Option("--seed", min=0, metavar="N", help="Seed of the first camera; the source's by default."),
    ] = None,
    workers: Annotated[
        int | None,
        typer.Option(
            "--workers", min=1, max=MOST_WORKERS, metavar="N", help="Cameras side by side; all cores by default."
        ),
    ] = None,
    as_json: Json = False,
    quiet: Quiet = False,
    verbose: Verbose = False,
    _version: Version = False,
) -> None:
    """Close the loop."""
    with guarded(verbose=verbose):
        from fullwell.errors import UsageError  # noqa: PLC0415 - heavy, `--help` does not need it
        from fullwell.workflow.loop.loop import LoopOptions  # noqa: PLC0415 - as above

        if out is None:
            raise UsageError("Name a folder for the results with -o OUT.")
        cores = workers or os.cpu_count() or 1
        options = LoopOptions(repeats=repeat, full=full, keep=keep, seed=seed, workers=cores)
        raise typer.Exit(status_of(_run(what, out, options, as_json=as_json, quiet=quiet)))


def _run(what: Path, out: Path, options: "LoopOptions", *, as_json: bool, quiet: bool) -> "tuple[Finding, ...]":
    from fullwell.workflow.loop.loop import loop as run  # noqa: PLC0415 - as above

    with shown_progress(quiet=quiet) as progress:
        outcome = run(what, out, options=options, progress=progress)
    if as_json:
        from fullwell.report.document import results_json  # noqa: PLC0415 - as above

        sys.stdout.write(results_json(outcome.results))
    elif not quiet:
        _tell(outcome, out)
    return outcome.results.findings


def _tell(outcome: "LoopOutcome", out: Path) -> None:
    from rich.console import Console  # noqa: PLC0415 - as above

    from fullwell.cli.loop_summary import print_loop  # noqa: PLC0415 - as above

    print_loop(Console(file=sys.stdout), outcome, out=out)
