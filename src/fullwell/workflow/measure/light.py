"""Whether light fell on the frames that it should fall on, and on no others."""

import math
from dataclasses import replace
from typing import Final

from fullwell.findings import Finding, Severity
from fullwell.report.numbers import show_exposure
from fullwell.statistics.series import PlaneStatistics
from fullwell.workflow.measure.bursts import Burst, IsoBursts
from fullwell.workflow.measure.dark_level import mean_dark_line

LEAST_LIGHT: Final = 0.05
"""Signal of the brightest flats in noises of one pixel: as much a black level may drift between two series. More light
tells of photons however dim it is: where pixels read 2.4 e- of noise, 0.12 e- raise their variance by 2 %."""
_SURE: Final = 5.0
"""Standard errors by which means of many pixels and channels differ by chance in no study."""
MOST_OFF_LINE: Final = 1.0
"""Distance of an unlit burst from the line through all in noises of one pixel: drift of a black level is less."""


def lit_flats(bursts: IsoBursts) -> tuple[IsoBursts, tuple[Finding, ...]]:
    """Return the bursts, without flats where not one is brighter than unlit frames, and what is to be said of none."""
    if not bursts.flats:
        message = (
            f"no flat frames at {bursts.label}: system gain is not measured, so nothing is known in electrons; take "
            "bursts of two flats or more at five exposures or more, from dark to saturation"
        )
        return bursts, (Finding(code="no-flat-frames", severity=Severity.WARNING, message=message),)
    if not bursts.unlit or any(_is_lit(flat, bursts) for flat in bursts.flats):
        return bursts, ()
    message = (
        f"the flats at {bursts.label} are no brighter than frames without light and are left out, so that nothing is "
        "known in electrons: was the lens covered, or the lamp off? Take them again"
    )
    finding = Finding(code="flats-without-light", severity=Severity.WARNING, message=message)
    return replace(bursts, flats=()), (finding,)


def unlit_findings(bursts: IsoBursts) -> tuple[Finding, ...]:
    """Say which channel's unlit frames lie further off a line over exposure than a black level drifts."""
    distances = {channel: _off_line(bursts, channel) for channel in bursts.channels}
    worst = max(distances, key=lambda channel: distances[channel])
    if distances[worst] <= MOST_OFF_LINE:
        return ()
    means = ", ".join(
        f"{burst.plane(worst).mean:.1f} DN at {show_exposure(burst.exposure_s)} ({burst.kind.value})"
        for burst in bursts.unlit
    )
    message = (
        f"the unlit frames at {bursts.label} do not follow a rising line over exposure: {worst} has {means}. Light "
        "reached some of them, or exposures are not what the files say; black level and dark current rest on that line"
    )
    return (Finding(code="unlit-off-line", severity=Severity.WARNING, message=message),)


def _is_lit(flat: Burst, bursts: IsoBursts) -> bool:
    unlit = min(bursts.unlit, key=lambda burst: abs(burst.exposure_s - flat.exposure_s))
    pairs = ((flat.plane(channel), unlit.plane(channel)) for channel in bursts.channels)
    return any(_is_brighter(one, other) for one, other in pairs)


def _is_brighter(one: PlaneStatistics, other: PlaneStatistics) -> bool:
    """Tell whether a plane's mean is above another's by more than chance and a drift of the black level make."""
    chance = math.sqrt(1.0 / (one.n * one.frames) + 1.0 / (other.n * other.frames))
    return one.mean - other.mean > max(LEAST_LIGHT, _SURE * chance) * _noise(other)


def _off_line(bursts: IsoBursts, channel: str) -> float:
    """Return how far an unlit burst lies off the line, or how far the line falls, in noises of one pixel."""
    line = None if channel in bursts.black_clipped else mean_dark_line(bursts.unlit, (channel,))
    if line is None:
        return 0.0
    noises = [max(_noise(burst.plane(channel)), 0.5) for burst in bursts.unlit]
    fall = -line.slope.value * (bursts.unlit[-1].exposure_s - bursts.unlit[0].exposure_s)
    return max(fall / max(noises), *(abs(off) / noise for off, noise in zip(line.residuals, noises, strict=True)))


def _noise(plane: PlaneStatistics) -> float:
    """Return the noise of one pixel in one frame, or of a single frame its scatter [DN]."""
    return math.sqrt(max(plane.temporal_variance if plane.frames > 1 else plane.spatial_variance, 0.0))
