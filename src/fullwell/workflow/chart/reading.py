"""Shots of charts are read once: what their patches, their codes and their masked pixels come to."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np
from numpy.typing import NDArray
from xxhash import xxh3_128

from fullwell.errors import RawFileError
from fullwell.findings import Finding, Severity
from fullwell.frames.chart.locate import Located
from fullwell.frames.chart.patches import Patch
from fullwell.frames.checks import exclusion_findings
from fullwell.frames.grouping import mean
from fullwell.frames.series import Exclusion, Frame, Series, Study
from fullwell.raw.cfa import cell, channels
from fullwell.raw.image import RawHeader
from fullwell.raw.open import decode, read_bytes
from fullwell.statistics.chart import Cuts, cut_patches, measure_cuts, plane_of
from fullwell.statistics.series import Histogram
from fullwell.workflow.executor import Progress, in_threads
from fullwell.workflow.masked import MaskedSums, masked_area, masked_sums
from fullwell.workflow.measure.chart.shots import Exposure, Scene, Shots, code_step, holder
from fullwell.workflow.measure.white_level import pile_up

SAME_LEVEL = 0.1
"""Frames of one exposure time whose levels differ by more were not lit alike: they count as different exposures."""
WIDEST_PICTURE = 1200


@dataclass(frozen=True, slots=True, kw_only=True)
class Placed:
    """Frames of one still scene, and where its patches are."""

    name: str
    frames: tuple[tuple[Series, Frame], ...]
    patches: tuple[Patch, ...]
    located: Located | None


@dataclass(frozen=True, slots=True, kw_only=True)
class ChartReading:
    """What the files came to.

    Parameters
    ----------
    hashes
        xxh3-128 of every file, by name.
    excluded
        Frames that could not be read.
    findings
        The same for the report, and copies.

    """

    shots: Shots
    hashes: Mapping[str, str]
    excluded: tuple[Exclusion, ...]
    findings: tuple[Finding, ...]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class _Look:
    """What one frame came to."""

    name: str
    exposure_s: float | None
    digest: str
    cuts: Cuts
    level_dn: float
    counts: tuple[NDArray[np.int64], ...]
    masked: tuple[MaskedSums, ...]
    image: NDArray[np.float32]


def mosaic_of(frame: Frame) -> NDArray[np.uint16]:
    """Read the visible mosaic of a frame.

    Raises
    ------
    RawFileError, OSError
        The file cannot be read.

    """
    return decode(frame.header, read_bytes(frame.header))


def read_shots(
    study: Study,
    scenes: Sequence[Placed],
    *,
    whites_dn: Sequence[float] | None,
    masked: bool,
    workers: int,
    progress: Progress | None,
) -> ChartReading:
    """Read every frame of some scenes of one ISO.

    Parameters
    ----------
    study
        What the frames have in common.
    scenes
        The frames with their patches.
    whites_dn
        Declared white level per CFA site [DN]; where codes pile up below it, that is what clips.
    masked
        Whether what lies beside the visible mosaic is masked: not so where only a part of the frame is used.
    workers
        Threads.
    progress
        Told of every frame; None for silence.

    """
    if progress is not None:
        progress.start(sum(len(scene.frames) for scene in scenes))
    looks: list[tuple[_Look, ...]] = []
    excluded: list[Exclusion] = []
    for scene in scenes:
        look = partial(_look, scene=scene, masked=masked, progress=progress)
        outcomes = in_threads(look, scene.frames, workers=workers)
        looks.append(tuple(one for one in outcomes if isinstance(one, _Look)))
        excluded += [one for one in outcomes if isinstance(one, Exclusion)]
    every = [look for some in looks for look in some]
    kept, copies = _without_copies(looks)
    histograms = _histograms(every, len(channels(study.cfa)))
    clips = _clipping_levels(histograms, whites_dn)
    used = [(scene, some) for scene, some in zip(scenes, kept, strict=True) if some]
    temperatures = [t for scene in scenes for series, _ in scene.frames if (t := series.temperature_c) is not None]
    series = [series for scene in scenes for series, _ in scene.frames]
    shots = Shots(
        bursts=holder(
            iso=series[0].iso,
            temperature_c=round(mean(sorted(temperatures)), 1) if temperatures else None,
            channels=channels(study.cfa),
        ),
        scenes=tuple(_scene(study, scene, some, clips) for scene, some in used),
        cfa=study.cfa,
        width=study.width,
        height=study.height,
        histograms=histograms,
        masked=masked_area([look.masked for look in every], channels(study.cfa)),
        step_dn=code_step(histograms),
    )
    return ChartReading(
        shots=shots,
        hashes={look.name: look.digest for look in sorted(every, key=lambda look: look.name)},
        excluded=tuple(excluded),
        findings=(*exclusion_findings(excluded), *copies),
    )


def _look(one: tuple[Series, Frame], *, scene: Placed, masked: bool, progress: Progress | None) -> _Look | Exclusion:
    series, frame = one
    try:
        data = read_bytes(frame.header)
        mosaic = decode(frame.header, data)
        margins = masked_sums(frame.header, data) if masked else ()
    except (RawFileError, OSError) as error:
        return Exclusion.of(frame.name, error)
    cfa = frame.header.cfa or "mono"
    cuts = cut_patches(mosaic, scene.patches)
    look = _Look(
        name=frame.name,
        exposure_s=series.exposure_s,
        digest=xxh3_128(data).hexdigest(),
        cuts=cuts,
        level_dn=float(np.mean([cut.mean() for cut in cuts])) - _black(frame.header),
        counts=tuple(
            np.bincount(plane_of(mosaic, site, cfa=cfa).ravel()).astype(np.int64) for site in range(cell(cfa) ** 2)
        ),
        masked=margins,
        image=_binned(mosaic, cell(cfa)),
    )
    if progress is not None:
        progress.advance()
    return look


def _black(header: RawHeader) -> float:
    return 0.0 if header.black_level is None else float(np.mean(header.black_level.values))


def _binned(mosaic: NDArray[np.uint16], step: int) -> NDArray[np.float32]:
    """Return the mosaic in whole cells, as many to a pixel as make it small enough to be shown."""
    factor = step * max(1, -(-mosaic.shape[1] // (step * WIDEST_PICTURE)))
    rows, columns = (size // factor for size in mosaic.shape)
    blocks = mosaic[: rows * factor, : columns * factor].reshape(rows, factor, columns, factor)
    return blocks.mean(axis=(1, 3), dtype=np.float32)


def _without_copies(looks: Iterable[Sequence[_Look]]) -> tuple[list[tuple[_Look, ...]], tuple[Finding, ...]]:
    """Keep the first of files with the same content: a copy has no noise of its own."""
    first: dict[str, str] = {}
    kept: list[tuple[_Look, ...]] = []
    findings: list[Finding] = []
    for some in looks:
        own: list[_Look] = []
        for look in some:
            original = first.setdefault(look.digest, look.name)
            if original == look.name:
                own.append(look)
            else:
                message = f"{look.name} is a copy of {original}: it is not used"
                findings.append(
                    Finding(code="duplicate-frame", severity=Severity.WARNING, message=message, files=(look.name,))
                )
        kept.append(tuple(own))
    return kept, tuple(findings)


def _histograms(looks: Sequence[_Look], sites: int) -> tuple[Histogram, ...]:
    return tuple(_histogram([look.counts[site] for look in looks]) for site in range(sites))


def _histogram(counts: Sequence[NDArray[np.int64]]) -> Histogram:
    total = np.zeros(max((one.size for one in counts), default=1), np.int64)
    for one in counts:
        total[: one.size] += one
    present = np.flatnonzero(total)
    first = int(present[0]) if present.size else 0
    last = int(present[-1]) if present.size else 0
    return Histogram(first_code=first, counts=total[first : last + 1], frames=len(counts))


def _clipping_levels(histograms: Sequence[Histogram], whites_dn: Sequence[float] | None) -> tuple[float, ...]:
    """Return what counts as clipped per site: the declared level, or where codes pile up below it [DN]."""
    levels: list[float] = []
    for site, histogram in enumerate(histograms):
        top = float(histogram.first_code + len(histogram.counts) - 1)
        declared = np.inf if whites_dn is None else float(whites_dn[site])
        levels.append(min(declared, top) if pile_up(histogram) else declared)
    return tuple(levels)


def _scene(study: Study, placed: Placed, looks: Sequence[_Look], clips: Sequence[float]) -> Scene:
    exposures = [
        Exposure(
            exposure_s=group[0].exposure_s,
            files=tuple(look.name for look in group),
            cuts=tuple(look.cuts for look in group),
            points=measure_cuts([look.cuts for look in group], placed.patches, cfa=study.cfa, white_dn=clips),
        )
        for group in _alike(looks)
    ]
    exposures.sort(key=lambda one: (-one.level_dn, one.files))
    brightest = next(look for look in looks if look.name == exposures[0].files[0])
    return Scene(
        name=brightest.name,
        patches=placed.patches,
        exposures=tuple(exposures),
        located=placed.located,
        image=brightest.image,
        image_step=study.width // brightest.image.shape[1],
    )


def _alike(looks: Sequence[_Look]) -> list[list[_Look]]:
    """Group frames of one exposure time and level."""
    groups: list[list[_Look]] = []
    for look in sorted(looks, key=lambda one: (one.exposure_s or 0.0, one.level_dn, one.name)):
        last = groups[-1] if groups else None
        if last is not None and last[0].exposure_s == look.exposure_s and _same_level(last[0], look):
            last.append(look)
        else:
            groups.append([look])
    return [sorted(group, key=lambda one: one.name) for group in groups]


def _same_level(first: _Look, second: _Look) -> bool:
    return abs(second.level_dn - first.level_dn) <= SAME_LEVEL * max(abs(first.level_dn), 1.0)
