"""``fullwell inspect``: what raw files are."""

import json
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from fullwell.cli.options import Headerless, Json, Verbose, Version, path_from
from fullwell.cli.status import guarded, status_of

if TYPE_CHECKING:
    from fullwell.workflow.inspection import Inspection


def inspect(
    files: Annotated[list[Path], typer.Argument(parser=path_from, metavar="FILE", help="Raw files.")],
    *,
    headerless: Headerless = None,
    guess: Annotated[
        bool, typer.Option("--guess", help="Guess how files without a header are stored; writes a contact sheet.")
    ] = False,
    sheet: Annotated[
        Path | None,
        typer.Option(
            "--sheet", parser=path_from, metavar="PNG", help="Contact sheet of --guess; NAME_guesses.png by default."
        ),
    ] = None,
    preview: Annotated[
        Path | None,
        typer.Option(
            "--preview",
            parser=path_from,
            metavar="PNG",
            help="Draw picture, colour planes and codes; of several files PNG-NAME.png each.",
        ),
    ] = None,
    cfa_sheet: Annotated[
        Path | None,
        typer.Option(
            "--cfa-sheet", parser=path_from, metavar="PNG", help="Render the four CFA orders, to choose by eye."
        ),
    ] = None,
    as_json: Json = False,
    verbose: Verbose = False,
    _version: Version = False,
) -> None:
    """Tell what raw files are."""
    with guarded(verbose=verbose):
        from fullwell.raw.headerless_format import parse_format  # noqa: PLC0415 - as above
        from fullwell.workflow.inspection import inspect_file  # noqa: PLC0415 - heavy, and `--help` does not need it

        _require_files(files)
        if guess or sheet is not None:
            from fullwell.cli.guessing import tell_guesses  # noqa: PLC0415 - as above

            tell_guesses(files, sheet=sheet, as_json=as_json)
            return
        stated = None if headerless is None else parse_format(headerless)
        inspections = _readable([inspect_file(path, headerless=stated) for path in files])
        drawn = _draw(inspections, preview=preview, cfa_sheet=cfa_sheet)
        if as_json:
            from fullwell.cli.inspection_tables import document  # noqa: PLC0415 - as above

            sys.stdout.write(json.dumps([document(one) for one in inspections], indent=1, allow_nan=False) + "\n")
        else:
            _tell(inspections)
            sys.stdout.writelines(f"Drawn: {path}\n" for path in drawn)
        raise typer.Exit(status_of(finding for one in inspections for finding in one.findings))


def _draw(inspections: Sequence["Inspection"], *, preview: Path | None, cfa_sheet: Path | None) -> list[Path]:
    """Draw what was asked for of every file whose pixels can be read."""
    if preview is None and cfa_sheet is None:
        return []
    from fullwell.errors import UsageError  # noqa: PLC0415 - `--help` does not need it
    from fullwell.workflow.previews import orders_of, preview_of, write_sheets  # noqa: PLC0415 - as above

    headers = [one.header for one in inspections if one.header is not None and one.content is not None]
    if not headers:
        raise UsageError("There is nothing to draw: no pixels can be read. `fullwell inspect` alone says why.")
    wanted = ((preview, preview_of), (cfa_sheet, orders_of))
    return [target for path, draw in wanted if path is not None for target in write_sheets(headers, path, draw=draw)]


def _require_files(files: Sequence[Path]) -> None:
    from fullwell.errors import UsageError  # noqa: PLC0415 - `--help` does not need it

    for path in files:
        if not path.exists():
            raise UsageError(f"{path} does not exist.")
        if path.is_dir():
            raise UsageError(f"{path} is a folder; name files, or index the folder with `fullwell index`.")


def _readable(inspections: Sequence["Inspection"]) -> Sequence["Inspection"]:
    """Return inspections of which one has a header at least."""
    from fullwell.errors import UsageError  # noqa: PLC0415 - `--help` does not need it

    if all(one.header is None for one in inspections):
        said = [f"{one.path}: {finding.message.rstrip('.')}." for one in inspections for finding in one.findings]
        raise UsageError("\n  ".join(said))
    return inspections


def _tell(inspections: Sequence["Inspection"]) -> None:
    from rich.console import Console  # noqa: PLC0415 - heavy, and `--help` does not need it

    from fullwell.cli.inspection_tables import print_panel, print_table  # noqa: PLC0415 - as above

    console = Console(file=sys.stdout)
    if len(inspections) == 1:
        print_panel(console, inspections[0])
    else:
        print_table(console, inspections)
