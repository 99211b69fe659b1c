"""Masked pixels as evidence for the black level of a study (METHOD 2.3 (iii))."""

from collections.abc import Sequence
from typing import Final

import numpy as np

from fullwell.figures.results import Row
from fullwell.findings import Finding, Severity
from fullwell.fit.black_level import Evidence
from fullwell.units import DN, Measured
from fullwell.workflow.masked import MaskedArea
from fullwell.workflow.measure.bursts import IsoBursts
from fullwell.workflow.measure.read_noise import choose_burst
from fullwell.workflow.measure.section import RowWriter

OPTICAL_BLACK: Final = "optical-black"
APART_DN: Final = 0.5
"""Least distance from the dark frames' level that is worth telling [DN]."""
APART_ERRORS: Final = 4.0
NOISIER: Final = 1.25
"""Ratio of variances beyond which masked pixels are not like those of the active area."""


def masked_evidence(area: MaskedArea | None, bursts: IsoBursts) -> Evidence | None:
    """Return masked pixels as evidence; None where there are none, or their noise is not that of the active area."""
    if area is None or noise_ratio(area, bursts) > NOISIER:
        return None
    return Evidence(method=OPTICAL_BLACK, measured=Measured.normal(area.mean_dn, area.std_error_dn, DN))


def noise_ratio(area: MaskedArea, bursts: IsoBursts) -> float:
    """Return the variance of masked pixels over that of an unlit frame; 0 where there is no unlit burst [1]."""
    burst = choose_burst(bursts)
    if burst is None:
        return 0.0
    plane = burst.plane(area.channel)
    variance = plane.temporal_variance + plane.fixed_spread**2
    return area.variance_dn2 / max(variance, 1.0 / 12.0)


def masked_rows(masked: Sequence[MaskedArea], bursts: IsoBursts) -> tuple[Row, ...]:
    """Return the level of the masked pixels of every channel."""
    write = RowWriter(bursts=bursts).row
    return tuple(
        write(
            "black_level",
            area.channel,
            OPTICAL_BLACK,
            Measured.normal(area.mean_dn, area.std_error_dn, DN),
            source="METHOD 2.3 (iii)",
            n=area.n,
        )
        for area in masked
    )


def masked_findings(
    masked: Sequence[MaskedArea], darks: Sequence[Measured | None], bursts: IsoBursts
) -> tuple[Finding, ...]:
    """Return where masked pixels are noisier than the active area, or their level is not that of the dark frames.

    Parameters
    ----------
    masked
        By channel, or none.
    darks
        What dark frames say of each channel's black level.

    """
    findings: list[Finding] = []
    noisier = [area for area in masked if noise_ratio(area, bursts) > NOISIER]
    if noisier:
        said = ", ".join(f"{area.channel} {noise_ratio(area, bursts):.2f}" for area in noisier)
        message = (
            f"Optical black at {bursts.label} is noisier than unlit frames (ratio of variances: {said}): it is not "
            "like the active area, and its level is not used."
        )
        findings.append(Finding(code="optical-black-noisier", severity=Severity.WARNING, message=message))
    apart = [
        (area, dark.value)
        for area, dark in zip(masked, darks, strict=bool(masked))
        if dark is not None
        and abs(area.mean_dn - dark.value)
        > max(APART_DN, APART_ERRORS * float(np.hypot(area.std_error_dn, dark.std_error or 0.0)))
    ]
    if apart:
        said = ", ".join(f"{area.channel} {area.mean_dn:.2f} against {dark:.2f} DN" for area, dark in apart)
        message = (
            f"Optical black at {bursts.label} is not the level of the dark frames ({said}): dark frames are used; a "
            "camera that subtracts optical black leaves that difference in the picture."
        )
        findings.append(Finding(code="optical-black-differs", severity=Severity.WARNING, message=message))
    return tuple(findings)
