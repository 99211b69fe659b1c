"""Options that several commands share, as Typer reads them."""

import sys
from pathlib import Path
from typing import Annotated, Final

import typer

from fullwell.cli.overview import version_line

MOST_WORKERS: Final = 1024
"""More threads than that no machine runs side by side."""


def _show_version(value: bool) -> None:  # noqa: FBT001 - Typer hands an option's value to its callback by position
    if value:
        sys.stdout.write(version_line())
        raise typer.Exit


def path_from(text: str | Path) -> Path:
    """Return a path, which a default is already; ``~``, which shells leave alone in quotes, is the user's home.

    Raises
    ------
    typer.BadParameter
        The text is empty, as an unset shell variable leaves it, and would be the current folder; or it is a URL, or
        begins with the home of a user who does not exist.

    """
    if not str(text).strip():
        raise typer.BadParameter("the path is empty; for the current folder give a dot.")
    if "://" in str(text):
        raise typer.BadParameter(f"{text} is a URL; only studies and raw files are read from there.")
    try:
        return Path(text).expanduser() if str(text).startswith("~") else Path(text)
    except RuntimeError as error:
        raise typer.BadParameter(f"{text} begins with the home of nobody; a folder of that name is ./{text}") from error


def source_from(text: str | Path) -> Path:
    """Return the path of a study or a raw file, which may lie at a URL.

    Raises
    ------
    typer.BadParameter
        The text is empty, or nothing that is installed reads such a URL.

    """
    if "://" not in str(text):
        return path_from(text)
    from fullwell.errors import UsageError  # noqa: PLC0415 - `--help` does not need it
    from fullwell.raw.remote import located  # noqa: PLC0415 - as above

    try:
        return located(str(text))
    except UsageError as error:
        raise typer.BadParameter(str(error)) from error


Version = Annotated[
    bool, typer.Option("--version", callback=_show_version, is_eager=True, help="Show the version and exit.")
]
Isos = Annotated[list[str] | None, typer.Option("--iso", metavar="ISO", help="Use these ISOs only: 100 or 100,200.")]
Exposures = Annotated[
    list[str] | None,
    typer.Option("--exposure", metavar="TIME", help="Use these exposures only, in seconds or with a unit: 0.01, 10ms."),
]
Only = Annotated[
    list[str] | None,
    typer.Option("--only", metavar="KIND", help="Use these kinds only: flat, dark, bias, chart, scene."),
]
Crop = Annotated[
    str | None, typer.Option("--crop", metavar="X,Y,W,H", help="Measure this region of the visible mosaic.")
]
Tile = Annotated[
    int | None,
    typer.Option(
        "--tile",
        metavar="N",
        help="Edge of a tile in pixels of a CFA plane, 4 to 256; by default 64, or an eighth of a small plane.",
    ),
]
Cfa = Annotated[
    str | None,
    typer.Option("--cfa", metavar="ORDER", help="RGGB, GRBG, GBRG, BGGR or mono, above what the files say."),
]
Black = Annotated[
    str | None, typer.Option("--black", metavar="DN", help="Black level: one number, or one per CFA site, row by row.")
]
White = Annotated[float | None, typer.Option("--white", metavar="DN", help="White level.")]
CameraFacts = Annotated[
    str | None,
    typer.Option("--camera", metavar="NAME|FILE", help="Camera facts: pixel-4a, or a TOML file with a [camera] table."),
]
Headerless = Annotated[
    str | None,
    typer.Option(
        "--headerless",
        metavar="FORMAT",
        help="How files without a header are stored: width=1920,height=1080,bits=12,container=16,byte_order=little,"
        "offset=0,row_stride=0,cfa=BGGR; container 8, 16, packed-mipi, packed-lsb or packed-msb.",
    ),
]
LegacyBlack = Annotated[
    str,
    typer.Option(
        "--legacy-black",
        metavar="kept|subtracted",
        help="Black level in the tables of the published study: kept, as published, or subtracted first.",
    ),
]
Profiles = Annotated[
    list[str] | None,
    typer.Option(
        "--profile",
        metavar="ID",
        help="Evaluate by EMVA 1288 too: emva1288-4.0-linear, emva1288-py-1.0 for the figures of that package, or both "
        "with a comma between them or the option twice.",
    ),
]
Workers = Annotated[
    int | None,
    typer.Option(
        "--workers", min=1, max=MOST_WORKERS, metavar="N", help="Threads; all cores by default. Results never differ."
    ),
]
Dask = Annotated[
    str | None,
    typer.Option(
        "--dask",
        metavar="SCHEDULER",
        help="Read the frames in the processes of a Dask cluster: tcp://host:8786, or local for this machine's own.",
    ),
]
Cache = Annotated[
    Path | None,
    typer.Option(
        "--cache",
        parser=path_from,
        metavar="FOLDER",
        help="Keep finished series here, for other studies too, up to 32 GB; by default in OUT.cache.",
    ),
]
StudyPath = Annotated[
    Path,
    typer.Argument(
        parser=source_from,
        metavar="PATH",
        help="A study folder, a study.toml, or an EMVA 1288 descriptor; here or at a URL.",
    ),
]
NoCache = Annotated[bool, typer.Option("--no-cache", help="Keep no finished series, and use none.")]
Recheck = Annotated[bool, typer.Option("--recheck", help="Read and hash every file before what is kept of it is used.")]
DryRun = Annotated[bool, typer.Option("--dry-run", help="Show what would be read and measured, and stop.")]
Json = Annotated[bool, typer.Option("--json", help="Print the document as JSON on stdout, and nothing else there.")]
Quiet = Annotated[bool, typer.Option("--quiet", "-q", help="No progress and no summary.")]
Verbose = Annotated[bool, typer.Option("--verbose", help="Show the traceback of an error.")]
Out = Annotated[
    Path | None,
    typer.Option(
        "--out",
        "-o",
        parser=path_from,
        metavar="FOLDER",
        help="Folder for the results: new, empty, or with results of ours.",
    ),
]
