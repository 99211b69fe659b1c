"""``fullwell convert``: raw files as DNG or TIFF."""

import os
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from fullwell.cli.options import Black, Cfa, Headerless, Json, Quiet, Verbose, Version, White, Workers, path_from
from fullwell.cli.progress import shown_progress
from fullwell.cli.status import guarded, status_of

if TYPE_CHECKING:
    from fullwell.workflow.convert.convert import ConvertOutcome
    from fullwell.workflow.convert.settings import Compression, FileKind

Target = Annotated[
    Path,
    typer.Option(
        "--out",
        "-o",
        parser=path_from,
        metavar="OUT",
        help="A file ending in .dng, .tif or .tiff; a folder for several.",
    ),
]
Linearize = Annotated[
    bool,
    typer.Option("--linearize", help="Black becomes 0 and white 65535; what lay below black is lost and counted."),
]
Demosaic = Annotated[
    bool, typer.Option("--demosaic", help="Linear colours at every pixel, 16 bits, black 0 and white 65535: a picture.")
]
WhiteBalance = Annotated[
    bool, typer.Option("--white-balance", help="Scale the colours so that white is grey; black 0 and white 65535.")
]
BitShift = Annotated[
    int,
    typer.Option("--bit-shift", metavar="N", help="Shift codes and levels by N bits: left above 0, right below."),
]


def convert(
    paths: Annotated[list[Path], typer.Argument(parser=path_from, metavar="IN", help="Raw files, or folders of them.")],
    *,
    out: Target,
    kind: Annotated[
        str | None, typer.Option("--format", metavar="dng|tiff", help="What to write; by OUT, and DNG into a folder.")
    ] = None,
    compression: Annotated[
        str, typer.Option("--compression", metavar="none|lossless-jpeg", help="Of DNG mosaics.")
    ] = "none",
    linearize: Linearize = False,
    demosaic: Demosaic = False,
    white_balance: WhiteBalance = False,
    bit_shift: BitShift = 0,
    overwrite: Annotated[bool, typer.Option("--overwrite", help="Replace files that exist.")] = False,
    cfa: Cfa = None,
    headerless: Headerless = None,
    black: Black = None,
    white: White = None,
    workers: Workers = None,
    as_json: Json = False,
    quiet: Quiet = False,
    verbose: Verbose = False,
    _version: Version = False,
) -> None:
    """Convert raw files."""
    with guarded(verbose=verbose):
        from fullwell.cli.parsing import selection_from  # noqa: PLC0415 - heavy, and `--help` does not need it
        from fullwell.workflow.convert.convert import convert as convert_files  # noqa: PLC0415 - as above
        from fullwell.workflow.convert.settings import Conversion  # noqa: PLC0415 - as above
        from fullwell.workflow.options import Options  # noqa: PLC0415 - as above

        conversion = Conversion(
            compression=_compression(compression),
            linearize=linearize,
            demosaic=demosaic,
            white_balance=white_balance,
            bit_shift=_bits(bit_shift),
            overwrite=overwrite,
        )
        chosen = _kind(kind)
        selection = selection_from(cfa=cfa, black=black, white=white, headerless=headerless)
        options = Options(selection=selection, workers=workers or os.cpu_count() or 1)
        with shown_progress(quiet=quiet) as progress:
            outcome = convert_files(paths, out, options=options, conversion=conversion, kind=chosen, progress=progress)
        _tell(outcome, as_json=as_json, quiet=quiet)
        raise typer.Exit(status_of(outcome.findings))


def _tell(outcome: "ConvertOutcome", *, as_json: bool, quiet: bool) -> None:
    if as_json:
        import json  # noqa: PLC0415 - one line for those who ask for it

        sys.stdout.write(json.dumps(outcome.document, indent=1, allow_nan=False) + "\n")
    elif not quiet:
        from fullwell.cli.convert_summary import print_converted  # noqa: PLC0415 - `--help` does not need it

        print_converted(outcome)


def _kind(text: str | None) -> "FileKind | None":
    from fullwell.errors import UsageError  # noqa: PLC0415 - `--help` does not need it
    from fullwell.workflow.convert.settings import KINDS  # noqa: PLC0415 - as above

    known = {"tif": "tiff"} | {name: name for name in KINDS}
    if text is not None and text.casefold() not in known:
        raise UsageError(f"--format {text}: give {' or '.join(KINDS)}.")
    return None if text is None else next(name for name in KINDS if name == known[text.casefold()])


def _compression(text: str) -> "Compression":
    from fullwell.errors import UsageError  # noqa: PLC0415 - `--help` does not need it
    from fullwell.workflow.convert.settings import COMPRESSIONS  # noqa: PLC0415 - as above

    for name in COMPRESSIONS:
        if name == text.casefold():
            return name
    raise UsageError(f"--compression {text}: give {' or '.join(COMPRESSIONS)}.")


def _bits(bits: int) -> int:
    from fullwell.errors import UsageError  # noqa: PLC0415 - `--help` does not need it
    from fullwell.workflow.convert.settings import MOST_SHIFT  # noqa: PLC0415 - as above

    if abs(bits) > MOST_SHIFT:
        raise UsageError(f"--bit-shift {bits}: give -{MOST_SHIFT} to {MOST_SHIFT} bits.")
    return bits
