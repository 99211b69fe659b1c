"""``fullwell inspect --guess``: how headerless files may be stored, the likeliest way first."""

import json
import sys
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from pathlib import Path

from rich.console import Console
from rich.markup import escape

from fullwell.errors import RawFileError, UsageError
from fullwell.files import fullness_named
from fullwell.raw.guess import Guess, guess_formats
from fullwell.raw.headerless import unpacked
from fullwell.raw.open import read_header
from fullwell.render.contact_sheet import write_contact_sheet


def tell_guesses(paths: Sequence[Path], *, sheet: Path | None, as_json: bool) -> None:
    """Guess the geometry of files, print the guesses, and write a contact sheet of them.

    Parameters
    ----------
    paths
        The files.
    sheet
        PNG to write, for a single file; None writes one beside the working folder's other files, none with JSON.
    as_json
        Whether to print a list of objects.

    Raises
    ------
    UsageError
        Where a file holds no picture, or one sheet is named for several files.

    """
    if sheet is not None and len(paths) > 1:
        raise UsageError("--sheet names one file; guess one file at a time, or leave it out.")
    documents: list[Mapping[str, object]] = []
    console = Console(file=sys.stdout, soft_wrap=True)
    for path in paths:
        _require_headerless(path)
        data = path.read_bytes()
        guesses = guess_formats(data, name=path.name)
        if not guesses:
            raise UsageError(f"{path} has {len(data)} bytes, which are no picture in any way that is known.")
        target = sheet if as_json else sheet or Path(f"{path.stem}_guesses.png")
        if target is not None:
            _write_sheet(target, guesses, data)
        if as_json:
            documents.append(_document(path, guesses, sheet=target, size=len(data)))
        else:
            _tell(console, path, guesses, sheet=target)
    if as_json:
        sys.stdout.write(json.dumps(documents, indent=1, allow_nan=False) + "\n")


def _require_headerless(path: Path) -> None:
    try:
        header = read_header(path)
    except RawFileError as error:
        if error.code in {"not-a-raw-file", "geometry-mismatch"}:
            return
        raise UsageError(f"{path}: {error.message}; there is nothing to guess.") from error
    if header.format != "headerless":
        raise UsageError(f"{path} says for itself that it is {header.format}; there is nothing to guess.")


def _write_sheet(path: Path, guesses: Sequence[Guess], data: bytes) -> None:
    shown = [
        (f"{rank}. {_short(guess)}\n{guess.bits_left:.2f} bits left", unpacked(guess.stated, memoryview(data)))
        for rank, guess in enumerate(guesses, start=1)
    ]
    with fullness_named(path):
        write_contact_sheet(path, shown)


def _short(guess: Guess) -> str:
    stated = guess.stated
    kind = f"{stated.container} {stated.byte_order}" if stated.container == "16" else stated.container
    return f"{stated.width} x {stated.height}, {stated.bits} bits, {kind}"


def _tell(console: Console, path: Path, guesses: Sequence[Guess], *, sheet: Path | None) -> None:
    console.print(escape(f"{path}: {path.stat().st_size} bytes"), highlight=False)
    for rank, guess in enumerate(guesses, start=1):
        console.print(f"{rank:>3}. --headerless {guess.stated}", highlight=False)
        console.print(escape(f"     {guess.reason}"), highlight=False)
    if sheet is not None:
        console.print(escape(f"All of them side by side: {sheet}"), highlight=False)


def _document(path: Path, guesses: Sequence[Guess], *, sheet: Path | None, size: int) -> Mapping[str, object]:
    return {
        "path": str(path),
        "size": size,
        "sheet": None if sheet is None else str(sheet),
        "guesses": [
            {
                "rank": rank,
                "headerless": str(guess.stated),
                **asdict(guess.stated),
                "bits_left": guess.bits_left,
                "score": guess.score,
                "reason": guess.reason,
            }
            for rank, guess in enumerate(guesses, start=1)
        ],
    }
