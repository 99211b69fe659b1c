"""What is to be said of a loop: what was simulated, and which figures do not keep what they claim."""

import math
from collections.abc import Mapping, Sequence
from typing import Final

from fullwell.figures.calibration import Calibration
from fullwell.findings import Finding, Severity, listed
from fullwell.workflow.loop.comparison import Comparison, Figure
from fullwell.workflow.loop.design import RULE, Design
from fullwell.workflow.loop.source import Source

CHANCE: Final = 0.01
"""Probability that a tool without fault is named here, over all figures together."""


def loop_findings(
    source: Source, design: Design, compared: Sequence[Comparison], found: Mapping[Figure, Calibration], *, cameras: int
) -> tuple[Finding, ...]:
    """Return the findings of a loop, beside those of the first camera's measurement.

    Parameters
    ----------
    source, design
        Where the loop started, and what was simulated.
    compared
        Figures of the first camera.
    found
        What all cameras tell of each.
    cameras
        Their number.

    """
    said = [_info("loop-design", _design(source, design, cameras=cameras))]
    said += [_info("loop-assumed", f"for the simulated camera of {source.name}, {one}") for one in source.said]
    judged = [one for one in compared if one.recommended]
    return (*said, *_doubts(judged, found, cameras=cameras))


def _design(source: Source, design: Design, *, cameras: int) -> str:
    width, height = design.size
    text = (
        f"{cameras} camera{'s' if cameras > 1 else ''} of {source.name} simulated, {design.frames} frames of "
        f"{width} x {height} pixels each, and measured through the front door"
    )
    if not design.reduced:
        return text
    original = " x ".join(map(str, design.original_size))
    return f"{text}; the source has {original} pixels: {RULE} (--full keeps the size), so errors are larger here"


def _doubts(judged: Sequence[Comparison], found: Mapping[Figure, Calibration], *, cameras: int) -> tuple[Finding, ...]:
    """Return figures whose pulls or intervals are beyond chance, for as many as were judged (Bonferroni)."""
    limit = CHANCE / max(len(judged), 1)
    if cameras == 1:
        off = [one for one in judged if one.pull is not None and math.erfc(abs(one.pull) / math.sqrt(2.0)) < limit]
        return (_doubt("loop-off-truth", "are off the truth by more than their errors allow", off),) if off else ()
    half = 0.5 * limit
    uncovered = [one for one in judged if _below(found[one.figure].coverage_p, half)]
    unlike = [one for one in judged if _below(found[one.figure].pull_p, half) and one not in uncovered]
    doubts = (
        ("loop-coverage", "have 95 % intervals that hold the truth more or less often than that", uncovered),
        ("loop-pulls", "have errors in standard errors that are not distributed as claimed", unlike),
    )
    return tuple(_doubt(code, what, some) for code, what, some in doubts if some)


def _below(p_value: float | None, limit: float) -> bool:
    return p_value is not None and p_value < limit


def _doubt(code: str, what: str, some: Sequence[Comparison]) -> Finding:
    named = dict.fromkeys(f"{one.row.quantity} ({one.row.method})" for one in some)
    message = (
        f"{len(some)} figures {what}, beyond chance for as many as were judged: {listed(list(named))}; see the chapter "
        "on the loop"
    )
    return Finding(code=code, severity=Severity.WARNING, message=message)


def _info(code: str, message: str) -> Finding:
    return Finding(code=code, severity=Severity.INFO, message=message)
