"""Raw files named one by one, as a study of their own."""

import os
from collections.abc import Sequence
from pathlib import Path

from fullwell.errors import UsageError
from fullwell.frames.selection import Selection
from fullwell.frames.series import Camera, Kind, Study
from fullwell.frames.source import Candidate, Source
from fullwell.frames.study import index_source


def load_images(paths: Sequence[Path], selection: Selection, *, kind: Kind) -> Study:
    """Index raw files; no pixel is read.

    Parameters
    ----------
    paths
        The files; one that is named twice counts once.
    selection
        Facts that outrank the files' own, and which files to use.
    kind
        What all of them are.

    Returns
    -------
    Study
        Names are relative to the folder that all files have in common.

    Raises
    ------
    UsageError
        Where a file is missing, or nothing can be measured.

    """
    for path in paths:
        if not path.exists():
            raise UsageError(f"{path} does not exist. Give the raw files of a shot.")
        if path.is_dir():
            raise UsageError(f"{path} is a folder; give the raw files in it, for example {path}/*.dng.")
    whole = sorted({Path(os.path.abspath(path)) for path in paths})  # noqa: PTH100 - links are kept as they are named
    root = Path(os.path.commonpath([path.parent for path in whole]))
    candidates = tuple(Candidate(name=path.relative_to(root).as_posix(), path=path, kind=kind) for path in whole)
    source = Source(root=root, camera=Camera(), candidates=candidates)
    return index_source(source, path=root if len(paths) > 1 else paths[0], selection=selection)
