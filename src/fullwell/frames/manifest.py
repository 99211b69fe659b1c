"""``study.toml``: the manifest that says which files are what (RESULTS 1), read with care and written from a study.

Reading raises `UsageError` with the key, its value and what is allowed. Writing keeps what the files say for
themselves out of the way: levels from metadata stand as comments, so that a manifest that nobody edited measures the
same as the folder.
"""

import glob
import json
import os
import tomllib
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Annotated, Final, Literal, TypeVar

from pydantic import BaseModel, ConfigDict, Discriminator, Field, Tag, ValidationError

from fullwell.errors import UsageError
from fullwell.frames.series import CONTAINER_BITS, HIGHEST_CODE, Camera, Kind, Series, Study
from fullwell.frames.source import Candidate, Given, Source
from fullwell.raw.headerless_format import HeaderlessFormat, format_from, format_lines
from fullwell.raw.image import Levels

MANIFEST_NAME: Final = "study.toml"

_Positive = Annotated[float, Field(gt=0.0, allow_inf_nan=False)]
_Number = Annotated[float, Field(allow_inf_nan=False)]
_Level = Annotated[float, Field(ge=0.0, le=HIGHEST_CODE)]
_Levels = Annotated[list[_Level], Field(min_length=1, max_length=4)]
_Table = TypeVar("_Table", bound=BaseModel)


def _form(value: object) -> str:
    return "sites" if isinstance(value, list) else "level"


_Black = Annotated[Annotated[_Level, Tag("level")] | Annotated[_Levels, Tag("sites")], Discriminator(_form)]


class _CameraTable(BaseModel):
    model_config = ConfigDict(extra="forbid", strict=True)

    name: str | None = None
    bit_depth: Annotated[int, Field(ge=1, le=16)] | None = None
    cfa: Literal["RGGB", "GRBG", "GBRG", "BGGR", "mono"] | None = None
    black_level: _Black | None = None
    white_level: Annotated[float, Field(ge=1.0, le=HIGHEST_CODE)] | None = None
    pixel_pitch_um: _Positive | None = None
    voltage_swing_v: _Positive | None = None
    base_iso: _Positive | None = None
    focal_length_mm: _Positive | None = None


class _SeriesTable(BaseModel):
    model_config = ConfigDict(extra="forbid", strict=True)

    kind: Literal["flat", "dark", "bias", "chart", "scene"]
    files: Annotated[list[str], Field(min_length=1)]
    exposure_s: _Positive | None = None
    iso: _Positive | None = None
    photons: Annotated[float, Field(ge=0.0, allow_inf_nan=False)] | None = None
    temperature_c: _Number | None = None


class _Manifest(BaseModel):
    model_config = ConfigDict(extra="forbid", strict=True)

    camera: _CameraTable = _CameraTable()
    headerless: dict[str, int | str] | None = None
    series: Annotated[list[_SeriesTable], Field(min_length=1)]


class _CameraFile(BaseModel):
    model_config = ConfigDict(extra="ignore", strict=True)

    camera: _CameraTable


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
    manifest = _validated(_Manifest, path)
    root = path.parent
    candidates: list[Candidate] = []
    listed: dict[str, int] = {}
    for number, table in enumerate(manifest.series, start=1):
        given = Given(
            iso=table.iso, exposure_s=table.exposure_s, temperature_c=table.temperature_c, photons=table.photons
        )
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
        camera=_camera(manifest.camera),
        candidates=tuple(ordered),
        headerless=None if stated is None else format_from(stated, where=f"{path}: [headerless]"),
    )


def read_camera(path: Path) -> Camera:
    """Read the ``[camera]`` table of a TOML file.

    Raises
    ------
    UsageError
        Where the file has none, or it says something that is not allowed.

    """
    return _camera(_validated(_CameraFile, path).camera)


def _validated(model: type[_Table], path: Path) -> _Table:
    try:
        document = tomllib.loads(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise UsageError(f"Cannot read {path}: {error.strerror}.") from error
    except ValueError as error:
        raise UsageError(f"{path} is not valid TOML: {error}.") from error
    try:
        return model.model_validate(document)
    except ValidationError as error:
        sentences = [_sentence(one["loc"], one["msg"], one["input"], one["type"]) for one in error.errors()]
        unique = list(dict.fromkeys(sentences))
        raise UsageError(f"{path}: " + " ".join(unique)) from error


def _sentence(loc: Sequence[int | str], message: str, value: object, reason: str) -> str:
    """Say what is wrong with one key; lists are counted from 1, as people do."""
    key = ""
    for part in loc:
        if isinstance(part, int):
            key += f"[{part + 1}]"
        elif part not in {"level", "sites"}:
            key += f".{part}" if key else part
    if reason == "missing":
        return f"{key} is missing."
    if reason == "extra_forbidden":
        return f"{key} is not a key of the manifest; {_allowed_keys(loc)}."
    wish = message.removeprefix("Input should be ").removeprefix("a valid ")
    return f"{key} = {_toml(value)} is not allowed: it should be {wish}."


def _allowed_keys(loc: Sequence[int | str]) -> str:
    if loc[0] == "camera" and len(loc) > 1:
        return "[camera] knows " + ", ".join(_CameraTable.model_fields)
    if loc[0] == "series" and len(loc) > 2:
        return "[[series]] knows " + ", ".join(_SeriesTable.model_fields)
    return "it knows the tables [camera], [headerless] and [[series]]"


def _camera(table: _CameraTable) -> Camera:
    levels = table.black_level
    return Camera(
        name=table.name,
        bit_depth=table.bit_depth,
        cfa=table.cfa,
        black_level=None if levels is None else tuple(levels) if isinstance(levels, list) else (levels,),
        white_level=table.white_level,
        pixel_pitch_um=table.pixel_pitch_um,
        voltage_swing_v=table.voltage_swing_v,
        base_iso=table.base_iso,
        focal_length_mm=table.focal_length_mm,
    )


def _matches(patterns: Sequence[str], *, root: Path, where: str) -> list[str]:
    """Return the names of the files that patterns match, sorted; a name without wildcards stands for itself."""
    names: set[str] = set()
    for pattern in patterns:
        if not pattern or Path(pattern).is_absolute():
            raise UsageError(f"{where}: {_toml(pattern)} must be a path relative to the manifest.")
        literal = root / pattern
        found = [literal] if literal.is_file() else [path for path in root.glob(pattern) if path.is_file()]
        if not found:
            raise UsageError(f"{where}: {_toml(pattern)} matches no file below {root}.")
        names |= {Path(os.path.relpath(path, root)).as_posix() for path in found}
    return sorted(names)


def _toml(value: object) -> str:
    """Write a value as TOML does, for messages."""
    if isinstance(value, str):
        return f'"{value}"'
    if isinstance(value, bool):
        return str(value).lower()
    return str(value)


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
    yield _line("voltage_swing_v", camera.voltage_swing_v, example="0.459")
    yield _line("base_iso", camera.base_iso, example="100")
    yield _line("focal_length_mm", camera.focal_length_mm, example="4.38")


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
