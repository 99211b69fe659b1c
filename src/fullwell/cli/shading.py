"""``fullwell shading``: lens-shading maps are fitted, compared, and scenes corrected by them."""

import os
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from fullwell.cli.options import (
    Black,
    CameraFacts,
    Cfa,
    Crop,
    Exposures,
    Headerless,
    Isos,
    Json,
    Only,
    Quiet,
    Verbose,
    Version,
    White,
    Workers,
    path_from,
)
from fullwell.cli.progress import shown_progress
from fullwell.cli.status import guarded, status_of

if TYPE_CHECKING:
    from fullwell.workflow.shading.folder import ShadingOutcome

_CONTEXT = {"help_option_names": ["-h", "--help"]}

shading = typer.Typer(rich_markup_mode=None, add_completion=False, pretty_exceptions_enable=False)

Target = Annotated[
    Path,
    typer.Option(
        "--out",
        "-o",
        parser=path_from,
        metavar="FOLDER",
        help="Folder for the results: new, empty, or of this command.",
    ),
]


@shading.callback(invoke_without_command=True)
def everything(context: typer.Context, *, _version: Version = False) -> None:
    """Fit, compare and apply maps of lens shading."""
    if context.invoked_subcommand is None:
        sys.stderr.write(context.get_help() + "\n")
        raise typer.Exit(2)


@shading.command(help="Fit maps to the flats of a study.", context_settings=_CONTEXT)
def fit(
    path: Annotated[Path, typer.Argument(parser=path_from, metavar="PATH", help="A study folder, or a study.toml.")],
    *,
    out: Target,
    iso: Isos = None,
    exposure: Exposures = None,
    only: Only = None,
    crop: Crop = None,
    cfa: Cfa = None,
    headerless: Headerless = None,
    black: Black = None,
    white: White = None,
    camera: CameraFacts = None,
    workers: Workers = None,
    as_json: Json = False,
    quiet: Quiet = False,
    verbose: Verbose = False,
    _version: Version = False,
) -> None:
    """Fit maps."""
    with guarded(verbose=verbose):
        from fullwell.cli.parsing import selection_from  # noqa: PLC0415 - heavy, and `--help` does not need it
        from fullwell.workflow.options import Options  # noqa: PLC0415 - as above
        from fullwell.workflow.shading.fit import fit_maps  # noqa: PLC0415 - as above

        selection = selection_from(
            isos=iso,
            exposures=exposure,
            only=only,
            cfa=cfa,
            black=black,
            white=white,
            camera=camera,
            crop=crop,
            headerless=headerless,
        )
        options = Options(selection=selection, workers=workers or os.cpu_count() or 1)
        with shown_progress(quiet=quiet) as progress:
            outcome = fit_maps(path, out, options=options, progress=progress)
        _finish(outcome, as_json=as_json, quiet=quiet)


@shading.command(help="Compare maps, or the bursts of a study.", context_settings=_CONTEXT)
def compare(
    paths: Annotated[
        list[Path],
        typer.Argument(
            parser=path_from, metavar="PATH", help="Maps, folders with maps, or studies; the first is the base."
        ),
    ],
    *,
    out: Target,
    other_sensor: Annotated[
        bool, typer.Option("--other-sensor", help="Different sensors took the flats: PRNU counts in every map.")
    ] = False,
    iso: Isos = None,
    exposure: Exposures = None,
    crop: Crop = None,
    cfa: Cfa = None,
    headerless: Headerless = None,
    black: Black = None,
    white: White = None,
    camera: CameraFacts = None,
    workers: Workers = None,
    as_json: Json = False,
    quiet: Quiet = False,
    verbose: Verbose = False,
    _version: Version = False,
) -> None:
    """Compare maps."""
    with guarded(verbose=verbose):
        from fullwell.cli.parsing import selection_from  # noqa: PLC0415 - heavy, and `--help` does not need it
        from fullwell.workflow.options import Options  # noqa: PLC0415 - as above
        from fullwell.workflow.shading.compare import compare_maps  # noqa: PLC0415 - as above

        selection = selection_from(
            isos=iso,
            exposures=exposure,
            cfa=cfa,
            black=black,
            white=white,
            camera=camera,
            crop=crop,
            headerless=headerless,
        )
        options = Options(selection=selection, workers=workers or os.cpu_count() or 1)
        with shown_progress(quiet=quiet) as progress:
            outcome = compare_maps(paths, out, options=options, same_sensor=not other_sensor, progress=progress)
        _finish(outcome, as_json=as_json, quiet=quiet)


@shading.command(help="Correct raw scenes by a map.", context_settings=_CONTEXT)
def apply(
    shading_map: Annotated[
        Path, typer.Argument(parser=path_from, metavar="MAP", help="A map that fit wrote, or a folder with maps.")
    ],
    scenes: Annotated[
        list[Path], typer.Argument(parser=path_from, metavar="SCENE", help="Raw files, or folders of them.")
    ],
    *,
    out: Target,
    turn: Annotated[
        str | None,
        typer.Option(
            "--turn", metavar="DEGREES", help="The scenes' mosaics lie turned to the right by 0, 90, 180, 270."
        ),
    ] = None,
    cfa: Cfa = None,
    headerless: Headerless = None,
    black: Black = None,
    white: White = None,
    camera: CameraFacts = None,
    workers: Workers = None,
    as_json: Json = False,
    quiet: Quiet = False,
    verbose: Verbose = False,
    _version: Version = False,
) -> None:
    """Correct scenes."""
    with guarded(verbose=verbose):
        from fullwell.cli.parsing import selection_from  # noqa: PLC0415 - heavy, and `--help` does not need it
        from fullwell.workflow.options import Options  # noqa: PLC0415 - as above
        from fullwell.workflow.shading.apply import apply_shading  # noqa: PLC0415 - as above

        selection = selection_from(cfa=cfa, black=black, white=white, camera=camera, headerless=headerless)
        options = Options(selection=selection, workers=workers or os.cpu_count() or 1)
        quarters = _quarters(turn)
        with shown_progress(quiet=quiet) as progress:
            outcome = apply_shading(shading_map, scenes, out, options=options, quarters=quarters, progress=progress)
        _finish(outcome, as_json=as_json, quiet=quiet)


def _quarters(turn: str | None) -> int | None:
    """Return quarter turns to the left from degrees to the right."""
    from fullwell.errors import UsageError  # noqa: PLC0415 - `--help` does not need it

    known = {"0": 0, "90": 3, "180": 2, "270": 1}
    if turn is not None and turn not in known:
        raise UsageError(f"--turn {turn}: give {', '.join(known)}.")
    return None if turn is None else known[turn]


def _finish(outcome: "ShadingOutcome", *, as_json: bool, quiet: bool) -> None:
    """Tell what was found, and end with the status it deserves.

    Raises
    ------
    typer.Exit
        Always.

    """
    if as_json:
        import json  # noqa: PLC0415 - one line for those who ask for it

        sys.stdout.write(json.dumps(outcome.document, indent=1, ensure_ascii=False) + "\n")
    elif not quiet:
        from rich.console import Console  # noqa: PLC0415 - heavy, and `--help` does not need it

        from fullwell.cli.shading_summary import print_shading  # noqa: PLC0415 - as above

        print_shading(Console(file=sys.stdout), outcome)
    raise typer.Exit(status_of(outcome.findings))
