"""Folders that appear whole or not at all, and that replace nothing but what we wrote ourselves."""

import errno
import glob
import json
import os
import shutil
import sys
import tempfile
import time
from collections.abc import Container, Generator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Final, cast

RESULTS: Final = "results.json"
RESULTS_SCHEMA: Final = "fullwell-results/1"
"""Of `RESULTS`, by which a folder of results is known."""
_FULL: Final = frozenset({errno.ENOSPC, errno.EDQUOT, errno.EFBIG})
"""What the system says where no more can be written."""
_DESKTOP: Final = frozenset({".DS_Store", "Thumbs.db", "desktop.ini"})
"""Files that desktops leave in any folder they show."""
_YOUNG_S: Final = 60.0
"""A folder in the making that is younger may not be held yet [s]."""


@contextmanager
def replaced_folder(out: Path) -> Generator[Path]:
    """Provide an empty folder that takes the place of ``out`` where the block ends without an exception.

    Whatever goes wrong, and whenever, what was at ``out`` before is there afterwards. It is deleted only when the new
    folder stands in its place. What a process that was killed left of an earlier try is deleted first.

    Parameters
    ----------
    out
        Where the folder is to stand; its parents are made. Whether it may be replaced is for the caller to know.

    Yields
    ------
    Path
        A folder beside ``out``.

    Raises
    ------
    OSError
        ``out`` may not be written to, or a disk is mounted there: nothing can take its place.

    """
    target = out.resolve()
    hindrance = _hindrance(target) if target.exists() else None
    if hindrance is not None:
        raise OSError(hindrance, os.strerror(hindrance), str(out))
    target.parent.mkdir(parents=True, exist_ok=True)
    for left in target.parent.glob(f".{glob.escape(target.name)}-*.partial"):
        _remove_abandoned(left, target)
    with (
        tempfile.TemporaryDirectory(
            prefix=f".{target.name}-", suffix=".partial", dir=target.parent, ignore_cleanup_errors=True
        ) as workshop,
        _held(Path(workshop)),
        fullness_named(out),
    ):
        fresh = Path(workshop) / "fresh"
        fresh.mkdir()
        yield fresh
        former = Path(f"{workshop}.former")
        try:
            if target.exists():
                target.rename(former)
            fresh.rename(target)
        except BaseException:
            if former.exists() and not target.exists():
                former.rename(target)
            raise
        if former.exists():
            former.rename(Path(workshop) / "former")


def _hindrance(target: Path) -> int | None:
    """Return why a folder cannot be replaced, as the system would say at the end of the work."""
    if os.path.ismount(target):
        return errno.EBUSY
    return None if os.access(target, os.W_OK) else errno.EACCES


@contextmanager
def fullness_named(place: Path) -> Generator[None]:
    """Let the error of a full disk name what was written to: the system names none where a file is open already."""
    try:
        yield
    except OSError as error:
        if error.errno in _FULL and error.filename is None:
            error.filename = str(place)
        raise


@contextmanager
def _held(folder: Path) -> Generator[bool]:
    """Hold a folder until the block ends or the process dies, and tell whether it is held: not every system can."""
    if sys.platform == "win32":
        yield False
        return
    import fcntl  # noqa: PLC0415 - not everywhere

    descriptor = os.open(folder, os.O_RDONLY)
    try:
        try:
            fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
            held = True
        except OSError:
            held = False
        yield held
    finally:
        os.close(descriptor)


def _remove_abandoned(folder: Path, target: Path) -> None:
    """Remove a folder in the making that no process holds any more; what it was to replace goes back to its place."""
    with suppress(OSError):
        if time.time() - folder.stat().st_mtime <= _YOUNG_S:
            return
        with _held(folder) as abandoned:
            if not abandoned:
                return
            former = Path(f"{folder}.former")
            if former.exists():
                former.rename(folder / "former" if target.exists() else target)
            shutil.rmtree(folder, ignore_errors=True)


def foreign_in(folder: Path, own: Container[str]) -> list[str]:
    """Return the names of what a folder holds beside what is ours and what desktops leave there."""
    return sorted(one.name for one in folder.iterdir() if one.name not in own and one.name not in _DESKTOP)


def holds_document(folder: Path, name: str, *, schema: str) -> bool:
    """Tell whether a folder holds a JSON document of ours: an object whose ``schema`` is the given one."""
    try:
        document: object = json.loads((folder / name).read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return False
    return isinstance(document, dict) and cast("dict[str, object]", document).get("schema") == schema
