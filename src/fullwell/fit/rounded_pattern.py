"""Fixed pattern in the dark before quantization, where noise below a code hides it or exaggerates it (METHOD 3.3).

The mean code of a pixel follows its level only where noise carries it over the edge of a code. The cases are those of
`fullwell.fit.read_noise`: noise that leaves a small effect of the unknown phase, which the errors then hold, and noise
so small that every pattern which some phase reconciles with the codes is possible.
"""

import math
from dataclasses import replace
from typing import Final

import numpy as np

from fullwell.fit.nonuniformity import Nonuniformity
from fullwell.fit.read_noise import COVERING_SPREAD, ReadNoise, temporal_range
from fullwell.fit.rounding_region import Range, possible_before_rounding
from fullwell.model.quantization import rounded_pattern, rounded_pattern_at_phase
from fullwell.units import DN2, Measured, student_975

NO_EFFECT: Final = 1.0
"""Noise, in codes, from which on the mean code is the level to 1e-8."""
_PHASES: Final = np.linspace(0.0, 0.5, 9)


def unrounded_nonuniformity(
    found: Nonuniformity, *, temporal: Measured, noise: ReadNoise, pixels: int, step: float = 1.0
) -> tuple[Nonuniformity, bool]:
    """Return a dark pattern before rounding, and whether its codes leave only an interval.

    Parameters
    ----------
    found
        Of the rounded codes [DN^2].
    temporal, noise
        Temporal variance of the same frames, and noise with the quantization removed.
    pixels
        Behind the pattern: where none left the code of the others, the rule of three bounds how many may.
    step
        Distance of two codes q [DN].

    """
    if noise.noise.value >= NO_EFFECT * step:
        return found, False
    rounded = found.total
    variance_dn2 = _mean_law_inverted(rounded.value, noise=noise.noise.value, step=step)
    covered = variance_dn2 >= (COVERING_SPREAD * step) ** 2
    if noise.quantization_limited and not covered:
        seen = temporal_range(temporal, unseen=3.0 / pixels, step=step)
        ends = _over_unknown_phase(rounded, seen, pixels=pixels, step=step)
        return _between(found, variance_dn2, ends), True
    slope, effect = _law(variance_dn2, noise=noise.noise.value, step=step)
    scale = variance_dn2 / rounded.value if rounded.value > 0.0 else 1.0
    share = effect / (math.sqrt(2.0) * rounded.value) if rounded.value > 0.0 else 0.0
    names = ("total", "row", "column", "pixel")
    parts = {name: _widened(getattr(found, name), scale=scale, share=share, slope=slope) for name in names}
    return replace(found, **parts), False


def pattern_phase_effect(variance_dn2: float, *, noise: float, step: float = 1.0) -> float:
    """Return how far one unknown phase moves the variance of a rounded pattern at most from its mean over phases.

    Parameters
    ----------
    variance_dn2
        Of the rounded pattern [DN^2].
    noise, step
        Temporal noise before rounding, and the distance of two codes [DN].

    """
    if noise >= NO_EFFECT * step:
        return 0.0
    return _law(_mean_law_inverted(variance_dn2, noise=noise, step=step), noise=noise, step=step)[1]


def _mean_law_inverted(variance_dn2: float, *, noise: float, step: float) -> float:
    """Return the pattern whose rounded variance, averaged over phases, is the given one; as it is below zero [DN^2]."""
    if variance_dn2 <= 0.0:
        return variance_dn2
    tried = variance_dn2 * np.linspace(0.0, 1.0, 1025)
    return float(np.interp(variance_dn2, rounded_pattern(np.sqrt(tried), noise=noise, step=step), tried))


def _law(variance_dn2: float, *, noise: float, step: float) -> tuple[float, float]:
    """Return the slope of the mean law at a pattern [1], and the most that a phase is off it [DN^2]."""
    spread = math.sqrt(max(variance_dn2, 0.0))
    mean = float(rounded_pattern(spread, noise=noise, step=step))
    effect = np.abs(rounded_pattern_at_phase(spread, step * _PHASES, noise=noise, step=step) - mean).max()
    beside = 0.01 * step**2 + variance_dn2
    slope = (float(rounded_pattern(math.sqrt(max(beside, 0.0)), noise=noise, step=step)) - mean) / (0.01 * step**2)
    return max(slope, 1.0), float(effect)


def _over_unknown_phase(rounded: Measured, temporal: Range, *, pixels: int, step: float) -> Range:
    """Return the ends of all patterns that some noise and phase reconcile with the codes [DN^2]."""
    unseen = 3.0 / pixels
    low, high = rounded.ci95 or (rounded.value, rounded.value)
    possible = possible_before_rounding(temporal, (low / step**2 - unseen, high / step**2 + unseen))
    if possible is None:
        return min(low, 0.0), max(high, 0.0)
    bottom, top = ((step * end) ** 2 for end in possible.pattern)
    return (bottom if bottom > 0.0 else min(low, 0.0)), max(top, high)


def _between(found: Nonuniformity, variance_dn2: float, ends: Range) -> Nonuniformity:
    """Return a pattern of which only an interval is known, and of its parts that none is larger."""

    def limited(value: float, low: float) -> Measured:
        return Measured.interval(value, (ends[1] - low) / math.sqrt(12.0), (low, ends[1]), DN2)

    scale = variance_dn2 / found.total.value if found.total.value > 0.0 else 1.0
    parts = {
        name: limited(part.value * scale, min((part.ci95 or (0.0, 0.0))[0], 0.0))
        for name, part in (("row", found.row), ("column", found.column), ("pixel", found.pixel))
    }
    return replace(found, total=limited(variance_dn2, ends[0]), **parts)


def _widened(part: Measured, *, scale: float, share: float, slope: float) -> Measured:
    """Return a part scaled, with what the unknown phase leaves open of it, a share of it, in its errors."""
    value, phase = part.value * scale, share * abs(part.value)
    reach = student_975(None) * phase
    low, high = part.ci95 or (part.value, part.value)
    below, above = (math.hypot(one, reach) / slope for one in (part.value - low, high - part.value))
    error = math.hypot(part.std_error or 0.0, phase) / slope
    return replace(part, value=value, std_error=error, ci95=(value - below, value + above))
