"""Folders that appear whole or not at all, and that replace nothing but what we wrote ourselves."""

import json
import tempfile
from collections.abc import Generator
from contextlib import contextmanager
from pathlib import Path
from typing import cast


@contextmanager
def replaced_folder(out: Path) -> Generator[Path]:
    """Provide an empty folder that takes the place of ``out`` where the block ends without an exception.

    Whatever goes wrong, and whenever, what was at ``out`` before is there afterwards. It is deleted only when the new
    folder stands in its place.

    Parameters
    ----------
    out
        Where the folder is to stand; its parents are made. Whether it may be replaced is for the caller to know.

    Yields
    ------
    Path
        A folder beside ``out``.

    """
    target = out.resolve()
    target.parent.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(
        prefix=f".{target.name}-", suffix=".partial", dir=target.parent, ignore_cleanup_errors=True
    ) as workshop:
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


def holds_document(folder: Path, name: str, *, schema: str) -> bool:
    """Tell whether a folder holds a JSON document of ours: an object whose ``schema`` is the given one."""
    try:
        document: object = json.loads((folder / name).read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return False
    return isinstance(document, dict) and cast("dict[str, object]", document).get("schema") == schema
