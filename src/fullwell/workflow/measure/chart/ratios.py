"""How much light each channel sees relative to G1 (METHOD 1.10)."""

from fullwell.figures.results import Row
from fullwell.fit.channel_ratios import channel_ratio
from fullwell.statistics.chart import PatchPoint
from fullwell.workflow.measure.chart.levels import ChartLevels
from fullwell.workflow.measure.chart.shots import Shots
from fullwell.workflow.measure.section import RowWriter, Section

REFERENCE = "G1"


def measure_channel_ratios(shots: Shots, levels: ChartLevels) -> Section:
    """Return the ratio of each channel's signals to those of G1, from patches that no channel clips.

    Patches that are known to be neutral alone count, where there are some: coloured ones have ratios of their own.
    """
    if REFERENCE not in shots.channels:
        return Section()
    neutral = any(patch.density is not None for scene in shots.scenes for patch in scene.patches)
    rows: list[Row] = []
    for channel in shots.channels:
        if channel == REFERENCE:
            continue
        pairs = [
            (own, reference)
            for _, exposure in shots.exposures
            for own, reference in zip(exposure.of(channel), exposure.of(REFERENCE), strict=True)
            if own.admitted and reference.admitted and (own.density is not None or not neutral)
        ]
        blacks = levels.of(channel), levels.of(REFERENCE)
        try:
            measured = channel_ratio(
                [own.mean_dn - blacks[0].level.value for own, _ in pairs],
                [_of_mean(own) for own, _ in pairs],
                [reference.mean_dn - blacks[1].level.value for _, reference in pairs],
                [_of_mean(reference) for _, reference in pairs],
                offset_std_error_dn=max(one.error_dn for one in blacks),
            )
        except ValueError:
            continue
        rows.append(
            RowWriter(bursts=shots.bursts).row(
                "channel_ratio",
                channel,
                "mean-ratio",
                measured,
                source="METHOD 1.10",
                n=sum(own.n * own.frames for own, _ in pairs),
                recommended=True,
            )
        )
    return Section(rows=tuple(rows))


def _of_mean(point: PatchPoint) -> float:
    """Return the variance of a patch's mean [DN^2]."""
    return point.variance_dn2 / (point.n * point.frames)
