"""A study folder's files: found in any depth, sorted, each with the kind its folder names (RESULTS 1)."""

import os
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path

from fullwell.errors import UsageError
from fullwell.files import RESULTS, RESULTS_SCHEMA, holds_document
from fullwell.findings import Finding, Severity, listed
from fullwell.frames.role import kind_of_folder
from fullwell.frames.series import Camera, Kind
from fullwell.frames.source import COMPANION_SUFFIXES, PREVIEW_SUFFIXES, RAW_SUFFIXES, Candidate, Source
from fullwell.raw.presets import read_presets
from fullwell.raw.remote import Entry, RemotePath

_KINDS_SENTENCE = "Frames belong in folders named dark, bias, flat, chart or scene (any depth below them)"

_Entry = os.DirEntry[str] | Entry

_CACHE_TAG = "CACHEDIR.TAG"
"""Holds a folder of what can be made again, such as finished series of ours."""


@dataclass(slots=True, kw_only=True)
class _Search:
    """What a walk has met so far."""

    presets: frozenset[str]
    headerless: bool
    candidates: list[Candidate] = field(default_factory=list[Candidate])
    left_out: list[str] = field(default_factory=list[str])
    loose: list[str] = field(default_factory=list[str])
    unknown: list[str] = field(default_factory=list[str])
    previews: int = 0
    files: int = 0
    visited: set[tuple[str, Kind | None]] = field(default_factory=set[tuple[str, Kind | None]])
    taken: set[tuple[str, Kind]] = field(default_factory=set[tuple[str, Kind]])
    duplicates: list[str] = field(default_factory=list[str])
    no_text: list[str] = field(default_factory=list[str])


def discover(root: Path, *, headerless: bool = False) -> Source:
    """Find the frames of a study folder.

    Symbolic links are followed; a folder or file that is reached twice within one kind counts once. Files with an
    extension that has a preset are frames too.

    Parameters
    ----------
    root
        The folder.
    headerless
        Whether files of unknown endings are frames: somebody has said how they are stored.

    Raises
    ------
    UsageError
        Where the folder holds nothing that could be measured; the sentence says what was found instead.

    """
    search = _Search(presets=frozenset(f".{extension}" for extension in read_presets()), headerless=headerless)
    _walk(root, prefix="", kind=None, search=search)
    if not search.candidates:
        raise UsageError(_nothing_found(root, search))
    return Source(
        root=root,
        camera=Camera(),
        candidates=tuple(sorted(search.candidates, key=lambda one: (one.name, one.kind))),
        findings=tuple(_findings(search)),
    )


def _walk(folder: Path, *, prefix: str, kind: Kind | None, search: _Search) -> bool:
    """Collect what lies below a folder; return whether a folder named for a kind was met.

    Results in the study are no part of it, nor are the simulated frames that a loop or a demo keeps among them.
    """
    identity = (os.path.realpath(folder), kind)
    if identity in search.visited or (folder / _CACHE_TAG).is_file():
        return False
    search.visited.add(identity)
    folders, files = _entries(folder)
    if prefix and _holds_results(folder, files):
        return False
    _collect(folder, files, prefix=prefix, kind=kind, search=search)
    met = False
    nameless: list[str] = []
    for entry in folders:
        name = f"{prefix}{entry.name}"
        below = kind or kind_of_folder(entry.name)
        if _walk(folder / entry.name, prefix=f"{name}/", kind=below, search=search) or below is not None:
            met = True
        elif not _is_our_output(folder / entry.name):
            nameless.append(_as_text(name))
    if kind is None and (met or not prefix):
        search.left_out += nameless
    return met


def _entries(folder: Path) -> tuple[list[_Entry], list[_Entry]]:
    """Return the visible folders (links last, so that a folder's own name wins) and files, sorted by name."""
    try:
        visible = sorted((one for one in _listing(folder) if not one.name.startswith(".")), key=lambda one: one.name)
    except OSError as error:
        raise UsageError(f"Cannot read the folder {folder}: {error.strerror}.") from error
    folders = [entry for entry in visible if entry.is_dir()]
    return sorted(folders, key=lambda entry: entry.is_symlink()), [entry for entry in visible if not entry.is_dir()]


def _listing(folder: Path) -> list[_Entry]:
    if isinstance(folder, RemotePath):
        return [*folder.entries()]
    with os.scandir(folder) as scan:
        return [*scan]


def _collect(folder: Path, files: list[_Entry], *, prefix: str, kind: Kind | None, search: _Search) -> None:
    developed = {Path(entry.name).stem for entry in files if Path(entry.name).suffix.lower() == ".dng"}
    for entry in files:
        path, suffix = f"{prefix}{entry.name}", Path(entry.name).suffix.lower()
        name = _as_text(path)
        search.files += 1
        if not _is_frame(suffix, search):
            search.previews += suffix in PREVIEW_SUFFIXES
            if suffix not in COMPANION_SUFFIXES and kind is not None:
                search.unknown.append(name)
        elif suffix == ".png" and Path(entry.name).stem in developed:
            search.previews += 1
        elif kind is None:
            search.loose.append(name)
        elif name != path:
            search.no_text.append(name)
        elif (identity := (os.path.realpath(folder / entry.name), kind)) in search.taken:
            search.duplicates.append(name)
        else:
            search.taken.add(identity)
            search.candidates.append(Candidate(name=name, path=folder / entry.name, kind=kind))


def _as_text(name: str) -> str:
    """Return a name with its bytes written out where they are no text, and cannot stand in results."""
    return name.encode("utf-8", "backslashreplace").decode()


def _is_frame(suffix: str, search: _Search) -> bool:
    if suffix in RAW_SUFFIXES or suffix in search.presets:
        return True
    return search.headerless and suffix not in COMPANION_SUFFIXES


def _holds_results(folder: Path, files: list[_Entry]) -> bool:
    there = any(entry.name == RESULTS for entry in files)
    return there and holds_document(folder, RESULTS, schema=RESULTS_SCHEMA)


def _is_our_output(folder: Path) -> bool:
    """Tell folders of results, of finished series, and of what a simulated study was made from."""
    simulated = folder.name == "inputs" and (folder.parent / "truth.json").is_file()
    return simulated or (folder / RESULTS).is_file() or (folder / _CACHE_TAG).is_file()


def _findings(search: _Search) -> Iterator[Finding]:
    if search.left_out:
        names = tuple(sorted(search.left_out))
        yield Finding(
            code="folders-left-out",
            severity=Severity.INFO,
            message=f"Left out, their names tell no kind of capture: {listed(names)}. {_KINDS_SENTENCE}.",
            files=names,
        )
    root_files = tuple(sorted(name for name in search.loose if "/" not in name))
    if root_files:
        yield Finding(
            code="files-left-out",
            severity=Severity.INFO,
            message=f"Left out, they lie in no capture folder: {listed(root_files)}. {_KINDS_SENTENCE}.",
            files=root_files,
        )
    if search.unknown:
        yield Finding(
            code="files-unknown",
            severity=Severity.INFO,
            message=f"Passed over, no raw format has this ending: {listed(sorted(search.unknown))}.",
            files=tuple(sorted(search.unknown)),
        )
    if search.no_text:
        names = tuple(sorted(search.no_text))
        yield Finding(
            code="name-no-text",
            severity=Severity.ERROR,
            message=f"Left out, their names are no text in UTF-8: {listed(names)}; rename them.",
            files=names,
        )
    if search.duplicates:
        yield Finding(
            code="files-twice",
            severity=Severity.INFO,
            message="Links to files that are already in the study: each frame counts once.",
            files=tuple(sorted(search.duplicates)),
        )


def _nothing_found(root: Path, search: _Search) -> str:
    if search.loose:
        return (
            f"{root} holds {len(search.loose)} raw files, but in no folder that says what they were taken for "
            f"(the first: {min(search.loose)}). {_KINDS_SENTENCE}; or list them in a study.toml."
        )
    if search.previews:
        return (
            f"{root} holds only processed pictures such as JPEG ({search.previews} of them), whose noise was "
            "changed by the camera. Give a folder of raw frames: DNG, or mosaic TIFF or PNG."
        )
    if search.files:
        return f"{root} holds no raw frames (DNG, or mosaic TIFF or PNG). {_KINDS_SENTENCE}."
    return f"{root} is empty. {_KINDS_SENTENCE}."
