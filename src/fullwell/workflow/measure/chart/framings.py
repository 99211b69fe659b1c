"""PRNU in spite of the chart's texture: different framings, aligned on the sensor (METHOD 1.9)."""

from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from fullwell.figures.results import Row
from fullwell.findings import Finding, Severity
from fullwell.fit.pooling import pool_channels
from fullwell.fit.two_framings import TwoFramings, two_framings
from fullwell.raw.cfa import ALL, cell
from fullwell.statistics.chart import MAX_CLIPPED, plane_of
from fullwell.units import ONE, PERCENT, Measured
from fullwell.workflow.measure.chart.levels import ChartLevels
from fullwell.workflow.measure.chart.shots import Scene, Shots
from fullwell.workflow.measure.section import RowWriter, Section

BRIGHT = 0.1
"""Share of the white level below which a patch is left out: there DSNU would count as PRNU."""
SMALLEST = 8
"""Least edge of a region in pixels of a plane."""
LEAST_SHIFT = 3.0
"""Pixels that framings are to be apart."""


def measure_framings(shots: Shots, levels: ChartLevels) -> Section:
    """Measure PRNU from the pixels that patches of two scenes have in common, if the chart moved between them."""
    pairs = [(first, second) for first, second in combinations(shots.scenes, 2) if _moved(first, second)]
    rows: list[Row] = []
    unclean: list[str] = []
    known: list[Measured] = []
    for channel in shots.channels:
        found = _measure(shots, levels, channel, pairs)
        if found is None:
            continue
        if not found.clean:
            unclean.append(channel)
        known.append(found.prnu_variance)
        rows += _rows(shots, channel, found.prnu_variance, n=found.n, differ=False)
    if len(known) == len(shots.channels) > 1:
        pooled, p_value = pool_channels(known)
        rows += _rows(shots, ALL, pooled, n=None, differ=p_value < 0.01)
    return Section(rows=tuple(rows), findings=_findings(shots, unclean))


def _moved(first: Scene, second: Scene) -> bool:
    """Tell whether the chart moved by three pixels or more: its patches lie elsewhere, or its picture is shifted."""
    mine, other = ({patch.name: patch for patch in scene.patches} for scene in (first, second))
    shared = sorted(mine.keys() & other.keys())
    by_patches = [max(abs(mine[n].x - other[n].x), abs(mine[n].y - other[n].y)) for n in shared]
    if by_patches and np.median(by_patches) >= LEAST_SHIFT:
        return True
    return _picture_shift(first, second) >= LEAST_SHIFT


def _picture_shift(first: Scene, second: Scene) -> float:
    """Return how far the second picture is shifted, by the peak of the phase correlation [pixel of the mosaic]."""
    if first.image.shape != second.image.shape or not first.image.size:
        return 0.0
    spectra = [np.fft.rfft2(scene.image - scene.image.mean()) for scene in (first, second)]
    cross = spectra[0] * np.conj(spectra[1])
    surface = np.fft.irfft2(cross / np.maximum(np.abs(cross), 1e-12), s=first.image.shape)
    peak = np.unravel_index(int(np.argmax(surface)), surface.shape)
    shift = [min(int(at), size - int(at)) for at, size in zip(peak, surface.shape, strict=True)]
    return float(max(shift)) * first.image_step


def _measure(shots: Shots, levels: ChartLevels, channel: str, pairs: list[tuple[Scene, Scene]]) -> TwoFramings | None:
    regions = [region for pair in pairs for region in _common(shots, levels, channel, *pair)]
    if not regions:
        return None
    try:
        return two_framings(
            [one for one, _ in regions],
            [other for _, other in regions],
            framings=len({id(scene) for pair in pairs for scene in pair}),
        )
    except ValueError:
        return None


def _common(
    shots: Shots, levels: ChartLevels, channel: str, first: Scene, second: Scene
) -> list[tuple[NDArray[np.float64], NDArray[np.float64]]]:
    """Return signals of the pixels that lie inside a patch in both scenes, brightest exposures, mean over frames."""
    step, black = cell(shots.cfa), levels.of(channel).level.value
    found: list[tuple[NDArray[np.float64], NDArray[np.float64]]] = []
    for at, one in enumerate(first.patches):
        for beside, other in enumerate(second.patches):
            left, top = max(one.x, other.x), max(one.y, other.y)
            right = min(one.x + one.width, other.x + other.width)
            bottom = min(one.y + one.height, other.y + other.height)
            if min(right - left, bottom - top) < SMALLEST * step:
                continue
            cuts = [
                _signal(shots, scene, index, channel, (left - patch.x, top - patch.y, right - left, bottom - top))
                - black
                for scene, index, patch in ((first, at, one), (second, beside, other))
            ]
            if min(cut.mean() for cut in cuts) > BRIGHT * levels.ceiling_dn(channel) and not _clips(
                shots, channel, (first, at), (second, beside)
            ):
                found.append((cuts[0], cuts[1]))
    return found


def _signal(
    shots: Shots, scene: Scene, index: int, channel: str, box: tuple[int, int, int, int]
) -> NDArray[np.float64]:
    x, y, width, height = box
    frames = [cuts[index][y : y + height, x : x + width] for cuts in scene.brightest.cuts]
    site = shots.channels.index(channel)
    stack = np.stack([plane_of(frame, site, cfa=shots.cfa) for frame in frames])
    return np.asarray(stack.mean(axis=0, dtype=np.float64))


def _clips(shots: Shots, channel: str, *places: tuple[Scene, int]) -> bool:
    site = shots.channels.index(channel)
    sites = len(shots.channels)
    return any(scene.brightest.points[index * sites + site].clipped_high > MAX_CLIPPED for scene, index in places)


def _rows(shots: Shots, channel: str, variance: Measured, *, n: int | None, differ: bool) -> tuple[Row, ...]:
    return RowWriter(bursts=shots.bursts).root_and_variance(
        "prnu",
        channel,
        "two-framings",
        variance.scaled(1e4, f"{PERCENT}^2") if variance.unit == ONE else variance,
        PERCENT,
        source="METHOD 1.9",
        n=n,
        flags=("channels-differ",) if differ else (),
    )


def _findings(shots: Shots, unclean: list[str]) -> tuple[Finding, ...]:
    if not unclean:
        return ()
    message = (
        f"neighbouring pixels of {', '.join(unclean)} at {shots.bursts.label} vary together in both framings: the "
        "chart was shifted too little for its texture, or uneven light is in the PRNU; shift it by more"
    )
    return (Finding(code="framings-alike", severity=Severity.WARNING, message=message),)
