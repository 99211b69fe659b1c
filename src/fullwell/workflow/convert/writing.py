"""What was recoded becomes files: a DNG, or a TIFF with its sidecar."""

import math
from collections.abc import Sequence
from pathlib import Path
from typing import Final

from fullwell.errors import UnsuitableFileError
from fullwell.frames.sidecar_writing import sidecar_path, sidecar_text
from fullwell.raw.image import Area
from fullwell.raw.tiff_file import write_whole
from fullwell.raw.write import DngExtras, write_dng
from fullwell.raw.write_tiff import write_rgb, write_tiff
from fullwell.workflow.convert.recoding import Recoded
from fullwell.workflow.convert.settings import Conversion, FileKind
from fullwell.workflow.scenes import Scene

LARGEST_BYTES: Final = 2**32 - 2**24
"""A TIFF file cannot be larger than 4 GiB; some are left for its head [byte]."""
HIGHEST_ISO: Final = 2**32 - 1
_SMALLEST_DEPTH: Final = 8


def write_converted(
    scene: Scene, done: Recoded, target: Path, *, conversion: Conversion, kind: FileKind
) -> tuple[Path, ...]:
    """Write one file, and the sidecar of a TIFF mosaic; return what was written.

    Parameters
    ----------
    scene, done
        What is known and what is written.
    target
        The file; its folder is made.

    Raises
    ------
    UnsuitableFileError
        ``file-too-large`` where a TIFF file cannot hold it.

    """
    pixels = done.codes.mosaic if done.rgb is None else done.rgb
    if pixels.nbytes > LARGEST_BYTES:
        raise UnsuitableFileError("file-too-large", "it would be larger than 4 GiB, which TIFF and DNG cannot be")
    target.parent.mkdir(parents=True, exist_ok=True)
    header = scene.header
    iso, extras = whole_iso(header.iso), _extras(scene, done)
    if done.rgb is not None:
        write_rgb(
            target,
            done.rgb,
            kind=kind,
            iso=iso,
            exposure_s=header.exposure_s,
            make=header.make,
            model=header.model,
            extras=extras,
        )
        return (target,)
    if kind == "dng":
        write_dng(
            target,
            done.codes.mosaic,
            cfa=scene.cfa,
            black_level=written_black(scene, done),
            white_level=math.floor(min(done.codes.white_level)),
            bit_depth=max(done.codes.bit_depth, _SMALLEST_DEPTH),
            iso=iso,
            exposure_s=header.exposure_s,
            compression=conversion.compression,
            make=header.make or "unknown",
            model=header.model or "unknown camera",
            extras=extras,
        )
        return (target,)
    return _write_tiff(scene, done, target, iso=iso, extras=extras)


def _write_tiff(scene: Scene, done: Recoded, target: Path, *, iso: float | None, extras: DngExtras) -> tuple[Path, ...]:
    header, codes = scene.header, done.codes
    height, width = codes.mosaic.shape
    told = sidecar_text(
        cfa=scene.cfa,
        bit_depth=codes.bit_depth,
        width=width,
        height=height,
        black_level=written_black(scene, done),
        white_level=codes.white_level,
        iso=header.iso,
        exposure_s=header.exposure_s,
        temperature_c=header.temperature_c,
        make=header.make,
        model=header.model,
        noise_profile=extras.noise_profile,
        as_shot_neutral=extras.as_shot_neutral,
    )
    sidecar = sidecar_path(target)
    write_whole(sidecar, [told.encode()])
    try:
        write_tiff(
            target,
            codes.mosaic,
            cfa=scene.cfa,
            iso=iso,
            exposure_s=header.exposure_s,
            make=header.make,
            model=header.model,
            extras=extras,
        )
    except BaseException:
        sidecar.unlink(missing_ok=True)
        raise
    return target, sidecar


def _extras(scene: Scene, done: Recoded) -> DngExtras:
    header, kept = scene.header, done.area
    height, width = (kept.bottom - kept.top, kept.right - kept.left)
    visible = _moved(header.active_area, kept)
    whole = visible == Area(0, 0, height, width)
    masked = [_moved(area, kept) for area in header.masked_areas if not whole and header.format == "dng"]
    balanced = bool(done.neutral)
    return DngExtras(
        active_area=None if whole else visible,
        masked_areas=tuple(area for area in masked if area.top < area.bottom and area.left < area.right),
        noise_profile=() if balanced or done.rgb is not None else header.noise_profile,
        orientation=header.orientation,
        temperature_c=header.temperature_c,
        as_shot_neutral=() if balanced else header.as_shot_neutral,
        colour_matrix=header.colour_matrix,
    )


def _moved(area: Area, kept: Area) -> Area:
    """Return an area in coordinates of the part of the frame that is kept."""
    top, left = max(area.top - kept.top, 0), max(area.left - kept.left, 0)
    return Area(top, left, area.bottom - kept.top, area.right - kept.left)


def written_black(scene: Scene, done: Recoded) -> Sequence[float] | None:
    """Return the black level that is written; None where nobody declared one, and readers take 0 [DN]."""
    black = scene.black_level
    if done.clipped is None and (black is None or black.source == "default"):
        return None
    return done.codes.black_level


def whole_iso(iso: float | None) -> float | None:
    """Return the ISO as EXIF can hold it: a whole number above 0."""
    if iso is None or not math.isfinite(iso):
        return None
    return float(min(max(round(iso), 1), HIGHEST_ISO))
