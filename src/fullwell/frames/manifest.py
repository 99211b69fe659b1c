"""``study.toml``: the manifest that says which files are what (RESULTS 1), read with care and written from a study.

Reading raises `UsageError` with the key, its value and what is allowed. Writing keeps what the files say for
themselves out of the way: levels from metadata stand as comments, so that a manifest that nobody edited measures the
same as the folder.
"""

import glob
import json
import os
from collections.abc import Iterator, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Final

from fullwell.errors import UsageError
from fullwell.frames.campaign import Campaign
from fullwell.frames.series import CONTAINER_BITS, Camera, Kind, Light, Series, Study
from fullwell.frames.source import Candidate, Given, Source
from fullwell.raw.headerless_format import HeaderlessFormat, format_from, format_lines
from fullwell.raw.image import Levels

MANIFEST_NAME: Final = "study.toml"


def read_manifest(path: Path) -> Source:
    """Read a manifest and find the files it lists.

    Parameters
    ----------
    path
        The manifest; patterns in ``files`` are relative to its folder.

    Raises
    ------
    UsageError
        Where the manifest cannot be read or says something that is not allowed, where a pattern matches no file, or
        where a file is listed in two series.

    """
    from fullwell.frames.manifest_tables import ManifestTables, validated  # noqa: PLC0415 - pydantic loads when used

    manifest = validated(ManifestTables, path)
    root = path.parent
    candidates: list[Candidate] = []
    listed: dict[str, int] = {}
    for number, table in enumerate(manifest.series, start=1):
        if table.kind in {Kind.DARK, Kind.BIAS} and (table.photons or table.irradiance_uw_cm2):
            raise UsageError(
                f"{path}: series[{number}] is {table.kind}, where there is no light; leave its photons out."
            )
        given = Given(**table.model_dump(exclude={"kind", "files"}))
        for name in _matches(table.files, root=root, where=f"{path}: series[{number}].files"):
            if name in listed:
                raise UsageError(
                    f"{path}: {name} is listed in series[{listed[name]}] and in series[{number}]; "
                    "a frame belongs to one."
                )
            listed[name] = number
            candidates.append(Candidate(name=name, path=root / name, kind=Kind(table.kind), given=given))
    ordered = sorted(candidates, key=lambda one: (one.name, one.kind))
    stated = manifest.headerless
    return Source(
        root=root,
        camera=manifest.camera.camera,
        candidates=tuple(ordered),
        headerless=None if stated is None else format_from(stated, where=f"{path}: [headerless]"),
        light=manifest.light.light,
        campaign=manifest.emva.campaign,
    )


def read_camera(path: Path) -> Camera:
    """Read the ``[camera]`` table of a TOML file.

    Raises
    ------
    UsageError
        Where the file has none, or it says something that is not allowed.

    """
    from fullwell.frames.manifest_tables import CameraFile, validated  # noqa: PLC0415 - pydantic loads when used

    return validated(CameraFile, path).camera.camera


def _matches(patterns: Sequence[str], *, root: Path, where: str) -> list[str]:
    """Return the names of the files that patterns match, sorted; a name without wildcards stands for itself."""
    names: set[str] = set()
    for pattern in patterns:
        if not pattern or Path(pattern).is_absolute():
            raise UsageError(f'{where}: "{pattern}" must be a path relative to the manifest.')
        literal = root / pattern
        found = [literal] if literal.is_file() else [path for path in root.glob(pattern) if path.is_file()]
        if not found:
            raise UsageError(f'{where}: "{pattern}" matches no file below {root}.')
        names |= {Path(os.path.relpath(path, root)).as_posix() for path in found}
    return sorted(names)


def write_manifest(study: Study, *, folder: Path | None = None) -> str:
    """Return a manifest of a study as TOML text, to be corrected by hand.

    A pattern stands for files only where it matches exactly the frames of one series; else they are listed by name.

    Parameters
    ----------
    study
        What to describe.
    folder
        Folder the manifest will stand in, which its patterns are relative to; None is the study's own.

    """
    base = study.root if folder is None else folder
    inside = "" if folder is None else _prefix(study.root, folder)
    lines = [
        "# What Fullwell takes these files for. Correct what is wrong; a value given here outranks the files' own.",
        "",
        "[camera]",
        *_camera_lines(study),
        *_light_lines(study.light),
        *_campaign_lines(study.campaign),
        *_headerless_lines(study),
    ]
    for series in study.series:
        lines += ["", "[[series]]", *_series_lines(series, base=base, inside=inside)]
    if study.excluded:
        lines += ["", "# Left out:"]
        lines += [f"# {one.name}: {one.reason}".replace("\n", " ") for one in study.excluded]
    return "\n".join(lines) + "\n"


def _camera_lines(study: Study) -> Iterator[str]:
    camera = study.camera
    yield _line("name", camera.name, example='"IMX541"')
    container_only = study.bit_depth == CONTAINER_BITS and study.white_level is None
    yield _line("bit_depth", None if container_only else study.bit_depth, example="12")
    yield _line("cfa", study.cfa)
    yield _level_line("black_level", study.black_level)
    yield _level_line("white_level", study.white_level)
    yield _line("pixel_pitch_um", camera.pixel_pitch_um, example="2.74")
    if camera.pixel_area_um2 is not None:
        yield _line("pixel_area_um2", camera.pixel_area_um2)
    yield _line("voltage_swing_v", camera.voltage_swing_v, example="0.459")
    yield _line("base_iso", camera.base_iso, example="100")
    yield _line("focal_length_mm", camera.focal_length_mm, example="4.38")


def _light_lines(light: Light) -> Iterator[str]:
    if light != Light():
        yield from ("", "[light]")
        for name, value in asdict(light).items():
            if value is not None:
                yield f"{name} = {str(value).lower()}" if isinstance(value, bool) else _line(name, value)


def _campaign_lines(campaign: Campaign) -> Iterator[str]:
    if campaign != Campaign():
        yield from ("", "[emva]")
        yield from (_line(name, value) for name, value in asdict(campaign).items() if value is not None)


def _headerless_lines(study: Study) -> list[str]:
    """Return how the frames without a header are stored, where all of them are stored alike."""
    layouts = [frame.header.layout for series in study.series for frame in series.frames]
    stated = {layout for layout in layouts if isinstance(layout, HeaderlessFormat)}
    return ["", "[headerless]", *format_lines(stated.pop())] if len(stated) == 1 else []


def _level_line(key: str, levels: Levels | None) -> str:
    if levels is None:
        return f"# {key} =   # DN: the files do not say"
    values = levels.values[:1] if len(set(levels.values)) == 1 else levels.values
    text = _written(values[0]) if len(values) == 1 else "[" + ", ".join(_written(value) for value in values) + "]"
    if levels.source in {"user", "manifest"}:
        return f"{key} = {text}"
    return f"# {key} = {text}   # DN, from: {levels.source}"


def _series_lines(series: Series, *, base: Path, inside: str) -> Iterator[str]:
    yield _line("kind", series.kind.value)
    names = [inside + frame.name for frame in series.frames]
    patterns = [json.dumps(pattern, ensure_ascii=False) for pattern in _patterns(names, base=base)]
    if len(patterns) == 1:
        yield f"files = [{patterns[0]}]"
    else:
        yield "files = ["
        yield from (f"  {pattern}," for pattern in patterns)
        yield "]"
    yield _line("exposure_s", series.exposure_s, example="0.01")
    yield _line("iso", series.iso, example="100")
    if series.photons is not None:
        yield _line("photons", series.photons)
    if series.stack is not None:
        yield f"stack = {str(series.stack).lower()}"
    yield _line("temperature_c", series.temperature_c, example="20.0")


def _prefix(root: Path, folder: Path) -> str:
    """Return what stands before a frame's name in a manifest that lies in another folder."""
    relative = Path(os.path.relpath(root.resolve(), folder.resolve())).as_posix()
    return "" if relative == "." else f"{relative}/"


def _patterns(paths: Sequence[str], *, base: Path) -> list[str]:
    """Return one pattern per folder and ending where it matches exactly these files, else their names."""
    groups: dict[tuple[str, str], list[str]] = {}
    for path in paths:
        folder, _slash, name = path.rpartition("/")
        groups.setdefault((folder, Path(name).suffix), []).append(name)
    patterns: list[str] = []
    for (folder, suffix), names in sorted(groups.items()):
        inside = f"{folder}/" if folder else ""
        stem = _shared_start(min(names), max(names)).removesuffix(suffix)
        wildcards = [
            f"{glob.escape(inside + start)}*{glob.escape(suffix)}" for start in ("", stem.rstrip("0123456789"), stem)
        ]
        wanted = {inside + name for name in names}
        exact = [pattern for pattern in wildcards if len(names) > 1 and _on_disk(base, pattern) == wanted]
        patterns += exact[:1] or sorted(wanted)
    return patterns


def _shared_start(first: str, last: str) -> str:
    """Return the letters that two names begin with alike."""
    length = min(len(first), len(last))
    return first[: next((at for at in range(length) if first[at] != last[at]), length)]


def _on_disk(root: Path, pattern: str) -> set[str]:
    try:
        return {Path(os.path.relpath(path, root)).as_posix() for path in root.glob(pattern) if path.is_file()}
    except (OSError, ValueError):
        return set()


def _line(key: str, value: float | str | None, *, example: str = "") -> str:
    return f"# {key} = {example}".rstrip() if value is None else f"{key} = {_written(value)}"


def _written(value: float | str) -> str:
    if isinstance(value, str):
        return json.dumps(value, ensure_ascii=False)
    return str(int(value)) if float(value).is_integer() and abs(value) < 1e15 else repr(float(value))
