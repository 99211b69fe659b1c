"""Which unlit frames may be measured: those that neither saturate nor lose their lower half at black."""

from collections.abc import Sequence
from dataclasses import replace

from fullwell.findings import Finding, Severity
from fullwell.fit.censored import is_clipped_low
from fullwell.fit.variance_components import variance_components
from fullwell.report.numbers import show_exposure
from fullwell.statistics.series import PlaneStatistics
from fullwell.workflow.measure.bursts import Burst, IsoBursts
from fullwell.workflow.measure.white_level import WhiteLevel

CODES_THAT_SHOW_A_CUT = 4
MAX_SATURATED = 1e-3
"""Largest share of saturated pixels of a dark frame that still counts as hot pixels, not as saturation."""


def usable_unlit(bursts: IsoBursts, whites: Sequence[WhiteLevel]) -> tuple[IsoBursts, tuple[Finding, ...]]:
    """Return the bursts without saturated dark ones, channels clipped at black named, and what is to be said."""
    saturated = [burst for burst in bursts.unlit if any(_saturates(burst, white) for white in whites)]
    clipped = tuple(
        channel for channel in bursts.channels if any(_is_clipped(burst.plane(channel)) for burst in bursts.unlit)
    )
    kept = replace(
        bursts,
        darks=tuple(burst for burst in bursts.darks if burst not in saturated),
        biases=tuple(burst for burst in bursts.biases if burst not in saturated),
        black_clipped=clipped,
    )
    findings: list[Finding] = []
    if saturated:
        named = ", ".join(f"{burst.kind.value} {show_exposure(burst.exposure_s)}" for burst in saturated)
        message = f"unlit frames at {bursts.label} saturate and are left out ({named}): take shorter dark exposures"
        findings.append(Finding(code="dark-saturated", severity=Severity.WARNING, message=message))
    if clipped:
        message = (
            f"dark frames of {', '.join(clipped)} at {bursts.label} are clipped at black: their means and variances "
            "are wrong, so they give neither black level nor dark current, and read noise comes from the censored "
            "likelihood, which cannot tell it from fixed pattern; have the camera keep a black offset"
        )
        findings.append(Finding(code="black-clipped", severity=Severity.WARNING, message=message))
    return kept, tuple(findings)


def line_noise(bursts: IsoBursts, channel: str) -> tuple[float, float]:
    """Return the temporal row and column variance of one frame, from unlit frames [DN^2]; 0 where these are missing."""
    for burst in bursts.unlit:
        if burst.frames > 1:
            plane = burst.plane(channel)
            parts = variance_components(plane.mean_squares, plane.shape)
            return max(parts.tv.value, 0.0), max(parts.th.value, 0.0)
    return 0.0, 0.0


def _saturates(burst: Burst, white: WhiteLevel) -> bool:
    if white.level_dn is None:
        return False
    plane = burst.plane(white.channel)
    tiles = plane.tiles
    on_white = int(tiles.n_highest[tiles.highest >= white.level_dn].sum())
    return on_white > MAX_SATURATED * plane.n * plane.frames


def _is_clipped(plane: PlaneStatistics) -> bool:
    """Tell whether a plane is cut at its lowest code: at code 0, or where enough codes show the shape of the cut."""
    histogram = plane.histogram
    populated = int((histogram.counts > MAX_SATURATED * histogram.counts.sum()).sum())
    shows = populated >= CODES_THAT_SHOW_A_CUT or (populated > 1 and histogram.first_code == 0)
    fixed = plane.fixed_spread**2
    alike = 1.0 + (plane.frames - 1) * (fixed / (fixed + plane.temporal_variance) if fixed > 0.0 else 0.0)
    return shows and is_clipped_low(histogram.first_code, histogram.counts, alike=alike)
