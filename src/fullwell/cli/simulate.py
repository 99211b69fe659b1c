"""``fullwell simulate``: a camera as raw files on disk."""

import os
import sys
from pathlib import Path
from typing import Annotated

import typer

from fullwell.cli.options import Quiet, Verbose, Version, Workers, path_from
from fullwell.cli.progress import shown_progress
from fullwell.cli.status import guarded


def simulate(
    config: Annotated[Path, typer.Argument(metavar="CONFIG.toml", help="What to simulate.")],
    *,
    out: Annotated[
        Path, typer.Option("--out", "-o", parser=path_from, metavar="FOLDER", help="Folder for the frames.")
    ],
    workers: Workers = None,
    quiet: Quiet = False,
    verbose: Verbose = False,
    _version: Version = False,
) -> None:
    """Write a simulated camera's frames."""
    with guarded(verbose=verbose):
        from fullwell.workflow.simulate import simulate as run  # noqa: PLC0415 - heavy, and `--help` does not need it

        with shown_progress(quiet=quiet) as progress:
            run(config, out, workers=workers or os.cpu_count() or 1, progress=progress)
        if not quiet:
            sys.stdout.write(f"Wrote the frames into {out}. Measure them: fullwell characterize {out} -o OUT\n")
