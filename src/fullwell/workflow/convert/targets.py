"""Which files are converted, and where each one goes: all of it settled before anything is written."""

import os
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from fullwell.errors import UsageError
from fullwell.findings import listed
from fullwell.frames.sidecar import sidecar_of
from fullwell.frames.sidecar_writing import sidecar_path
from fullwell.frames.source import PREVIEW_SUFFIXES, RAW_SUFFIXES
from fullwell.raw.presets import read_presets
from fullwell.workflow.convert.settings import FileKind

_ENDINGS: Final[Mapping[str, FileKind]] = {".dng": "dng", ".tif": "tiff", ".tiff": "tiff"}
_SUFFIXES: Final = {"dng": ".dng", "tiff": ".tiff"}


@dataclass(frozen=True, slots=True, kw_only=True)
class Plan:
    """What goes where.

    Parameters
    ----------
    kind
        Of every target.
    targets
        Each source with its target.

    """

    kind: FileKind
    targets: tuple[tuple[Path, Path], ...]


def planned(paths: Sequence[Path], out: Path, *, kind: FileKind | None) -> Plan:
    """Settle where each file goes.

    A folder receives files under their names below the folder that all sources have in common; files of one stem keep
    their old ending before the new one.

    Parameters
    ----------
    paths
        Files, and folders whose raw files are taken at any depth.
    out
        A file ending in .dng, .tif or .tiff for one source, else a folder.
    kind
        What to write; None takes the ending of ``out``, and DNG in a folder.

    Raises
    ------
    UsageError
        Where a source is missing, or ``out`` does not go with the sources.

    """
    sources = _sources(paths, out)
    ending = _ENDINGS.get(out.suffix.lower())
    single = len(paths) == 1 and paths[0].is_file() and not out.is_dir()
    if single and ending is not None:
        if kind not in {None, ending}:
            raise UsageError(f"--format {kind} contradicts the name {out.name}; give one of them.")
        plan = Plan(kind=ending, targets=((sources[0], out),))
    else:
        _require_folder(out, ending=ending, single=single, count=len(sources))
        chosen = kind or "dng"
        names = _names(sources, root=_common_root(paths), suffix=_SUFFIXES[chosen])
        plan = Plan(
            kind=chosen, targets=tuple((source, out / name) for source, name in zip(sources, names, strict=True))
        )
    return plan


def _sources(paths: Sequence[Path], out: Path) -> tuple[Path, ...]:
    endings = RAW_SUFFIXES | {f".{extension}" for extension in read_presets()} | {".npy"}
    found: list[Path] = []
    for path in paths:
        if not path.exists():
            raise UsageError(f"{path} does not exist. Give raw files, or folders of them.")
        inside = [path] if path.is_file() else _below(path, endings, without=out)
        if not inside:
            raise UsageError(f"{path} holds no raw files. Give raw files, or a folder of them.")
        found += inside
    return tuple({os.path.realpath(path): path for path in found}.values())


def _below(folder: Path, endings: Iterable[str], *, without: Path) -> list[Path]:
    """Return the visible raw files below a folder, sorted, but for those in the folder that is written."""
    forbidden = without.resolve()
    return [
        path
        for path in sorted(folder.rglob("*"))
        if path.suffix.lower() in endings
        and path.is_file()
        and not any(part.startswith(".") for part in path.relative_to(folder).parts)
        and not path.resolve().is_relative_to(forbidden)
    ]


def _require_folder(out: Path, *, ending: FileKind | None, single: bool, count: int) -> None:
    if out.is_dir():
        return
    if out.exists():
        wish = "a name that ends in .dng, .tif or .tiff" if single else "a folder"
        raise UsageError(f"{out} is a file; give {wish}.")
    if ending is not None:
        raise UsageError(f"{out} names one file, and {count} are to be converted; give a folder.")
    if out.suffix.lower() in RAW_SUFFIXES | PREVIEW_SUFFIXES:
        raise UsageError(f"{out}: files are converted to DNG and TIFF; give .dng, .tif or .tiff, or a folder.")


def _common_root(paths: Sequence[Path]) -> Path:
    return Path(os.path.commonpath([Path(os.path.abspath(path if path.is_dir() else path.parent)) for path in paths]))  # noqa: PTH100 - links are kept as they are named


def _names(sources: Sequence[Path], *, root: Path, suffix: str) -> list[Path]:
    """Return each target below the folder that is written."""
    inside = [Path(os.path.relpath(source, root)) for source in sources]
    stems = Counter(str(name.with_suffix("")).casefold() for name in inside)
    return [
        name.with_suffix(suffix) if stems[str(name.with_suffix("")).casefold()] == 1 else Path(f"{name}{suffix}")
        for name in inside
    ]


def frame_target(target: Path, frame: str) -> Path:
    """Return where one of several frames of a file goes.

    Examples
    --------
    >>> frame_target(Path("out/burst.dng"), "#07").name, frame_target(Path("out/single.dng"), "").name
    ('burst-07.dng', 'single.dng')

    """
    return target.with_stem(f"{target.stem}{frame.replace('#', '-')}")


def require_free(plan: Plan, targets: Sequence[Path], *, overwrite: bool) -> None:
    """Refuse to write where something is that must stay.

    Parameters
    ----------
    plan
        What is read.
    targets
        Every file that would be written, but for sidecars.
    overwrite
        Whether targets may exist.

    Raises
    ------
    UsageError
        Where a target exists, or would replace a file that is read.

    """
    written = [path for target in targets for path in _written(target, plan.kind)]
    read = {os.path.realpath(path) for source, _target in plan.targets for path in (source, sidecar_of(source)) if path}
    for path in written:
        if os.path.realpath(path) in read:
            raise UsageError(f"{path} is read by this conversion and cannot be written; give another name or folder.")
    if len({os.path.normcase(path) for path in written}) < len(written):
        raise UsageError("Two files would be written under one name; convert them into different folders.")
    folders = [str(path) for path in written if path.is_dir()]
    if folders:
        raise UsageError(f"{folders[0]} is a folder; give another name.")
    existing = [str(path) for path in written if path.exists()]
    if existing and not overwrite:
        raise UsageError(f"{listed(existing)} exists already; give another name or folder, or --overwrite.")


def _written(target: Path, kind: FileKind) -> tuple[Path, ...]:
    return (target,) if kind == "dng" else (target, sidecar_path(target))
