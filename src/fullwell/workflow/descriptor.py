"""A study written as descriptors of the ``emva1288`` package: one for each channel and ISO, images as 16-bit PNG."""

import json
from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from fullwell.errors import UsageError
from fullwell.files import replaced_folder
from fullwell.frames.selection import Selection
from fullwell.frames.series import Frame, Kind, Series, Study
from fullwell.frames.study import load_study
from fullwell.raw.cfa import cell, channels
from fullwell.raw.open import decode, read_bytes
from fullwell.raw.png_writing import write_png

_PAIR = 2
_FEWEST_IN_STACK = 3


@dataclass(frozen=True, slots=True, kw_only=True)
class _Block:
    """Frames of one b or d line."""

    head: str
    name: str
    frames: tuple[Frame, ...]


def export_descriptors(path: Path, out: Path, *, selection: Selection) -> tuple[str, ...]:
    """Write descriptors of a study and the images they name.

    Series of two frames are pairs, marked ones stacks; of longer ones the first two are a pair, and the others a stack
    where they are three or more. Beside each descriptor a JSON file holds what it has no place for.

    Parameters
    ----------
    path
        A study folder, a manifest or a descriptor.
    out
        Folder to make, missing or empty.
    selection
        Which part of it.

    Returns
    -------
    tuple
        Names of the descriptors.

    Raises
    ------
    UsageError
        The photons of its flats are not known, or ``out`` holds something.

    """
    if out.exists() and (not out.is_dir() or any(out.iterdir())):
        raise UsageError(f"{out} is there already and is not empty; name another folder.")
    study = load_study(path, selection)
    flats = [one for one in study.series if one.kind is Kind.FLAT]
    if not flats or any(one.photons is None for one in flats):
        raise UsageError(
            f"The photons of the flats of {path} are not known, and a descriptor needs them: state photons of each "
            "series, or irradiance, wavelength and pixel area, in study.toml."
        )
    with replaced_folder(out) as folder:
        return tuple(
            name
            for iso in study.isos
            for series in _by_temperature(study.select(Kind.FLAT, Kind.DARK, iso=iso))
            for name in _write(study, series, folder)
        )


def _by_temperature(series: Sequence[Series]) -> list[list[Series]]:
    """Return the series of each temperature of an ISO that has flats."""
    found: dict[float | None, list[Series]] = {}
    for one in series:
        found.setdefault(one.condition_c, []).append(one)
    return [alike for alike in found.values() if any(one.kind is Kind.FLAT for one in alike)]


def _write(study: Study, series: Sequence[Series], folder: Path) -> Iterator[str]:
    """Write the descriptors of one ISO and temperature, a channel each."""
    blocks = [block for one in series for block in _blocks(one)]
    iso, condition_c = series[0].iso, series[0].condition_c
    suffix = ("" if iso is None else f"_iso{iso:g}") + ("" if condition_c is None else f"_{condition_c:g}c")
    names = [f"{channel}{suffix}" for channel in channels(study.cfa)]
    for name in names:
        (folder / name).mkdir(parents=True)
    for block in blocks:
        for number, frame in enumerate(block.frames):
            mosaic = decode(frame.header, read_bytes(frame.header))
            for name, plane in zip(names, _planes(mosaic, study.cfa), strict=True):
                write_png(folder / name / f"{block.name}_{number:03d}.png", plane)
    step = cell(study.cfa)
    for name in names:
        lines = ["v 4.0", f"n {study.bit_depth} {study.width // step} {study.height // step}"]
        for block in blocks:
            lines.append(block.head)
            lines += [f"i {name}\\{block.name}_{number:03d}.png" for number in range(len(block.frames))]
        (folder / f"{name}.txt").write_text("\n".join(lines) + "\n", encoding="utf-8")
        (folder / f"{name}.json").write_text(_facts(study, series), encoding="utf-8")
        yield f"{name}.txt"


def _planes(mosaic: NDArray[np.uint16], cfa: str) -> Iterator[NDArray[np.uint16]]:
    """Return whole cells of each plane, so that all have one size."""
    step = cell(cfa)
    height, width = (side - side % step for side in mosaic.shape)
    for site in range(step**2):
        row, column = divmod(site, step)
        yield mosaic[row:height:step, column:width:step]


def _blocks(series: Series) -> Iterator[_Block]:
    """Return the pair and the stack that a series holds."""
    frames, count = series.frames, len(series.frames)
    nanoseconds = f"{(series.exposure_s or 0.0) * 1e9:.6f}".rstrip("0").rstrip(".")
    lit = series.kind is Kind.FLAT
    head = f"b {nanoseconds} {series.photons!r}" if lit else f"d {nanoseconds}"
    stem = f"{series.kind.value}_{nanoseconds}ns" + (f"_{series.photons:g}p" if lit else "")
    if series.stack is True or count == _PAIR:
        parts: Sequence[tuple[Frame, ...]] = (frames,)
    else:
        parts = (frames[:_PAIR], frames[_PAIR:])
    for part in parts:
        if len(part) == _PAIR or len(part) >= _FEWEST_IN_STACK:
            kind = "pair" if len(part) == _PAIR else "stack"
            yield _Block(head=head, name=f"{stem}_{kind}", frames=part)


def _facts(study: Study, series: Sequence[Series]) -> str:
    """Return what a descriptor has no place for; the planes have a pitch of their own."""
    camera = {name: value for name, value in asdict(study.camera).items() if value is not None}
    camera |= {"cfa": "mono"}
    camera.pop("black_level", None)
    light = {name: value for name, value in asdict(study.light).items() if value is not None}
    known = [one.temperature_c for one in series if one.temperature_c is not None]
    facts: dict[str, object] = {"camera": camera, "light": light}
    if series[0].iso is not None:
        facts["iso"] = series[0].iso
    if known:
        facts["temperature_c"] = round(sum(known) / len(known), 1)
    return json.dumps(facts, indent=1) + "\n"
