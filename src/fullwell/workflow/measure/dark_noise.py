"""The noise of one dark frame: read noise, shot noise of the dark current, fixed pattern (METHOD 4.6)."""

import math
from collections.abc import Iterable

from fullwell.figures.conversions import to_electrons
from fullwell.figures.results import Row
from fullwell.glossary import RECOMMENDED
from fullwell.statistics.series import PlaneStatistics
from fullwell.units import DN, DN2, DN_PER_SECOND, Measured, combined_dof, square_root
from fullwell.workflow.measure.bursts import IsoBursts
from fullwell.workflow.measure.section import RowWriter, Section


def measure_dark_noise(bursts: IsoBursts, rows: Iterable[Row]) -> Section:
    """Add up the dark noise of every channel whose read noise, dark current and system gain are known.

    The shot variance of the dark current is K times the dark signal, never the square of the dark signal.
    """
    known = {(row.quantity, row.channel, row.measured.unit): row for row in rows if RECOMMENDED in row.flags}
    written: list[Row] = []
    for channel in bursts.channels:
        read = known.get(("read_noise_variance", channel, DN2))
        current = known.get(("dark_current", channel, DN_PER_SECOND))
        gain_row = known.get(("system_gain", channel, "DN/e-"))
        if read is None or current is None or gain_row is None or bursts.unlit[0].frames < 2:
            continue
        system_gain = gain_row.measured
        pattern = _pattern_variance(bursts.unlit[0].plane(channel))
        flags = {flag for row in (read, current, gain_row) for flag in row.flags} - {RECOMMENDED, "upper-limit"}
        for burst in bursts.darks:
            shot = _shot_variance(current.measured, system_gain, burst.exposure_s)
            total = _sum(read.measured, shot, pattern)
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
                    flags=flags,
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


def _pattern_variance(plane: PlaneStatistics) -> Measured:
    """Return the fixed-pattern variance of the plane, undetrended, temporal noise removed (METHOD 5.1) [DN^2]."""
    left = plane.temporal_variance / plane.frames
    value = plane.spatial_variance - left
    freedom = plane.n * (plane.frames - 1)
    return Measured.normal(value, math.sqrt(2.0 * plane.spatial_variance**2 / plane.n + 2.0 * left**2 / freedom), DN2)


def _sum(*variances: Measured) -> Measured:
    errors = [(one.std_error or 0.0, one.dof) for one in variances]
    value, error = sum(one.value for one in variances), math.hypot(*(error for error, _ in errors))
    return Measured.student(value, error, combined_dof(*errors), DN2)
