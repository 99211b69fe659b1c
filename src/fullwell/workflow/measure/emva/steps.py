"""From bursts to the exposure sweep of a channel: which frames are pairs, which darks belong to them."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from fullwell.figures.emva1288.line import Line, fit_line
from fullwell.figures.emva1288.sweep import Floats, Sweep
from fullwell.findings import Finding, Severity
from fullwell.frames.selection import EXPOSURE_TOLERANCE
from fullwell.report.numbers import show_exposure
from fullwell.statistics.pairs import PairStatistics
from fullwell.workflow.measure.bursts import Burst, IsoBursts

FEWEST_STEPS = 9
"""Steps of a sweep, well chosen, that the standard can do with."""

_USUAL_STEPS = 50

_STEADY_C = 5.0
"""Spread of temperatures that warming up explains [degree Celsius]; dark current doubles within 5 to 10."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class DarkSeries:
    """Dark pairs by ascending exposure; arrays of shape (exposures,).

    Parameters
    ----------
    exposure_s, mean, variance
        [s, DN, DN^2].
    lowest
        The pair at the shortest exposure.

    """

    exposure_s: Floats
    mean: Floats
    variance: Floats
    lowest: PairStatistics

    @property
    def lines(self) -> tuple[Line, Line] | None:
        """Return the lines of mean and of variance against time, None for a single exposure."""
        if np.unique(self.exposure_s).size < 2:
            return None
        return fit_line(self.exposure_s, self.mean), fit_line(self.exposure_s, self.variance)

    def at(self, exposure_s: float) -> tuple[float, float, bool]:
        """Return mean and variance at an exposure, and whether darks were taken there.

        Where none were, both are read off their lines; a single dark stands for every exposure.
        """
        nearest = int(np.argmin(np.abs(self.exposure_s - exposure_s)))
        if abs(self.exposure_s[nearest] - exposure_s) <= EXPOSURE_TOLERANCE * exposure_s:
            return float(self.mean[nearest]), float(self.variance[nearest]), True
        lines = self.lines
        if lines is None:
            return float(self.mean[nearest]), float(self.variance[nearest]), False
        mean, variance = (float(line.at(np.array([exposure_s]))[0]) for line in lines)
        return mean, max(variance, 0.0), False


def _pair(burst: Burst, channel: str) -> PairStatistics | None:
    return burst.plane(channel).pair


def _pairs(bursts: Sequence[Burst]) -> tuple[Burst, ...]:
    """Return the bursts that hold pairs: not the stacks where pairs are told apart from them."""
    usable = [burst for burst in bursts if burst.frames > 1]
    return tuple(burst for burst in usable if burst.series.stack is not True) or tuple(usable)


def dark_series(bursts: IsoBursts, channel: str) -> DarkSeries | None:
    """Return the dark pairs of a channel; a stack serves at exposures without a pair of their own."""
    darks = list(_pairs(bursts.darks))
    taken = {burst.exposure_s for burst in darks}
    darks += [burst for burst in bursts.darks if burst.frames > 1 and burst.exposure_s not in taken]
    known = [(burst.exposure_s, pair) for burst in darks if (pair := _pair(burst, channel)) is not None]
    if not known:
        return None
    known.sort(key=lambda one: one[0])
    return DarkSeries(
        exposure_s=np.array([exposure for exposure, _ in known]),
        mean=np.array([pair.mean for _, pair in known]),
        variance=np.array([pair.temporal_variance for _, pair in known]),
        lowest=known[0][1],
    )


def sweep_of(bursts: IsoBursts, channel: str, darks: DarkSeries, *, top_code: float | None) -> Sweep | None:
    """Return the sweep of a channel, None where there are no pairs of flats.

    Photons are known of all steps or of none; steps stand by ascending exposure and photons.
    """
    flats = [burst for burst in _pairs(bursts.flats) if _pair(burst, channel) is not None]
    if not flats:
        return None
    flats.sort(key=lambda burst: (burst.exposure_s, burst.series.photons or 0.0))
    if len({burst.exposure_s for burst in flats}) < len(flats):
        flats.sort(key=lambda burst: burst.series.photons or burst.plane(channel).mean)
    pairs = [pair for burst in flats if (pair := _pair(burst, channel)) is not None]
    dark = [darks.at(burst.exposure_s) for burst in flats]
    photons = [burst.series.photons for burst in flats]
    known = [one for one in photons if one is not None]
    filtered = [pair.filtered_variance for pair in pairs]
    return Sweep(
        n=pairs[0].n,
        exposure_s=np.array([burst.exposure_s for burst in flats]),
        photons=np.array(known) if len(known) == len(photons) else None,
        mean=np.array([pair.mean for pair in pairs]),
        dark_mean=np.array([mean for mean, _, _ in dark]),
        variance=np.array([pair.temporal_variance for pair in pairs]),
        dark_variance=np.array([variance for _, variance, _ in dark]),
        mean_difference=np.array([pair.mean_difference for pair in pairs]),
        spatial_variance=np.array([np.nan if one is None else one for one in filtered]),
        top_fraction=np.array([_top_fraction(burst, channel, top_code) for burst in flats]),
        dark_measured=np.array([measured for _, _, measured in dark]),
    )


def _top_fraction(burst: Burst, channel: str, top_code: float | None) -> float:
    """Return which part of all values lies at the highest code."""
    if top_code is None:
        return 0.0
    plane = burst.plane(channel)
    at_top = plane.tiles.highest >= top_code
    return float(plane.tiles.n_highest[at_top].sum()) / (plane.n * plane.frames)


def values_per_step(bursts: IsoBursts, channel: str) -> float:
    """Return the pixel values that stand behind each step's fraction at the highest code, at least."""
    flats = _pairs(bursts.flats)
    return float(min((burst.plane(channel).n * burst.frames for burst in flats), default=0))


def temperature_findings(bursts: IsoBursts) -> tuple[Finding, ...]:
    """Warn of frames at different temperatures: they are evaluated as one operation point."""
    frames = [frame for burst in (*bursts.flats, *bursts.darks) for frame in burst.series.frames]
    known = [frame.header.temperature_c for frame in frames if frame.header.temperature_c is not None]
    if not known or max(known) - min(known) <= _STEADY_C:
        return ()
    message = (
        f"frames at {bursts.label} were taken at {min(known):.1f} to {max(known):.1f} °C and are evaluated as one "
        "operation point; give each temperature a study of its own"
    )
    return (Finding(code="emva-temperatures", severity=Severity.WARNING, message=message),)


def sweep_findings(bursts: IsoBursts, sweep: Sweep, darks: DarkSeries) -> tuple[Finding, ...]:
    """Return what is to be said of a sweep before it is evaluated."""
    findings: list[Finding] = []
    if sweep.steps < _USUAL_STEPS:
        wish = "at least 9, and at least 50" if sweep.steps < FEWEST_STEPS else "at least 50"
        message = f"the sweep at {bursts.label} has {sweep.steps} steps; EMVA 1288 wants {wish} equally spaced ones"
        findings.append(Finding(code="emva-few-steps", severity=Severity.INFO, message=message))
    without = sweep.exposure_s[~sweep.dark_measured]
    if without.size:
        how = (
            f"read off a line through the darks at {darks.exposure_s.size} exposures"
            if darks.lines is not None
            else f"taken from the darks at {show_exposure(float(darks.exposure_s[0]))}, dark current neglected"
        )
        listed = ", ".join(show_exposure(float(one)) for one in without[:8]) + (" ..." if without.size > 8 else "")
        message = f"no darks at {listed} at {bursts.label}: the dark signal there is {how}"
        findings.append(Finding(code="emva-dark-line", severity=Severity.WARNING, message=message))
    if sweep.photons is None:
        message = (
            f"no photons are known at {bursts.label}: responsivity, quantum efficiency and all figures in photons are "
            "not given; state photons of each series, or irradiance, wavelength and pixel area, in study.toml"
        )
        findings.append(Finding(code="emva-no-photons", severity=Severity.WARNING, message=message))
    rising = np.diff(sweep.mean)
    drop = rising < -5.0 * np.hypot(sweep.signal_error[1:], sweep.signal_error[:-1])
    if np.any(drop & (sweep.top_fraction[:-1] < 0.001)):
        step = int(np.flatnonzero(drop)[0])
        message = (
            f"the mean falls from {sweep.mean[step]:.6g} to {sweep.mean[step + 1]:.6g} DN between steps {step + 1} and "
            f"{step + 2} of the sweep at {bursts.label}: check the order of exposures and photons"
        )
        findings.append(Finding(code="emva-not-rising", severity=Severity.WARNING, message=message))
    return tuple(findings)
