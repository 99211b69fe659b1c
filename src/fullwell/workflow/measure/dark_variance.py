"""Dark current again, from the growth of the temporal variance: on-chip clamping cannot hide it (METHOD 4.3)."""

from collections.abc import Mapping

from fullwell.figures.results import Row
from fullwell.findings import Finding, Severity
from fullwell.fit.dark import fit_dark_variance_slope, slopes_disagree
from fullwell.fit.variance_components import temporal_variance
from fullwell.statistics.series import PlaneStatistics
from fullwell.units import Measured
from fullwell.workflow.measure.bursts import IsoBursts
from fullwell.workflow.measure.dark_level import mean_dark_line
from fullwell.workflow.measure.section import RowWriter, Section


def measure_dark_variance(bursts: IsoBursts, system_gain: Mapping[str, Measured]) -> Section:
    """Measure dark current from the variance slope where the system gain is known."""
    unlit = [burst for burst in bursts.unlit if burst.frames > 1]
    if len({burst.exposure_s for burst in unlit}) < 3:
        return Section()
    rows: list[Row] = []
    apart: list[str] = []
    for channel in bursts.channels:
        channel_gain, line = system_gain.get(channel), mean_dark_line(unlit, (channel,))
        if channel_gain is None or line is None or channel in bursts.black_clipped:
            continue
        planes = [burst.plane(channel) for burst in unlit]
        if min(plane.temporal_variance for plane in planes) <= 0.0:
            continue
        slope = fit_dark_variance_slope(
            [burst.exposure_s for burst in unlit],
            [plane.temporal_variance for plane in planes],
            [_variance_dof(plane) for plane in planes],
            system_gain=channel_gain,
        )
        n = sum(plane.n * plane.frames for plane in planes)
        write = RowWriter(bursts=bursts).row
        flags = ("model-misfit",) if slope.misfit else ()
        rows += [
            write("dark_current", channel, "variance-slope", measured, source="METHOD 4.3", n=n, flags=flags)
            for measured in (slope.dn, slope.electrons)
        ]
        if slopes_disagree(line.slope, slope.dn):
            apart.append(channel)
    return Section(rows=tuple(rows), findings=_findings(bursts, apart))


def _variance_dof(plane: PlaneStatistics) -> float:
    """Return the effective degrees of freedom of a temporal variance, row and column noise counted."""
    measured = temporal_variance(
        plane.mean_squares,
        plane.shape,
        pixel_scatter_dn4=plane.temporal_variance_scatter,
    )
    if not measured.std_error:
        return float(plane.n * (plane.frames - 1))
    return 2.0 * (measured.value / measured.std_error) ** 2


def _findings(bursts: IsoBursts, apart: list[str]) -> tuple[Finding, ...]:
    if not apart:
        return ()
    message = (
        f"dark current of {', '.join(apart)} at {bursts.label} differs between the mean and the variance of the dark "
        "frames by more than three standard errors: an on-chip black clamp hides the mean, or noise grows with time"
    )
    return (Finding(code="dark-current-disagrees", severity=Severity.WARNING, message=message),)
