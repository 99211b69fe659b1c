"""Is the shading the same at every exposure and ISO? Every burst against the first (METHOD 6.5)."""

from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass

from fullwell.figures.results import Column, Curve
from fullwell.findings import Finding, Severity
from fullwell.fit.pooling import SIGNIFICANCE
from fullwell.fit.shading.comparison import ShadingDifference, compare_shading
from fullwell.report.numbers import show_exposure
from fullwell.workflow.executor import in_threads
from fullwell.workflow.measure.section import Section
from fullwell.workflow.measure.shading import BurstShading

NOTABLE = 1e-3
"""Relative difference, rms, below which a significant one is not worth a finding."""


@dataclass(frozen=True, slots=True, kw_only=True)
class BurstDifference:
    """The shading of one burst against that of the base, by channel."""

    base: BurstShading
    other: BurstShading
    channels: tuple[tuple[str, ShadingDifference], ...]


def measure_shading_differences(
    shadings: Sequence[BurstShading], *, workers: int
) -> tuple[Section, tuple[BurstDifference, ...]]:
    """Compare every burst with the one of the lowest ISO and the shortest exposure.

    Parameters
    ----------
    shadings
        By ascending ISO and exposure; the first is the base.
    workers
        Threads; the result does not depend on their number.

    """
    if len(shadings) < 2:
        return Section(), ()
    base = shadings[0]

    def compare(other: BurstShading) -> BurstDifference:
        return BurstDifference(base=base, other=other, channels=_channels(base, other))

    differences = tuple(one for one in in_threads(compare, shadings[1:], workers=workers) if one.channels)
    return Section(curves=(_curve(differences),), findings=_findings(differences)), differences


def _channels(base: BurstShading, other: BurstShading) -> tuple[tuple[str, ShadingDifference], ...]:
    found: list[tuple[str, ShadingDifference]] = []
    theirs = {one.channel: one.data for one in other.channels}
    for one in base.channels:
        if one.channel in theirs:
            with suppress(ValueError):  # too few bins that both have
                found.append((one.channel, compare_shading(one.data, theirs[one.channel])))
    return tuple(found)


def _curve(differences: Sequence[BurstDifference]) -> Curve:
    found = [(one.other, channel, own) for one in differences for channel, own in one.channels]
    return Curve(
        name="shading_comparison",
        columns=(
            Column(name="iso", unit="1", values=tuple(other.iso for other, _, _ in found)),
            Column(name="exposure_s", unit="s", values=tuple(other.burst.exposure_s for other, _, _ in found)),
            Column(name="channel", unit="", values=tuple(channel for _, channel, _ in found)),
            Column(name="rms", unit="1", values=tuple(own.rms for _, _, own in found)),
            Column(name="largest_over_error", unit="1", values=tuple(own.largest for _, _, own in found)),
            Column(name="chi_square", unit="1", values=tuple(own.chi_square for _, _, own in found)),
            Column(name="dof", unit="1", values=tuple(own.dof for _, _, own in found)),
            Column(name="p_value", unit="1", values=tuple(own.p_value for _, _, own in found)),
        ),
    )


def _findings(differences: Sequence[BurstDifference]) -> tuple[Finding, ...]:
    tests = sum(len(one.channels) for one in differences)
    worst = [
        (own.rms, channel, one.other)
        for one in differences
        for channel, own in one.channels
        if own.p_value < SIGNIFICANCE / tests and own.rms > NOTABLE
    ]
    if not worst:
        return ()
    rms, channel, other = max(worst, key=lambda one: one[0])
    iso = "" if other.iso is None else f"ISO {other.iso:g}, "
    message = (
        f"lens shading is not the same in every burst: {len(worst)} of {tests} maps differ from the first by more than "
        f"their errors, the most {100.0 * rms:.2g} % rms ({channel}, {iso}{show_exposure(other.burst.exposure_s)}); "
        "look for stray light, a light source that moved, or a response that is not linear"
    )
    return (Finding(code="shading-differs", severity=Severity.INFO, message=message),)
