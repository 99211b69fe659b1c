"""Dark current and the level at zero exposure, from bursts in the dark (METHOD 4.1 to 4.3, 4.5).

Which fit: `fit_dark_line` on burst means is the honest one, because whole bursts drift together; on frame means it is
sharper, and right where `burst_effect` finds no such drift. `fit_dark_variance_slope` needs no mean level, so it also
works where the camera subtracts its dark level itself.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.special import chdtrc, fdtrc

from fullwell.fit.photon_transfer import fit_photon_transfer
from fullwell.fit.solvers import levenberg_marquardt
from fullwell.units import DN, DN_PER_SECOND, ELECTRON_PER_SECOND, Measured, student_975, welch_dof


@dataclass(frozen=True, slots=True, kw_only=True)
class DarkLine:
    """mean = intercept + slope * exposure, fitted.

    Parameters
    ----------
    slope
        Dark current [DN/s].
    intercept
        Black level [DN].
    resolvable_slope_dn_per_s
        Half the 95 % interval: the smallest dark current this design can tell from none; None without errors.
    exposure_for_10_percent_s
        Longest exposure that the same design, stretched in time, needs for a slope good to 10 %; None where the slope
        is not positive or has no error [s].
    residuals
        Burst means less the line, shape (n,) [DN].

    """

    slope: Measured
    intercept: Measured
    resolvable_slope_dn_per_s: float | None
    exposure_for_10_percent_s: float | None
    residuals: NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True)
class BurstEffect:
    """Whether bursts scatter about the line more than their frames scatter within them (METHOD 4.1).

    Parameters
    ----------
    p_value
        Chance of a larger ratio of the mean squares, about the line over within bursts, without drift.
    intraburst_correlation
        Share of the variance that frames of a burst have in common.

    """

    p_value: float
    intraburst_correlation: float


@dataclass(frozen=True, slots=True, kw_only=True)
class DarkVarianceSlope:
    """Dark current from its shot noise (METHOD 4.3).

    Parameters
    ----------
    electrons
        Slope of the variance over K^2 [e-/s].
    dn
        Slope of the variance over K [DN/s].
    misfit
        Whether the variance does not grow along a line.

    """

    electrons: Measured
    dn: Measured
    misfit: bool


@dataclass(frozen=True, slots=True, kw_only=True)
class DoublingFit:
    """I = I0 2^((T - T0) / Td), fitted (METHOD 4.5).

    Parameters
    ----------
    dark_current
        I0 at the reference temperature, in the unit of the data.
    doubling_c
        Td; its interval is that of the rate 1 / Td, turned over, and None where the rate may be 0 [K].
    deviance, deviance_dof
        Chi-square of the fit.
    misfit
        Whether it lies beyond its 99 % point: errors are scaled.

    """

    dark_current: Measured
    doubling_c: Measured
    deviance: float
    deviance_dof: int
    misfit: bool


def fit_dark_line(
    exposure_s: ArrayLike,
    burst_mean_dn: ArrayLike,
    *,
    weights: ArrayLike | None = None,
    mean_std_error_dn: ArrayLike | None = None,
    mean_dof: ArrayLike | None = None,
) -> DarkLine:
    """Fit a line through burst means (or frame means) against exposure (METHOD 4.1, 4.2).

    Parameters
    ----------
    exposure_s
        Shape (n,), at least two different exposures [s].
    burst_mean_dn
        Shape (n,) [DN].
    weights
        Relative weights, the number of frames of each burst for instance; equal by default.
    mean_std_error_dn
        Known standard error of each mean, used only where the scatter about the line cannot say it: with two means,
        or with none at all. Without it the errors are None there [DN].
    mean_dof
        Degrees of freedom of those errors (frames less one, where they come from frame means); many by default.

    Returns
    -------
    DarkLine
        Errors from the scatter about the line, Student's t with n - 2 degrees of freedom: no pixel noise enters, so
        drift from burst to burst is covered.

    Raises
    ------
    ValueError
        Where there are fewer than two different exposures.

    """
    time, level = np.asarray(exposure_s, np.float64), np.asarray(burst_mean_dn, np.float64)
    if np.unique(time).size < 2:
        raise ValueError("a dark current needs dark frames at two or more different exposures")
    weight = np.ones(time.size) if weights is None else np.asarray(weights, np.float64)
    design = np.stack([np.ones_like(time), time], axis=-1)
    inverse = np.asarray(np.linalg.inv(design.T @ (weight[:, None] * design)), np.float64)
    projection = inverse @ (design * weight[:, None]).T
    intercept, slope = (float(value) for value in projection @ level)
    residuals = level - intercept - slope * time
    dof = time.size - 2
    scatter = float(weight @ residuals**2) / dof if dof > 0 else 0.0
    if scatter > 0.0:
        return _dark_line((intercept, slope), inverse * scatter, float(dof), time, residuals)
    if mean_std_error_dn is None:
        return _dark_line((intercept, slope), None, None, time, residuals)
    known = np.broadcast_to(np.asarray(mean_std_error_dn, np.float64), time.shape)
    covariance = np.asarray((projection * known**2) @ projection.T, np.float64)
    known_dof = np.broadcast_to(np.asarray(math.inf if mean_dof is None else mean_dof, np.float64), time.shape)
    slope_dof = welch_dof(*zip((projection[1] * known).tolist(), known_dof.tolist(), strict=True))
    return _dark_line((intercept, slope), covariance, slope_dof, time, residuals)


def burst_effect(exposure_s: ArrayLike, frame_means_dn: Sequence[NDArray[np.float64]]) -> BurstEffect:
    """Test whether frames of a burst drift together (METHOD 4.1).

    Parameters
    ----------
    exposure_s
        Exposure of each burst, shape (n,), n at least 3 [s].
    frame_means_dn
        Frame means of each burst; together more frames than bursts [DN].

    Raises
    ------
    ValueError
        Where there are too few bursts or frames to tell.

    """
    sizes = np.array([means.size for means in frame_means_dn], dtype=np.float64)
    between_dof, within_dof = sizes.size - 2, int(sizes.sum()) - sizes.size
    if between_dof < 1 or within_dof < 1:
        raise ValueError("drift between bursts shows only in three or more bursts of two or more frames")
    centres = np.array([means.mean() for means in frame_means_dn])
    line = fit_dark_line(exposure_s, centres, weights=sizes)
    between = float(sizes @ line.residuals**2) / between_dof
    within = sum(float(np.sum((means - means.mean()) ** 2)) for means in frame_means_dn) / within_dof
    if within <= 0.0:
        return BurstEffect(p_value=0.0, intraburst_correlation=1.0)
    shared = max(between - within, 0.0)
    return BurstEffect(
        p_value=float(fdtrc(between_dof, within_dof, between / within)),
        intraburst_correlation=shared / (shared + float(sizes.mean()) * within),
    )


def fit_dark_variance_slope(
    exposure_s: ArrayLike, variance_dn2: ArrayLike, dof: ArrayLike, *, system_gain: Measured
) -> DarkVarianceSlope:
    """Return the dark current from the growth of the temporal variance with exposure (METHOD 4.3, 4.6).

    Parameters
    ----------
    exposure_s
        Shape (n,), at least two different exposures [s].
    variance_dn2
        Temporal variance of the dark frames [DN^2].
    dof
        Degrees of freedom of each: 2 variance^2 / std_error^2.
    system_gain
        K [DN/e-].

    """
    fit = fit_photon_transfer(exposure_s, variance_dn2, dof, n=None, terms=2, reject_outliers=False)
    slope = fit.coefficient(1, "DN^2/s")
    return DarkVarianceSlope(
        electrons=_over_power(slope, system_gain, 2, ELECTRON_PER_SECOND),
        dn=_over_power(slope, system_gain, 1, DN_PER_SECOND),
        misfit=fit.misfit,
    )


def slopes_disagree(mean_slope: Measured, variance_slope: Measured, *, limit: float = 3.0) -> bool:
    """Return whether two dark currents differ by more than ``limit`` standard errors (METHOD 4.3)."""
    error = math.hypot(mean_slope.std_error or 0.0, variance_slope.std_error or 0.0)
    return abs(mean_slope.value - variance_slope.value) > limit * error


def fit_doubling_temperature(
    temperature_c: ArrayLike, dark_current: ArrayLike, std_error: ArrayLike, *, reference_c: float, unit: str
) -> DoublingFit:
    """Fit the doubling of the dark current with temperature by weighted least squares (METHOD 4.5).

    Parameters
    ----------
    temperature_c
        Shape (n,), n at least 2 [degC].
    dark_current
        May be zero or negative where noise made it so [``unit``].
    std_error
        Of each dark current [``unit``].
    reference_c
        T0 [degC].
    unit
        Of the dark current.

    """
    degrees = np.asarray(temperature_c, np.float64) - reference_c
    current, error = np.asarray(dark_current, np.float64), np.asarray(std_error, np.float64)
    usable = current > error
    if usable.sum() < 2:
        raise ValueError("a doubling temperature needs two or more dark currents above their errors")
    rate, start = np.polyfit(degrees[usable], np.log2(current[usable]), 1, w=(current / error)[usable])

    def residuals(parameters: NDArray[np.float64]) -> NDArray[np.float64]:
        return (np.exp2(parameters[0] + parameters[1] * degrees) - current) / error

    def jacobian(parameters: NDArray[np.float64]) -> NDArray[np.float64]:
        by_level = math.log(2.0) * np.exp2(parameters[0] + parameters[1] * degrees) / error
        return np.stack([by_level, by_level * degrees], axis=-1)

    solution, covariance, deviance = levenberg_marquardt(residuals, jacobian, np.array([start, rate]))
    level, rate, dof = float(2.0 ** solution[0]), float(solution[1]), degrees.size - 2
    misfit = dof > 0 and chdtrc(dof, deviance) < 0.01
    scale = math.sqrt(deviance / dof) if misfit else 1.0
    level_error, rate_error = (scale * math.sqrt(covariance[i, i]) for i in (0, 1))
    half = student_975(dof if misfit else None) * rate_error
    doubling = Measured(
        value=1.0 / rate,
        unit="K",
        std_error=rate_error / rate**2,
        dof=float(dof) if misfit else None,
        ci95=(1.0 / (rate + half), 1.0 / (rate - half)) if half < rate else None,
    )
    return DoublingFit(
        dark_current=Measured.normal(level, level * math.log(2.0) * level_error, unit),
        doubling_c=doubling,
        deviance=deviance,
        deviance_dof=dof,
        misfit=misfit,
    )


def _dark_line(
    line: tuple[float, float],
    covariance: NDArray[np.float64] | None,
    dof: float | None,
    time: NDArray[np.float64],
    residuals: NDArray[np.float64],
) -> DarkLine:
    intercept, slope = line
    if covariance is None:
        return DarkLine(
            slope=Measured.exact(slope, DN_PER_SECOND),
            intercept=Measured.exact(intercept, DN),
            resolvable_slope_dn_per_s=None,
            exposure_for_10_percent_s=None,
            residuals=residuals,
        )
    slope_error = math.sqrt(covariance[1, 1])
    return DarkLine(
        slope=Measured.student(slope, slope_error, dof, DN_PER_SECOND),
        intercept=Measured.student(intercept, math.sqrt(covariance[0, 0]), dof, DN),
        resolvable_slope_dn_per_s=student_975(dof) * slope_error,
        exposure_for_10_percent_s=float(time.max()) * slope_error / (0.1 * slope) if slope > 0.0 else None,
        residuals=residuals,
    )


def _over_power(slope: Measured, system_gain: Measured, power: int, unit: str) -> Measured:
    value = slope.value / system_gain.value**power
    relative = power * (system_gain.std_error or 0.0) / system_gain.value
    error = math.hypot((slope.std_error or 0.0) / system_gain.value**power, value * relative)
    return Measured.student(value, error, slope.dof, unit)
