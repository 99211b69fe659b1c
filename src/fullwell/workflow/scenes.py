"""Raw files named one by one, with their levels and colours known: scenes to be corrected, frames to be converted."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import chain, count
from pathlib import Path
from typing import Final

from fullwell.errors import UsageError
from fullwell.findings import Finding
from fullwell.frames.levels import black_level, white_level
from fullwell.frames.reading import Reading, read_all
from fullwell.frames.selection import Selection
from fullwell.frames.series import Camera, Exclusion, Kind
from fullwell.frames.source import Candidate
from fullwell.raw.cfa import BAYER, MONO
from fullwell.raw.image import Levels, RawHeader

_SUFFIXES: Final = (".dng", ".tif", ".tiff", ".png")


@dataclass(frozen=True, slots=True, kw_only=True)
class Scene:
    """One raw file to be corrected or converted.

    Parameters
    ----------
    path
        The file.
    frame
        Which of the frames of the file it is, ``#3``; empty where there is one only.
    name
        Its files' name without a suffix, different for every scene.
    header
        What the file and its sidecar say.
    cfa
        Order at the visible top-left pixel, or ``mono``.
    black_level
        Per CFA site; None where nobody declares one.
    white_level
        Per CFA site.
    bit_depth
        From the camera, the sidecar or the file, in this order [bit].
    findings
        What reading the header and the sidecar brought to light.

    """

    path: Path
    frame: str
    name: str
    header: RawHeader
    cfa: str
    black_level: Levels | None
    white_level: Levels
    bit_depth: int
    findings: tuple[Finding, ...] = ()


def scene_files(paths: Sequence[Path]) -> tuple[Path, ...]:
    """Return the files that a user named: files as they are, folders by the raw files directly in them.

    Raises
    ------
    UsageError
        Where a path does not exist, or a folder holds no raw file.

    """
    found: list[Path] = []
    for path in paths:
        if not path.exists():
            raise UsageError(f"{path} does not exist. Give raw files, or a folder of them.")
        inside = [path] if path.is_file() else sorted(one for one in path.iterdir() if one.suffix.lower() in _SUFFIXES)
        if not inside:
            raise UsageError(f"{path} holds no raw files ({', '.join(_SUFFIXES)}). Give raw files, or their folder.")
        found += inside
    return tuple(dict.fromkeys(found))


def read_scenes(files: Sequence[Path], selection: Selection) -> tuple[tuple[Scene, ...], tuple[Exclusion, ...]]:
    """Read the headers of scenes.

    Parameters
    ----------
    files
        Raw files.
    selection
        The user's CFA, levels and camera facts, above what the files say.

    Returns
    -------
    tuple
        The scenes, and the files that cannot be used, each with its reason.

    """
    camera = selection.camera or Camera()
    candidates = [Candidate(name=str(path), path=path, kind=Kind.SCENE) for path in files]
    stated = None if selection.headerless is None else (selection.headerless, "--headerless")
    readings, excluded = read_all(candidates, camera=camera, cfa=selection.cfa, headerless=stated)
    names = _names([Path(one.frame.name) for one in readings])
    scenes: list[Scene] = []
    refused = list(excluded)
    for reading, name in zip(readings, names, strict=True):
        if reading.frame.header.cfa is None:
            reason = f"nothing says its colour-filter array; give --cfa ({', '.join((*BAYER, MONO))})"
            refused.append(Exclusion(name=reading.frame.name, code="cfa-unknown", reason=reason))
        else:
            scenes.append(_scene(reading, name, selection=selection, camera=camera))
    return tuple(scenes), tuple(refused)


def _scene(reading: Reading, name: str, *, selection: Selection, camera: Camera) -> Scene:
    header = reading.frame.header
    cfa = header.cfa or MONO
    white = white_level([reading], selection=selection, camera=camera, cfa=cfa, bit_depth=reading.bit_depth)
    highest = float(2**reading.bit_depth - 1)
    return Scene(
        path=header.path,
        frame=reading.frame.name.removeprefix(str(header.path)),
        name=name,
        header=header,
        cfa=cfa,
        black_level=black_level([reading], selection=selection, camera=camera, cfa=cfa),
        white_level=white or Levels(values=(highest,) * (1 if cfa == MONO else 4), source="default"),
        bit_depth=reading.bit_depth,
        findings=reading.findings,
    )


def _names(paths: Iterable[Path]) -> list[str]:
    """Return the stems of files; one that is taken already gets a number."""
    names: list[str] = []
    for path in paths:
        numbered = (f"{path.stem}_{number}" for number in count(2))
        names.append(next(name for name in chain([path.stem], numbered) if name not in names))
    return names
