"""``fullwell chart``: shots of a test chart become a noise model."""

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
    DryRun,
    Exposures,
    Headerless,
    Isos,
    Json,
    Out,
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
    from collections.abc import Sequence

    from fullwell.findings import Finding
    from fullwell.workflow.chart.chart import ChartOptions
    from fullwell.workflow.options import Options


def _show_guide(value: bool) -> None:  # noqa: FBT001 - Typer hands an option's value to its callback by position
    if value:
        from fullwell.cli.chart_guide import GUIDE  # noqa: PLC0415 - read only when asked for

        sys.stdout.write(GUIDE)
        raise typer.Exit


Guide = Annotated[
    bool, typer.Option("--guide", callback=_show_guide, is_eager=True, help="Tell how to shoot a chart, and exit.")
]
Patches = Annotated[
    list[Path] | None,
    typer.Option(
        "--patches",
        parser=path_from,
        metavar="PATCHES.csv",
        help="Where the patches are: patch,x,y,width,height,density. Once, or with --separate once for each image.",
    ),
]
ChartName = Annotated[
    str | None,
    typer.Option("--chart", metavar="NAME", help="Find the patches of this chart; your own: a TOML file."),
]
CornerPoints = Annotated[
    str | None,
    typer.Option("--corners", metavar="X1,Y1,...", help="The chart's four corners, clockwise from its own top left."),
]
Separate = Annotated[
    bool,
    typer.Option("--separate", help="The images are different shots, not frames or exposures of one still scene."),
]
BlackMethod = Annotated[
    str | None,
    typer.Option(
        "--black-method",
        metavar="legacy-offset-ratio[=R]",
        help="Set the black level as published: the darkest patch one part in R of the lightest.",
    ),
]
Rendered = Annotated[
    Path | None,
    typer.Option("--rendered", parser=path_from, metavar="FILE", help="A JPEG or PNG of the same scene, to compare."),
]


def chart(
    images: Annotated[
        list[Path], typer.Argument(parser=path_from, metavar="IMAGE", help="Raw files of one still scene.")
    ],
    *,
    patches: Patches = None,
    chart_name: ChartName = None,
    corners: CornerPoints = None,
    separate: Separate = False,
    out: Out = None,
    iso: Isos = None,
    exposure: Exposures = None,
    crop: Crop = None,
    cfa: Cfa = None,
    headerless: Headerless = None,
    black: Black = None,
    black_method: BlackMethod = None,
    white: White = None,
    camera: CameraFacts = None,
    rendered: Rendered = None,
    workers: Workers = None,
    dry_run: DryRun = False,
    as_json: Json = False,
    quiet: Quiet = False,
    verbose: Verbose = False,
    _guide: Guide = False,
    _version: Version = False,
) -> None:
    """Measure a noise model from shots of a chart."""
    with guarded(verbose=verbose):
        from fullwell.cli.parsing import selection_from  # noqa: PLC0415 - heavy, `--help` does not need it
        from fullwell.workflow.options import Options  # noqa: PLC0415 - as above

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
        asked = _asked((patches, chart_name, corners), separate=separate, black_method=black_method, rendered=rendered)
        if dry_run:
            findings = _show_plan(images, options, as_json=as_json)
        else:
            findings = _measure(images, out, options, asked, as_json=as_json, quiet=quiet)
        raise typer.Exit(status_of(findings))


def _asked(
    where: tuple[list[Path] | None, str | None, str | None],
    *,
    separate: bool,
    black_method: str | None,
    rendered: Path | None,
) -> "ChartOptions":
    """Return what is asked of the chart; ``where`` is --patches, --chart and --corners."""
    from fullwell.cli.chart_parsing import black_choice_from, where_from  # noqa: PLC0415 - heavy, as above
    from fullwell.workflow.chart.chart import ChartOptions  # noqa: PLC0415 - as above

    return ChartOptions(
        where=where_from(*where), separate=separate, black=black_choice_from(black_method), rendered=rendered
    )


def _show_plan(images: list[Path], options: "Options", *, as_json: bool) -> "Sequence[Finding]":
    from fullwell.frames.images import load_images  # noqa: PLC0415 - heavy, and `--help` does not need it
    from fullwell.frames.series import Kind  # noqa: PLC0415 - as above

    study = load_images(images, options.selection, kind=Kind.CHART)
    if as_json:
        from fullwell.cli.plan import plan_json  # noqa: PLC0415 - as above

        sys.stdout.write(plan_json(study))
    else:
        from rich.console import Console  # noqa: PLC0415 - as above

        from fullwell.cli.tables import print_study  # noqa: PLC0415 - as above

        print_study(Console(file=sys.stdout), study)
    return study.findings


def _measure(
    images: list[Path], out: Path | None, options: "Options", asked: "ChartOptions", *, as_json: bool, quiet: bool
) -> "Sequence[Finding]":
    from fullwell.errors import UsageError  # noqa: PLC0415 - as above

    if out is None:
        raise UsageError("Name a folder for the results with -o OUT (or look first with --dry-run).")
    from fullwell.workflow.chart.chart import chart as run  # noqa: PLC0415 - as above

    with shown_progress(quiet=quiet) as progress:
        results = run(images, out, options=options, asked=asked, progress=progress)
    if as_json:
        from fullwell.report.document import results_json  # noqa: PLC0415 - as above

        sys.stdout.write(results_json(results))
    elif not quiet:
        from rich.console import Console  # noqa: PLC0415 - as above

        from fullwell.cli.summary import print_summary  # noqa: PLC0415 - as above

        print_summary(Console(file=sys.stdout), results, out=out)
    return results.findings
