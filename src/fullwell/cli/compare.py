"""``fullwell compare``: results side by side."""

import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from fullwell.cli.options import Json, Out, Quiet, Verbose, Version, path_from
from fullwell.cli.status import guarded, status_of

if TYPE_CHECKING:
    from fullwell.figures.side_by_side import Comparison

_Paths = Annotated[
    list[Path],
    typer.Argument(
        parser=path_from,
        metavar="RESULTS",
        help="Result folders or results.json; truth.json of a simulation; result XML of the package emva1288.",
    ),
]


def compare(
    paths: _Paths,
    *,
    out: Out = None,
    as_json: Json = False,
    quiet: Quiet = False,
    verbose: Verbose = False,
    _version: Version = False,
) -> None:
    """Set results side by side."""
    with guarded(verbose=verbose):
        from fullwell.workflow.compare import compare_paths  # noqa: PLC0415 - heavy, and `--help` does not need it

        comparison = compare_paths(paths, out=out)
        if as_json:
            from fullwell.report.compare_document import comparison_json  # noqa: PLC0415 - as above

            sys.stdout.write(comparison_json(comparison))
        elif not quiet:
            _tell(comparison, out)
        raise typer.Exit(status_of(comparison.findings))


def _tell(comparison: "Comparison", out: Path | None) -> None:
    from rich.console import Console  # noqa: PLC0415 - heavy, and `--help` does not need it

    from fullwell.cli.compare_tables import print_comparison  # noqa: PLC0415 - as above

    print_comparison(Console(file=sys.stdout), comparison, out=out)
