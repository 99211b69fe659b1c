"""The noise model of a chart: single frames and bursts, one exposure or several, one channel or all (METHOD 1).

`Observations` hold one row per variance: the temporal variance of a burst, A + B S; and what is left about a smooth
surface in the mean of L frames, (A + B S) / L + C S^2 + E, which for L = 1 is the total variance of a single frame.
Without bursts A and E cannot be told apart and only their sum is fitted.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np
from numpy.typing import NDArray
from scipy.special import fdtrc

from fullwell.fit.goodness import CheckedFit, fit_checked

FEWEST: Final = 5
"""Observations, of as many patches, that a noise model takes at least."""
_LEAST_FRAME: Final = 0.1
"""Of the median variance, that the fitted one of a single frame counts at least: a fit may come out below zero."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Observations:
    """Variances of patches, every array of shape (N,).

    Parameters
    ----------
    signal_dn
        Mean above the black level [DN].
    variance_dn2, dof
        Variance and its degrees of freedom [DN^2].
    low_signal
        Weight of B^2 A in the variance of the variance (METHOD 1.3): 1 / (n L) for temporal variances, 1 / (n L^3) for
        spatial ones.
    frames
        L.
    temporal
        Whether the variance is one between frames.
    channel
        Number of the channel.
    patch
        Number of the patch in its scene: the same at every exposure, never that of another scene.
    line_spread_dn4
        k by which noise that lines share makes a variance scatter wider, by 1 + k over the square of the variance of a
        single frame (METHOD 1.8) [DN^4]; None for none.
    line_covariance_dn4
        Covariance of different variances by lines that they share, shape (N, N) [DN^4]; None for none.

    """

    signal_dn: NDArray[np.float64]
    variance_dn2: NDArray[np.float64]
    dof: NDArray[np.float64]
    low_signal: NDArray[np.float64]
    frames: NDArray[np.float64]
    temporal: NDArray[np.bool_]
    channel: NDArray[np.int64]
    patch: NDArray[np.int64]
    line_spread_dn4: NDArray[np.float64] | None = None
    line_covariance_dn4: NDArray[np.float64] | None = None

    def where(self, kept: NDArray[np.bool_]) -> "Observations":
        """Return some of the observations."""
        return Observations(
            signal_dn=self.signal_dn[kept],
            variance_dn2=self.variance_dn2[kept],
            dof=self.dof[kept],
            low_signal=self.low_signal[kept],
            frames=self.frames[kept],
            temporal=self.temporal[kept],
            channel=self.channel[kept],
            patch=self.patch[kept],
            line_spread_dn4=None if self.line_spread_dn4 is None else self.line_spread_dn4[kept],
            line_covariance_dn4=None if (by_line := self.line_covariance_dn4) is None else by_line[kept][:, kept],
        )

    def of_channel(self, channel: int) -> "Observations":
        """Return those of one channel."""
        return self.where(self.channel == channel)

    @property
    def sufficient(self) -> bool:
        """Tell whether there are patches enough for a fit."""
        lawful = (self.variance_dn2 > 0.0) & (self.dof > 0.0) & ~self.temporal
        levels = np.unique(self.signal_dn[lawful]).size
        return np.unique(self.patch[lawful]).size >= FEWEST and levels >= FEWEST


@dataclass(frozen=True, slots=True, kw_only=True)
class ChartFit(CheckedFit):
    """The fitted model: ``coefficients`` are A [DN^2], B [DN/e-], C [1] of each group of channels, and E [DN^2].

    Parameters
    ----------
    has_bursts
        Whether A is purely temporal and E follows at the end.

    """

    has_bursts: bool = False

    def single_frame(self, group: int = 0) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Return A + E, B, C of one frame and their covariance, shapes (3,) and (3, 3)."""
        collect = np.zeros((3, self.coefficients.size))
        collect[0, 0] = collect[1, 1] = collect[2, 2 + group] = 1.0
        if self.has_bursts:
            collect[0, -1] = 1.0
        return collect @ self.coefficients, collect @ self.covariance @ collect.T


@dataclass(frozen=True, slots=True, kw_only=True)
class SharedModel:
    """One noise model for all channels, and whether they share it (METHOD 1.10).

    Parameters
    ----------
    fit
        A, B and C shared by all.
    p_value
        Chance of a larger likelihood ratio against a model for each channel, if they share one.
    physical
        A and B shared, C of each channel its own.
    physical_p_value
        The same test of it.

    """

    fit: ChartFit
    p_value: float
    physical: ChartFit
    physical_p_value: float


def fit_chart_noise(
    observations: Observations, *, groups: NDArray[np.int64] | None = None, reject_outliers: bool = True
) -> ChartFit:
    """Fit the noise model by gamma likelihood (METHOD 1.2 to 1.4, 1.8).

    Parameters
    ----------
    observations
        At least as many as coefficients.
    groups
        Number of the coefficient C that each observation goes by, from 0 up, shape (N,); one for all by default.
    reject_outliers
        Drop observations with |r| > 4, at most 10 %.

    Returns
    -------
    ChartFit
        Its covariance holds what exposures of the same pixels have in common: their fixed pattern is one draw.

    Raises
    ------
    ValueError
        With too few observations.

    """
    has_bursts = bool(observations.temporal.any())
    group = np.zeros(observations.signal_dn.size, np.int64) if groups is None else groups
    design = _design(observations, group, has_bursts=has_bursts)

    def fitted(seen: Observations) -> ChartFit:
        return fit_checked(
            ChartFit,
            design,
            seen.variance_dn2,
            seen.dof,
            low_signal=seen.low_signal,
            reject_outliers=reject_outliers,
        )

    fit = fitted(observations)
    if observations.line_spread_dn4 is not None:
        frame_dn2 = _single_frames(observations, group, fit, has_bursts=has_bursts)
        wider = 1.0 + observations.line_spread_dn4 / frame_dn2**2
        observations = replace(observations, dof=observations.dof / wider)
        fit = fitted(observations)
    common = _common_pattern(observations, group, design, fit, has_bursts=has_bursts)
    if observations.line_covariance_dn4 is not None:
        influence = _influence(observations, design, fit)
        common += influence @ observations.line_covariance_dn4 @ influence.T
    return replace(fit, has_bursts=has_bursts, covariance=fit.covariance + common)


def _single_frames(
    observations: Observations, group: NDArray[np.int64], fit: CheckedFit, *, has_bursts: bool
) -> NDArray[np.float64]:
    """Return the fitted variance of a single frame of each patch, which tells how much of it lines share [DN^2].

    By the variance that was found degrees of freedom would be more where it came out high, and the fit would follow
    these.
    """
    signal, coefficients = observations.signal_dn, fit.coefficients
    frame = coefficients[0] + coefficients[1] * signal + coefficients[2 + group] * signal**2
    frame += coefficients[-1] if has_bursts else 0.0
    return np.maximum(frame, _LEAST_FRAME * float(np.median(observations.variance_dn2)))


def _influence(observations: Observations, design: NDArray[np.float64], fit: CheckedFit) -> NDArray[np.float64]:
    """Return the derivatives of the coefficients by the variances, shape (coefficients, N)."""
    predicted = np.maximum(design @ fit.coefficients, np.finfo(np.float64).tiny)
    freedom = np.where(observations.dof > 0.0, observations.dof, 1.0)
    weighted = design * np.where(fit.used, 1.0 / (2.0 * predicted**2 / freedom), 0.0)[:, None]
    scale = 1.0 / np.sqrt(np.diagonal(weighted.T @ design))
    inverse = np.linalg.inv((weighted.T @ design) * np.outer(scale, scale)) * np.outer(scale, scale)
    return inverse @ weighted.T


def fit_shared_noise(observations: Observations, *, channels: int) -> SharedModel:
    """Fit all channels together and test whether they share the model (METHOD 1.10).

    Parameters
    ----------
    observations
        Of at least two channels, each sufficient for a fit of its own.
    channels
        How many; they are numbered from 0.

    """
    clean = _without_outliers(observations, channels=channels)
    apart = [fit_chart_noise(clean.of_channel(number), reject_outliers=False) for number in range(channels)]
    together = fit_chart_noise(clean, reject_outliers=False)
    physical = fit_chart_noise(clean, groups=clean.channel, reject_outliers=False)
    return SharedModel(
        fit=together,
        p_value=_ratio_test(together, apart),
        physical=physical,
        physical_p_value=_ratio_test(physical, apart),
    )


def _design(observations: Observations, group: NDArray[np.int64], *, has_bursts: bool) -> NDArray[np.float64]:
    """Return the columns A, B, C of each group (, E), shape (N, 3 or more)."""
    share = np.where(observations.temporal, 1.0, 1.0 / observations.frames)
    spatial = np.where(observations.temporal, 0.0, 1.0)
    groups = int(group.max(initial=0)) + 1
    fixed = spatial * observations.signal_dn**2
    columns = [share, share * observations.signal_dn]
    columns += [np.where(group == number, fixed, 0.0) for number in range(groups)]
    if has_bursts:
        columns.append(spatial)
    return np.stack(columns, axis=-1)


def _common_pattern(
    observations: Observations,
    group: NDArray[np.int64],
    design: NDArray[np.float64],
    fit: CheckedFit,
    *,
    has_bursts: bool,
) -> NDArray[np.float64]:
    """Return what the one fixed pattern behind several exposures adds to the covariance of the coefficients.

    Two spatial variances of the same pixels, with patterns of variance C S^2 + E, have the covariance
    2 (C S S' + E)^2 / nu.
    """
    spatial = ~observations.temporal & fit.used
    identity = observations.patch + (observations.patch.max(initial=0) + 1) * observations.channel
    order = np.flatnonzero(spatial)
    _, first, counts = np.unique(identity[order], return_index=True, return_counts=True)
    if first.size == order.size:
        return np.zeros_like(fit.covariance)
    influences = _influence(observations, design, fit)
    freedom = np.where(observations.dof > 0.0, observations.dof, 1.0)
    fixed = np.maximum(fit.coefficients[2 + group], 0.0)
    offset = max(float(fit.coefficients[-1]), 0.0) if has_bursts else 0.0
    common = np.zeros_like(fit.covariance)
    for one in np.unique(identity[order])[counts > 1]:
        rows = order[identity[order] == one]
        pattern = fixed[rows[0]] * np.outer(observations.signal_dn[rows], observations.signal_dn[rows]) + offset
        shared = 2.0 * pattern**2 / float(freedom[rows].min())
        np.fill_diagonal(shared, 0.0)
        influence = influences[:, rows]
        common += influence @ shared @ influence.T
    return common


def _ratio_test(together: CheckedFit, apart: Sequence[CheckedFit]) -> float:
    """Return the p-value of one fit for all against one each; by F where those do not fit themselves."""
    ratio = max(together.deviance - sum(fit.deviance for fit in apart), 0.0)
    dof = sum(fit.coefficients.size for fit in apart) - together.coefficients.size
    residual_dof = sum(fit.deviance_dof for fit in apart)
    misfit = any(fit.misfit for fit in apart)
    scale = sum(fit.deviance for fit in apart) / residual_dof if misfit else 1.0
    return float(fdtrc(dof, residual_dof if misfit else 1e9, ratio / dof / scale))


def _without_outliers(observations: Observations, *, channels: int) -> Observations:
    """Return the observations that the fits of their own channels use."""
    used = np.zeros(observations.signal_dn.size, np.bool_)
    for number in range(channels):
        used[observations.channel == number] = fit_chart_noise(observations.of_channel(number)).used
    return observations.where(used)
