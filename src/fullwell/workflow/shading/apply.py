"""``fullwell shading apply``: scenes without their shading, as raw files and as pictures to look at."""

import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from fullwell.errors import FullwellError, RawFileError, UsageError
from fullwell.findings import Finding, Severity
from fullwell.frames.series import Exclusion
from fullwell.raw.cfa import cell
from fullwell.raw.image import Levels
from fullwell.raw.open import decode
from fullwell.raw.rewriting import copy_with_gain_maps
from fullwell.raw.write import DngExtras, write_dng
from fullwell.render.picture import STYLES, developed, picture, write_png
from fullwell.render.tone import grey_world, relative
from fullwell.workflow.executor import Progress, in_threads
from fullwell.workflow.maps import ShadingMapFile
from fullwell.workflow.options import Options
from fullwell.workflow.scenes import Scene, read_scenes, scene_files
from fullwell.workflow.shading.correction import Corrected, corrected, gain_maps
from fullwell.workflow.shading.folder import ShadingOutcome, shading_folder, write_document
from fullwell.workflow.shading.placement import Geometry, Placement, place
from fullwell.workflow.shading.saved import saved_maps, suitable_map

_MOST_AT_ONCE: Final = 4
"""Scenes in memory at the same time: a large one takes some hundred megabytes."""
_EXIF_ISO: Final = 65534


@dataclass(frozen=True, slots=True, kw_only=True)
class _Done:
    """What was written for one scene, or why nothing was."""

    said: Mapping[str, object] | None
    findings: tuple[Finding, ...]


def apply_shading(
    shading: Path,
    scenes: Sequence[Path],
    out: Path,
    *,
    options: Options,
    quarters: int | None = None,
    progress: Progress | None = None,
) -> ShadingOutcome:
    """Correct scenes by a map and write them into a folder.

    Parameters
    ----------
    shading
        A map, or a folder with maps: then each scene gets the map that suits it best.
    scenes
        Raw files, or folders of them.
    out
        Folder to write. Each scene becomes ``<name>_corrected.dng`` of 16 bits, ``<name>_gain_map.dng``, a copy of a
        DNG with the map as an opcode, and four pictures ``<name>_before_linear.png`` ... ``<name>_after_srgb.png``.
    options
        Facts that outrank the files' own, and workers.
    quarters
        Quarter turns to the left from map to scene; None decides from size, CFA and orientation.
    progress
        Told of every scene.

    Raises
    ------
    UsageError
        Where no scene can be corrected, or ``out`` must not be replaced.

    """
    started = time.monotonic()
    maps = saved_maps(shading)
    files = scene_files(scenes)
    with shading_folder(out, shading, *files) as folder:
        found, excluded = read_scenes(files, options.selection)
        if progress is not None:
            progress.start(len(found))

        def work(scene: Scene) -> _Done:
            done = _attempt(scene, maps, folder, quarters=quarters)
            if progress is not None:
                progress.advance()
            return done

        outcomes = in_threads(work, found, workers=min(options.workers, _MOST_AT_ONCE))
        findings = (*map(_excluded, excluded), *(one for done in outcomes for one in done.findings))
        said = [done.said for done in outcomes if done.said is not None]
        if not said:
            first = next(one for one in findings if one.severity is Severity.ERROR)
            raise UsageError(f"No scene could be corrected. {', '.join(first.files)}: {first.message}")
        document = write_document(
            folder,
            "apply",
            {"map": str(shading), "scenes": said},
            findings=findings,
            options=options,
            study=shading,
            out=out,
            started=started,
        )
    return ShadingOutcome(out=out, document=document, findings=findings)


def _attempt(scene: Scene, maps: Sequence[ShadingMapFile], folder: Path, *, quarters: int | None) -> _Done:
    """Correct one scene; what is wrong with it becomes a finding."""
    try:
        return _corrected(scene, suitable_map(maps, iso=scene.header.iso), folder, quarters=quarters)
    except RawFileError as error:
        code, message = error.code, error.message
    except FullwellError as error:
        code, message = "scene-not-corrected", str(error)
    refused = Finding(code=code, severity=Severity.ERROR, message=message, files=(str(scene.path),))
    return _Done(said=None, findings=(refused,))


def _corrected(scene: Scene, shading: ShadingMapFile, folder: Path, *, quarters: int | None) -> _Done:
    header = scene.header
    geometry = Geometry(height=header.height, width=header.width, cfa=scene.cfa, orientation=header.orientation)
    placement = place(shading, geometry, quarters=quarters)
    mosaic = decode(header, scene.path.read_bytes())
    black = _black(scene, placement)
    result = corrected(mosaic, placement, black_level=black.values, white_level=scene.white_level.values)
    files = [_write_corrected(scene, result, folder)]
    replaced = 0
    if header.format == "dng":
        target = folder / f"{scene.name}_gain_map.dng"
        replaced = copy_with_gain_maps(scene.path, target, gain_maps(placement))
        files.append(target.name)
    before = relative(mosaic, cfa=scene.cfa, black_level=black.values, white_level=scene.white_level.values)
    whites = (float(result.white_level),) * cell(scene.cfa) ** 2
    after = relative(result.mosaic, cfa=scene.cfa, black_level=result.black_level, white_level=whites)
    neutral = _neutral(scene) or grey_world(after, cfa=scene.cfa)
    for moment, light in (("before", before), ("after", after)):
        rgb = developed(light, cfa=scene.cfa)
        for style in STYLES:
            path = folder / f"{scene.name}_{moment}_{style}.png"
            write_png(path, picture(rgb, style=style, neutral=neutral, orientation=header.orientation))
            files.append(path.name)
    return _Done(
        said=_said(scene, placement, black, result, files),
        findings=_findings(scene, placement, black, result, replaced=replaced),
    )


def _black(scene: Scene, placement: Placement) -> Levels:
    """Return the scene's black level, or the map's where the scene declares none."""
    declared = scene.black_level
    if declared is not None and declared.source != "default":
        return declared
    values = tuple(placement.channel(site).black_level_dn for site in range(cell(scene.cfa) ** 2))
    return Levels(values=values, source="shading-map")


def _neutral(scene: Scene) -> tuple[float, ...] | None:
    """Return what is white in the scene; equal numbers are what writers put who do not know it."""
    neutral = scene.header.as_shot_neutral
    return neutral if len(set(neutral)) > 1 else None


def _write_corrected(scene: Scene, result: Corrected, folder: Path) -> str:
    path, header = folder / f"{scene.name}_corrected.dng", scene.header
    iso = header.iso if header.iso is not None and header.iso.is_integer() and header.iso <= _EXIF_ISO else None
    write_dng(
        path,
        result.mosaic,
        cfa=scene.cfa,
        black_level=result.black_level,
        white_level=result.white_level,
        iso=iso,
        exposure_s=header.exposure_s,
        compression="lossless-jpeg",
        make=header.make or "Fullwell",
        model=header.model or "unknown camera",
        extras=DngExtras(
            orientation=header.orientation, temperature_c=header.temperature_c, as_shot_neutral=header.as_shot_neutral
        ),
    )
    return path.name


def _said(
    scene: Scene, placement: Placement, black: Levels, result: Corrected, files: Sequence[str]
) -> Mapping[str, object]:
    shading = placement.shading
    return {
        "scene": str(scene.path),
        "width": scene.header.width,
        "height": scene.header.height,
        "cfa": scene.cfa,
        "orientation": scene.header.orientation,
        "map": {
            "name": shading.stem,
            "cfa": shading.cfa,
            "orientation": shading.orientation,
            "models": {one.channel: one.model for one in shading.channels},
        },
        "turned_right_degrees": _degrees(placement),
        "colours_shifted": list(placement.shift),
        "black_level": {"values": black.values, "source": black.source, "unit": "DN"},
        "white_level": {"values": scene.white_level.values, "source": scene.white_level.source, "unit": "DN"},
        "corrected": {
            "scale": result.scale,
            "black_level": list(result.black_level),
            "white_level": result.white_level,
        },
        "files": list(files),
    }


def _degrees(placement: Placement) -> int:
    return 90 * (-placement.quarters % 4)


def _findings(
    scene: Scene, placement: Placement, black: Levels, result: Corrected, *, replaced: int
) -> tuple[Finding, ...]:
    info, warning = Severity.INFO, Severity.WARNING
    rows, columns = placement.shift
    turned = f"its mosaic is turned to the right by {_degrees(placement)} degrees against the map's; so was the map"
    shifted = (
        f"its colours lie {rows} rows and {columns} columns from the map's; planes were matched by colour. If its "
        "mosaic is turned instead, say so with --turn"
    )
    rounded = f"corrected it needs more than 16 bits; codes were multiplied by {result.scale:.4g}"
    opcodes = f"it had {replaced} gain maps of its own; the copy holds ours in their place"
    said = (
        (placement.quarters > 0, "scene-turned", info, turned),
        (any(placement.shift), "scene-cfa-shifted", info, shifted),
        (
            black.source == "shading-map",
            "black-level-of-map",
            warning,
            "it declares no black level; the map's was used",
        ),
        (result.scale < 1.0, "scene-rounded", warning, rounded),
        (replaced > 0, "gain-maps-replaced", info, opcodes),
        (scene.header.format != "dng", "no-gain-map-copy", info, "it is no DNG, so there is no copy with gain maps"),
    )
    return tuple(
        Finding(code=code, severity=severity, message=f"{message}.", files=(str(scene.path),))
        for holds, code, severity, message in said
        if holds
    )


def _excluded(one: Exclusion) -> Finding:
    return Finding(code=one.code, severity=Severity.ERROR, message=f"{one.reason}.", files=(one.name,))
