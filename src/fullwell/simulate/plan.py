"""The plan of a study: every frame with its name, in the order in which frames are numbered.

The exposures and electrons of flats and charts are those at the base ISO. At another ISO both are divided by the
amplification, as a photographer compensates: the light stays the same, and so do the codes. Series that the config
lists one by one are taken as they stand.
"""

from dataclasses import dataclass, replace
from pathlib import Path
from typing import Final

from fullwell.frames.series import Kind
from fullwell.simulate.config import SimulationConfig
from fullwell.simulate.scene import CHART
from fullwell.simulate.shot import Exposure
from fullwell.simulate.tables import DarkTable, FlatTable, SeriesTable

_SUBJECT: Final = {Kind.CHART: CHART, Kind.SCENE: "patches", Kind.FLAT: "flat", Kind.DARK: "flat", Kind.BIAS: "flat"}


@dataclass(frozen=True, slots=True, kw_only=True)
class PlannedFrame:
    """One frame to be taken.

    Parameters
    ----------
    name
        Path relative to the study without a suffix, with forward slashes; names sort by exposure within a folder.
    kind
        What the frame is for.
    exposure
        How it is taken.

    """

    name: str
    kind: Kind
    exposure: Exposure


def plan(config: SimulationConfig) -> tuple[PlannedFrame, ...]:
    """Return the frames of a study: flats, charts, darks, bias frames by ISO, then scenes and single series."""
    study, folders = config.study, config.study.folders
    base_iso = config.table.camera.base_iso
    taken: list[tuple[str, Kind, Exposure]] = []
    for iso in study.isos:
        if study.flat:
            taken += _lit(study.flat, folders.flat, iso, Kind.FLAT, compensation=base_iso / iso)
        if study.chart:
            taken += _lit(study.chart, folders.chart, iso, Kind.CHART, compensation=base_iso / iso)
        if study.dark:
            taken += _unlit(study.dark, folders.dark, iso, Kind.DARK)
        if study.bias:
            taken += _unlit(study.bias, folders.bias, iso, Kind.BIAS)
    if study.scene:
        scene, iso = study.scene, min(study.isos)
        for subject in scene.subjects:
            seen = Exposure(iso=iso, exposure_s=scene.exposure_s, electrons=scene.electrons, subject=subject)
            taken.append((f"{study.folders.scene}/{Path(subject).stem}", Kind.SCENE, seen))
    for series in study.series:
        taken += _stated(series, folders.model_dump()[series.kind])
    warm = study.temperature_c
    taken = [
        (name, kind, one if one.temperature_c is not None else replace(one, temperature_c=warm))
        for name, kind, one in taken
    ]
    return tuple(
        PlannedFrame(name=name, kind=kind, exposure=replace(exposure, frame=number))
        for number, (name, kind, exposure) in enumerate(taken)
    )


def nanosecond(exposure_s: float) -> float:
    """Return an exposure to the nanosecond, so that file names and metadata hold all of it [s]."""
    return round(exposure_s * 1e9) / 1e9


def _lit(
    table: FlatTable, folder: str, iso: int, kind: Kind, *, compensation: float
) -> list[tuple[str, Kind, Exposure]]:
    taken: list[tuple[str, Kind, Exposure]] = []
    for base_exposure_s, electrons in zip(table.exposures_s, table.electrons, strict=True):
        exposure_s = nanosecond(base_exposure_s * compensation)
        level = electrons * exposure_s / base_exposure_s
        lit = Exposure(iso=float(iso), exposure_s=exposure_s, electrons=level, subject=_SUBJECT[kind])
        taken += _burst(folder, kind, table.frames, lit)
    return taken


def _unlit(table: DarkTable, folder: str, iso: int, kind: Kind) -> list[tuple[str, Kind, Exposure]]:
    taken: list[tuple[str, Kind, Exposure]] = []
    for exposure_s in table.exposures_s:
        unlit = Exposure(iso=float(iso), exposure_s=nanosecond(exposure_s))
        taken += _burst(folder, kind, table.frames, unlit)
    return taken


def _stated(series: SeriesTable, folder: str) -> list[tuple[str, Kind, Exposure]]:
    kind = Kind(series.kind)
    taken = Exposure(
        iso=float(series.iso),
        exposure_s=nanosecond(series.exposure_s),
        electrons=series.electrons,
        subject=series.subject or _SUBJECT[kind],
        temperature_c=series.temperature_c,
    )
    return _burst(folder, kind, series.frames, taken)


def _burst(folder: str, kind: Kind, frames: int, exposure: Exposure) -> list[tuple[str, Kind, Exposure]]:
    """Return the frames of one series."""
    microseconds = f"{exposure.exposure_s * 1e6:013.3f}".removesuffix(".000").zfill(9)
    warm = "" if exposure.temperature_c is None else f"_{exposure.temperature_c:g}C"
    stem = f"{folder}/ISO_{exposure.iso:.0f}/exp{microseconds}us{warm}"
    digits = max(2, len(str(frames - 1)))
    return [(f"{stem}_n{index:0{digits}d}", kind, exposure) for index in range(frames)]
