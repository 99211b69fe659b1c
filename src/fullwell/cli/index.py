"""``fullwell index``: guessing what a folder holds becomes a visible step."""

import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from fullwell.cli.options import Cfa, Headerless, Quiet, Verbose, Version, path_from
from fullwell.cli.status import guarded, status_of

if TYPE_CHECKING:
    from fullwell.frames.series import Study


def index(
    folder: Annotated[
        Path,
        typer.Argument(
            parser=path_from,
            metavar="FOLDER",
            help="Folder that holds the capture folders; with --descriptor also a study.toml.",
        ),
    ],
    *,
    out: Annotated[
        Path | None,
        typer.Option(
            "--out", "-o", parser=path_from, metavar="FILE", help="Manifest to write; FOLDER/study.toml by default."
        ),
    ] = None,
    descriptor: Annotated[
        Path | None,
        typer.Option(
            "--descriptor",
            parser=path_from,
            metavar="FOLDER",
            help="Write EMVA 1288 descriptors instead, one per channel, ISO and temperature, images as 16-bit PNG.",
        ),
    ] = None,
    force: Annotated[bool, typer.Option("--force", help="Overwrite a manifest that is there.")] = False,
    cfa: Cfa = None,
    headerless: Headerless = None,
    quiet: Quiet = False,
    verbose: Verbose = False,
    _version: Version = False,
) -> None:
    """Write a manifest of a folder."""
    with guarded(verbose=verbose):
        if descriptor is not None:
            _export(folder, descriptor, cfa=cfa, headerless=headerless, quiet=quiet)
            raise typer.Exit
        study = _write(folder, out=out or folder / "study.toml", force=force, cfa=cfa, headerless=headerless)
        if not quiet:
            _tell(study, out or folder / "study.toml")
        raise typer.Exit(status_of(study.findings))


def _export(folder: Path, out: Path, *, cfa: str | None, headerless: str | None, quiet: bool) -> None:
    from fullwell.cli.parsing import selection_from  # noqa: PLC0415 - heavy, and `--help` does not need it
    from fullwell.workflow.descriptor import export_descriptors  # noqa: PLC0415 - as above

    names = export_descriptors(folder, out, selection=selection_from(cfa=cfa, headerless=headerless))
    if not quiet:
        sys.stdout.write("".join(f"Wrote {out / name}\n" for name in names))


def _write(folder: Path, *, out: Path, force: bool, cfa: str | None, headerless: str | None) -> "Study":
    from fullwell.cli.parsing import selection_from  # noqa: PLC0415 - heavy, and `--help` does not need it
    from fullwell.errors import UsageError  # noqa: PLC0415 - as above
    from fullwell.files import fullness_named  # noqa: PLC0415 - as above
    from fullwell.frames.manifest import write_manifest  # noqa: PLC0415 - as above
    from fullwell.frames.study import index_folder  # noqa: PLC0415 - as above

    if out.is_dir():
        raise UsageError(f"{out} is a folder; name the manifest to write with -o, for example {out / 'study.toml'}.")
    if not out.parent.is_dir():
        raise UsageError(f"The folder {out.parent} does not exist; make it, or name another file with -o.")
    if out.exists() and not force:
        raise UsageError(f"{out} is there already; --force overwrites it, -o writes elsewhere.")
    study = index_folder(folder, selection_from(cfa=cfa, headerless=headerless))
    text = write_manifest(study, folder=out.parent)
    beside = out.with_name(f".{out.name}.partial")
    try:
        with fullness_named(out):
            beside.write_text(text, encoding="utf-8")
        beside.replace(out)
    finally:
        beside.unlink(missing_ok=True)
    return study


def _tell(study: "Study", out: Path) -> None:
    from rich.console import Console  # noqa: PLC0415 - heavy, and `--help` does not need it

    from fullwell.cli.tables import print_study  # noqa: PLC0415 - as above

    print_study(Console(file=sys.stdout), study)
    sys.stdout.write(f"Wrote {out}. Look it over, correct it, then: fullwell characterize {out} -o OUT\n")
