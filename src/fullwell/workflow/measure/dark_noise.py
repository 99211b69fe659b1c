"""The noise of one dark frame: read noise, shot noise of the dark current, fixed pattern (METHOD 4.6)."""

import math
from collections.abc import Iterable

from fullwell.figures.conversions import to_electrons
from fullwell.figures.results import Row
from fullwell.glossary import RECOMMENDED
from fullwell.units import DN, DN2, DN_PER_SECOND, Measured, combined_dof, square_root
from fullwell.workflow.measure.bursts import IsoBursts
from fullwell.workflow.measure.nonuniformity import darkest_burst
from fullwell.workflow.measure.read_noise import choose_burst
from fullwell.workflow.measure.section import RowWriter, Section


def measure_dark_noise(bursts: IsoBursts, rows: Iterable[Row]) -> Section:
    """Add up the dark noise of every channel whose read noise, dark current, DSNU and system gain are known.

    The shot variance of the dark current is K times the dark signal, never the square of the dark signal.
    """
    known = {(row.quantity, row.channel, row.measured.unit): row for row in rows if RECOMMENDED in row.flags}
    written: list[Row] = []
    for channel in bursts.channels:
        read = known.get(("read_noise_variance", channel, DN2))
        current = known.get(("dark_current", channel, DN_PER_SECOND))
        gain_row = known.get(("system_gain", channel, "DN/e-"))
        pattern = known.get(("dsnu_variance", channel, DN2))
        if read is None or current is None or gain_row is None or pattern is None:
            continue
        system_gain = gain_row.measured
        flags = {flag for row in (read, current, gain_row, pattern) for flag in row.flags}
        unlit = _unlit(bursts, read, pattern)
        for burst in bursts.darks:
            total = _sum(unlit, _shot_variance(current.measured, system_gain, burst.exposure_s))
            if total.value <= 0.0:
                continue
            noise = square_root(total, DN)
            written += [
                RowWriter(bursts=bursts).row(
                    "total_dark_noise",
                    channel,
                    "noise-model",
                    measured,
                    source="METHOD 4.6",
                    exposure_s=burst.exposure_s,
                    flags=flags - {RECOMMENDED, "upper-limit"},
                )
                for measured in (noise, to_electrons(noise, system_gain))
            ]
    return Section(rows=tuple(written))


def _shot_variance(dark_current: Measured, system_gain: Measured, exposure_s: float) -> Measured:
    """Return K i t of a dark current in DN/s [DN^2]."""
    value = system_gain.value * dark_current.value * exposure_s
    by_current = system_gain.value * exposure_s * (dark_current.std_error or 0.0)
    by_system_gain = abs(dark_current.value) * exposure_s * (system_gain.std_error or 0.0)
    dof = combined_dof((by_current, dark_current.dof), (by_system_gain, system_gain.dof))
    return Measured.student(value, math.hypot(by_current, by_system_gain), dof, DN2)


def _unlit(bursts: IsoBursts, read: Row, pattern: Row) -> Measured:
    """Return the noise of one frame in no time: what frames scatter by, and what pixels differ by [DN^2].

    The pattern is what is left when a share of the same noise is taken off: what one has too much the other lacks. Of
    rounded codes only ends are known, which one phase moves together.
    """
    if "quantization-limited" in {*read.flags, *pattern.flags}:
        return _sum(read.measured, pattern.measured, together=True)
    burst = choose_burst(bursts)
    same = burst is not None and burst == darkest_burst(bursts)
    return _sum(read.measured, pattern.measured, common=1.0 / burst.frames if burst is not None and same else 0.0)


def _sum(first: Measured, second: Measured, *, common: float = 0.0, together: bool = False) -> Measured:
    """Return the sum of two variances [DN^2].

    Parameters
    ----------
    first, second
        Independent, but for ``common``, the share of the first that was taken off the second [1].
    together
        Whether the ends of their intervals add up.

    """
    error, other = (one.std_error or 0.0 for one in (first, second))
    apart = math.hypot(error, other)
    std_error = math.sqrt(max(apart**2 - 2.0 * common * error**2, 0.0))
    ends = zip(*(one.ci95 or (one.value, one.value) for one in (first, second)), strict=True)
    sides = [(abs(first.value - one), abs(second.value - another)) for one, another in ends]
    below, above = (
        sum(side) if together else math.hypot(*side) * (std_error / apart if apart else 1.0) for side in sides
    )
    value = first.value + second.value
    return Measured(
        value=value,
        unit=DN2,
        std_error=std_error,
        dof=combined_dof((error, first.dof), (other, second.dof)),
        ci95=(value - below, value + above),
    )
