"""What the report shows of shots of charts: the frames with their patches, and a developed picture beside them."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Final

import numpy as np

from fullwell.errors import RawFileError, UsageError
from fullwell.findings import Finding, Severity
from fullwell.frames.series import Frame, Study
from fullwell.render.picture import developed, picture, read_picture, reduced
from fullwell.render.tone import grey_world, relative
from fullwell.report.pictures import ChartPicture, RenderedPoints
from fullwell.statistics.patch import patch_statistics
from fullwell.workflow.chart.reading import mosaic_of
from fullwell.workflow.measure.chart.chart import ChartMeasurement
from fullwell.workflow.measure.chart.levels import ChartLevels
from fullwell.workflow.measure.chart.shots import Scene, Shots

WIDEST: Final = 1200
MOST: Final = 6
"""Scenes that are shown."""
SAME_SIZE: Final = 0.03
"""Share by which a developed picture may be smaller or larger than the mosaic to be taken for a crop of it."""
_INSET: Final = 0.1
_SMALLEST: Final = 6


def chart_pictures(study: Study, measurement: ChartMeasurement) -> tuple[ChartPicture, ...]:
    """Read the brightest frame of every scene again and develop it; scenes beyond the sixth are not shown."""
    frames = {frame.name: frame for series in study.series for frame in series.frames}
    shown: list[ChartPicture] = []
    for scene in measurement.shots.scenes[:MOST]:
        try:
            shown.append(_picture(measurement, scene, frames))
        except (RawFileError, OSError):
            continue
    return tuple(shown)


def _picture(measurement: ChartMeasurement, scene: Scene, frames: Mapping[str, Frame]) -> ChartPicture:
    shots, levels = measurement.shots, measurement.levels
    light = relative(
        mosaic_of(frames[scene.name]),
        cfa=shots.cfa,
        black_level=levels.own_offsets_dn,
        white_level=_whites(levels),
    )
    rgb = reduced(developed(light, cfa=shots.cfa), longest=WIDEST)
    shown = picture(rgb, style="srgb", neutral=grey_world(light, cfa=shots.cfa))
    scale = shown.shape[1] / shots.width
    located = scene.located
    return ChartPicture(
        iso=shots.bursts.iso,
        title=scene.name,
        image=np.rint(shown * np.float32(255.0)).astype(np.uint8),
        patches=tuple(
            (one.name, scale * one.x, scale * one.y, scale * one.width, scale * one.height) for one in scene.patches
        ),
        confidence=None if located is None else located.confidence,
        corners=() if located is None else tuple((scale * x, scale * y) for x, y in located.corners),
        left_out=_left_out(scene),
    )


def _whites(levels: ChartLevels) -> Sequence[float]:
    return [white.level_dn or levels.digital_maximum for white in levels.whites]


def _left_out(scene: Scene) -> tuple[str, ...]:
    """Return the patches that are admitted in no channel at any exposure."""
    used = {point.patch for exposure in scene.exposures for point in exposure.points if point.admitted}
    return tuple(patch.name for patch in scene.patches if patch.name not in used)


def rendered_points(path: Path, shots: Shots) -> tuple[RenderedPoints, tuple[Finding, ...]]:
    """Measure the first scene's patches in a developed picture of it.

    Parameters
    ----------
    path
        A JPEG or PNG that shows all of the frame, in any size, not turned.
    shots
        Where the patches are.

    Raises
    ------
    UsageError
        Where the picture cannot be read, or does not have the proportions of the frame.

    """
    shown = read_picture(path)
    height, width, colours = shown.shape
    scale, left, top = _placement(path, (width, height), (shots.width, shots.height))
    names = ("R", "G", "B") if colours > 1 else ("mono",)
    patches = shots.scenes[0].patches
    mean = np.full((colours, len(patches)), np.nan)
    noise = np.full((colours, len(patches)), np.nan)
    for index, patch in enumerate(patches):
        inset_x, inset_y = _INSET * patch.width, _INSET * patch.height
        columns = slice(*_whole(left + scale * (patch.x + inset_x), left + scale * (patch.x + patch.width - inset_x)))
        rows = slice(*_whole(top + scale * (patch.y + inset_y), top + scale * (patch.y + patch.height - inset_y)))
        region = shown[rows, columns]
        if min(region.shape[:2]) < _SMALLEST:
            continue
        for colour in range(colours):
            found = patch_statistics(region[..., colour].astype(np.float64))
            mean[colour, index], noise[colour, index] = found.mean, found.variance**0.5
    message = (
        f"{path.name} was developed: its tone curve, sharpening and noise reduction have turned noise into something "
        "that no longer depends on the level alone, so nothing is measured in it; its jumbled curve stands beside the "
        "raw one to show that"
    )
    findings = (Finding(code="rendered-not-measured", severity=Severity.INFO, message=message),)
    points = RenderedPoints(iso=shots.bursts.iso, file=path.name, channels=names, mean=mean, noise=noise)
    return points, findings


def _placement(path: Path, own: tuple[int, int], mosaic: tuple[int, int]) -> tuple[float, float, float]:
    """Return scale and offset from the mosaic to the picture: a crop about the centre, or the whole in another size."""
    ratios = [mine / other for mine, other in zip(own, mosaic, strict=True)]
    if all(abs(ratio - 1.0) <= SAME_SIZE for ratio in ratios):
        return 1.0, (own[0] - mosaic[0]) / 2, (own[1] - mosaic[1]) / 2
    if abs(ratios[0] / ratios[1] - 1.0) > SAME_SIZE:
        raise UsageError(
            f"{path} has {own[0]} x {own[1]} pixels, the raw frames {mosaic[0]} x {mosaic[1]}: give a picture of the "
            "whole frame, neither cropped nor turned."
        )
    return ratios[0], 0.0, 0.0


def _whole(start: float, end: float) -> tuple[int, int]:
    return max(int(np.ceil(start)), 0), max(int(np.floor(end)), 0)
