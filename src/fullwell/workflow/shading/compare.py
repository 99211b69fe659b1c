"""``fullwell shading compare``: whether the shading is the same at every exposure and ISO, beyond its errors."""

import csv
import io
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import numpy as np

from fullwell.errors import UsageError
from fullwell.findings import Finding
from fullwell.fit.shading.comparison import ShadingDifference, compare_shading
from fullwell.report.pictures import ShadingDifferencePicture
from fullwell.workflow.executor import Progress, in_threads
from fullwell.workflow.iso_maps import shading_file
from fullwell.workflow.maps import NamedArray, ShadingMapFile, save_pixel_maps
from fullwell.workflow.options import Options
from fullwell.workflow.shading.fit import measure_study
from fullwell.workflow.shading.folder import (
    ShadingOutcome,
    check_shading_target,
    shading_folder,
    write_document,
)
from fullwell.workflow.shading.saved import by_iso_and_exposure, map_files, saved_maps

TABLE: Final = "comparison.csv"
_PER_INCH: Final = 150.0
"""Pixels of the pictures."""
_COLUMNS: Final = ("iso", "exposure_s", "channel", "rms", "largest_over_error", "chi_square", "dof", "p_value", "scale")


@dataclass(frozen=True, slots=True, kw_only=True)
class MapDifference:
    """One map against the base, by channel."""

    base: ShadingMapFile
    other: ShadingMapFile
    channels: tuple[tuple[str, ShadingDifference], ...]


def compare_maps(
    paths: Sequence[Path],
    out: Path,
    *,
    options: Options,
    same_sensor: bool = True,
    progress: Progress | None = None,
) -> ShadingOutcome:
    """Compare shading maps with the first of them and write how they differ.

    Parameters
    ----------
    paths
        Maps, folders with maps, or studies whose flats are fitted first. The base is the map of lowest ISO and
        shortest exposure that the first path names.
    out
        Folder to write: ``comparison.csv``, difference maps with their standard errors, two pictures, ``shading.json``.
    options
        What to measure and how, where a path is a study.
    same_sensor
        Whether one sensor took all flats: its PRNU is in every map then and drops out of their differences.
    progress
        Told of every frame that is read.

    Raises
    ------
    UsageError
        Where there are not two maps, they do not fit each other, or ``out`` must not be replaced.

    """
    started = time.monotonic()
    check_shading_target(out, *paths)
    maps, findings = _gathered(paths, options=options, progress=progress)
    if len(maps) < 2:
        raise UsageError("There is only one shading map to compare; give a second one, or flats of another exposure.")

    def compare(other: ShadingMapFile) -> MapDifference:
        return _compared(maps[0], other, same_sensor=same_sensor)

    differences = in_threads(compare, maps[1:], workers=options.workers)
    with shading_folder(out, *paths) as folder:
        (folder / TABLE).write_text(_table(differences), encoding="utf-8", newline="\n")
        (folder / "maps").mkdir()
        for number, one in enumerate(differences, start=1):
            _save(folder / "maps" / f"difference_{number:02d}_{one.other.stem}.npz", one)
        _draw(folder, differences)
        document = write_document(
            folder,
            "compare",
            {"base": _burst(maps[0]), "same_sensor": same_sensor, "comparisons": [_said(one) for one in differences]},
            findings=findings,
            options=options,
            study=paths[0],
            out=out,
            started=started,
        )
    return ShadingOutcome(out=out, document=document, findings=tuple(findings))


def _gathered(
    paths: Sequence[Path], *, options: Options, progress: Progress | None
) -> tuple[list[ShadingMapFile], list[Finding]]:
    """Return the maps of all paths, each path's by ISO and exposure, and what fitting brought to light."""
    maps: list[ShadingMapFile] = []
    findings: list[Finding] = []
    for path in paths:
        if map_files(path) or path.suffix.lower() == ".npz":
            wanted = options.selection.wants
            maps += [one for one in saved_maps(path) if wanted(iso=one.iso, exposure_s=one.exposure_s)]
            continue
        measured = measure_study(path, options=options, progress=progress)
        own = (shading_file(measured.study, one) for one in measured.bursts)
        maps += sorted(own, key=by_iso_and_exposure)
        findings += measured.findings
    return maps, findings


def _compared(base: ShadingMapFile, other: ShadingMapFile, *, same_sensor: bool) -> MapDifference:
    if (base.cfa, base.width, base.height) != (other.cfa, other.width, other.height):
        raise UsageError(
            f"{other.stem} is a {other.cfa} map of {other.width} x {other.height} pixels, {base.stem} a {base.cfa} map "
            f"of {base.width} x {base.height}; maps are compared pixel by pixel, so fit both to frames of one mode."
        )
    try:
        channels = tuple(
            (first.channel, compare_shading(first.data, second.data, same_sensor=same_sensor))
            for first, second in zip(base.channels, other.channels, strict=True)
        )
    except ValueError as error:
        raise UsageError(f"{other.stem} cannot be compared with {base.stem}: {error}.") from error
    return MapDifference(base=base, other=other, channels=channels)


def _table(differences: Sequence[MapDifference]) -> str:
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(_COLUMNS)
    for one in differences:
        iso = "" if one.other.iso is None else f"{one.other.iso:g}"
        for channel, own in one.channels:
            numbers = (own.rms, own.largest, own.chi_square, own.dof, own.p_value, own.scale)
            shown = (f"{number:.9g}" for number in numbers)
            writer.writerow((iso, f"{one.other.exposure_s:.12g}", channel, *shown))
    return text.getvalue()


def _save(path: Path, one: MapDifference) -> None:
    arrays: dict[str, NamedArray] = {}
    for channel, own in one.channels:
        for name, values, unit, said in (
            ("rows", own.rows, "pixel", "rows of the plane"),
            ("columns", own.columns, "pixel", "columns of the plane"),
            ("difference", own.difference, "1", "relative difference of shape to the base map"),
            ("std_error", own.std_error, "1", "standard error of the difference"),
        ):
            arrays[f"{channel}.{name}"] = NamedArray(values=values, unit=unit, description=said)
    save_pixel_maps(path, arrays, about={"map": _burst(one.other), "base": _burst(one.base), "source": "METHOD 6.5"})


def _draw(folder: Path, differences: Sequence[MapDifference]) -> None:
    """Write the grid of difference pictures, in percent and in standard errors."""
    from fullwell.report.plots import drawing_of  # noqa: PLC0415 - drawing loads when used
    from fullwell.report.plots_lens import difference_grid  # noqa: PLC0415 - as above
    from fullwell.report.typesetting import png_of  # noqa: PLC0415 - as above

    pictures = [_picture(one) for one in differences]
    for which in ("difference", "over_error"):
        drawing = drawing_of(difference_grid(pictures, which))
        (folder / f"{which}.png").write_bytes(png_of(drawing, per_inch=_PER_INCH))


def _picture(one: MapDifference) -> ShadingDifferencePicture:
    """Return the mean difference of all channels; the smallest probability counts once for each of them."""
    own = [difference for _channel, difference in one.channels]
    shape = tuple(min(sizes) for sizes in zip(*(each.difference.shape for each in own), strict=True))
    cut = (slice(shape[0]), slice(shape[1]))
    difference = np.mean([each.difference[cut] for each in own], axis=0)
    error = np.sqrt(np.sum([each.std_error[cut] ** 2 for each in own], axis=0)) / len(own)
    return ShadingDifferencePicture(
        iso=one.other.iso,
        exposure_s=one.other.exposure_s,
        base_iso=one.base.iso,
        base_exposure_s=one.base.exposure_s,
        difference=difference,
        over_error=difference / error,
        p_value=min(1.0, len(own) * min(each.p_value for each in own)),
    )


def _burst(shading: ShadingMapFile) -> Mapping[str, object]:
    return {"name": shading.stem, "iso": shading.iso, "exposure_s": shading.exposure_s}


def _said(one: MapDifference) -> Mapping[str, object]:
    return {
        "map": _burst(one.other),
        "channels": [
            {
                "channel": channel,
                "rms": own.rms,
                "largest_over_error": own.largest,
                "chi_square": own.chi_square,
                "dof": own.dof,
                "p_value": own.p_value,
                "scale": own.scale,
                "misfit": own.misfit,
            }
            for channel, own in one.channels
        ],
    }
