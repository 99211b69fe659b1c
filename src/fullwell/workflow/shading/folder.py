"""The folder a shading command writes: whole or not at all, and only in place of a folder of its own."""

import json
from collections.abc import Generator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Final, cast

from fullwell.errors import UsageError
from fullwell.files import holds_document, replaced_folder
from fullwell.findings import Finding, listed
from fullwell.report.document import plain
from fullwell.workflow.options import Options
from fullwell.workflow.run import run_facts

DOCUMENT: Final = "shading.json"
SCHEMA: Final = "fullwell-shading/1"


@dataclass(frozen=True, slots=True, kw_only=True)
class ShadingOutcome:
    """What a shading command wrote.

    Parameters
    ----------
    out
        The folder.
    document
        What ``shading.json`` in it says.
    findings
        What is to be said about the data.

    """

    out: Path
    document: Mapping[str, object]
    findings: tuple[Finding, ...]


def check_shading_target(out: Path, *inputs: Path) -> None:
    """Say before the work starts whether the results could be written.

    Parameters
    ----------
    out
        A missing or empty folder, or one that a shading command wrote and nobody added to.
    inputs
        What the command reads: none of it may lie in the folder.

    Raises
    ------
    UsageError
        Where ``out`` is a file, or replacing it would lose something.

    """
    target = out.resolve()
    if target.exists() and not target.is_dir():
        raise UsageError(f"{out} is a file; name a folder for the results with -o.")
    for one in inputs:
        source = one.resolve()
        if source == target or target in source.parents:
            raise UsageError(f"{out} holds {one}, and results would replace it; name another folder with -o.")
    if not target.is_dir() or not any(target.iterdir()):
        return
    if not holds_document(target, DOCUMENT, schema=SCHEMA):
        raise UsageError(
            f"{out} holds something other than results of `fullwell shading` and is left untouched; name a new or "
            "empty folder with -o."
        )
    foreign = sorted(_files(target) - _own(target) - {DOCUMENT})
    if foreign:
        raise UsageError(
            f"{out} would be replaced, but beside the results of `fullwell shading` it holds {listed(foreign)}; move "
            "that away or name another folder with -o."
        )


@contextmanager
def shading_folder(out: Path, *inputs: Path) -> Generator[Path]:
    """Provide the folder to write into; it takes the place of ``out`` where the block ends without an exception."""
    check_shading_target(out, *inputs)
    with replaced_folder(out) as folder:
        yield folder


def write_document(
    folder: Path,
    command: str,
    said: Mapping[str, object],
    *,
    findings: Sequence[Finding],
    options: Options,
    study: Path,
    out: Path,
    started: float,
) -> Mapping[str, object]:
    """Write ``shading.json``, the last file of a folder, and return what it says.

    Parameters
    ----------
    folder
        With everything else in it: its files are listed, so that a later run knows them for ours.
    command
        ``fit``, ``compare`` or ``apply``.
    said
        The command's own part.
    findings
        What is to be said about the data.
    options
        Workers and selection.
    study
        What was read.
    out
        Where the folder will stand.
    started
        When the work began, by the monotonic clock [s].

    """
    document = {
        "schema": SCHEMA,
        "command": command,
        **said,
        "findings": [
            {"code": one.code, "severity": one.severity, "message": one.message, "files": one.files} for one in findings
        ],
        "files": sorted(_files(folder)),
        "run": run_facts(study=study, out=out, options=options, started=started),
    }
    ready = cast("Mapping[str, object]", plain(document))
    text = json.dumps(ready, indent=1, ensure_ascii=False, allow_nan=False) + "\n"
    (folder / DOCUMENT).write_text(text, encoding="utf-8", newline="\n")
    return ready


def _files(folder: Path) -> set[str]:
    return {path.relative_to(folder).as_posix() for path in folder.rglob("*") if not path.is_dir()}


def _own(folder: Path) -> set[str]:
    """Return the files that the folder's document lists."""
    document = cast("Mapping[str, object]", json.loads((folder / DOCUMENT).read_text(encoding="utf-8")))
    names = document.get("files")
    return {str(name) for name in cast("Sequence[object]", names)} if isinstance(names, list) else set()
