"""From points to the noise model: what takes part, with which weights, channel by channel and all together."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import block_diag

from fullwell.fit.chart_noise import ChartFit, Observations, SharedModel, fit_chart_noise, fit_shared_noise
from fullwell.statistics.chart import PatchPoint
from fullwell.workflow.measure.chart.line_noise import LineNoise
from fullwell.workflow.measure.chart.shots import Shots


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Table:
    """The points that take part in the fits, and the variances that they give.

    Parameters
    ----------
    points
        Admitted points of all channels, scenes and exposures.
    observations
        One or two for each point, at signals above ``offsets_dn``.
    owners
        Number of the point behind each observation, shape (observations,).

    """

    points: tuple[PatchPoint, ...]
    observations: Observations
    owners: NDArray[np.int64]


@dataclass(frozen=True, slots=True, kw_only=True)
class ChartModel:
    """The noise model of one channel, or of all: A + B S + C S^2 of a single frame.

    Parameters
    ----------
    channel
        Its name, or ``all``.
    fit
        What was fitted.
    coefficients, covariance
        A [DN^2], B [DN/e-], C [1] and their covariance, that of the black level not included.
    n
        Pixel values behind it.

    """

    channel: str
    fit: ChartFit
    coefficients: NDArray[np.float64]
    covariance: NDArray[np.float64]
    n: int


class _Variance(NamedTuple):
    """One variance of a patch, as `Observations` have it."""

    signal_dn: float
    variance_dn2: float
    dof: float
    low_signal: float
    frames: int
    temporal: bool
    channel: int
    patch: int
    line_spread_dn4: float


def tabulate(shots: Shots, offsets_dn: Sequence[float], *, lines: LineNoise) -> Table:
    """Return the admitted points of all channels as observations, signals counted from ``offsets_dn`` per channel."""
    points: list[PatchPoint] = []
    owners: list[int] = []
    variances: list[_Variance] = []
    by_scene: list[list[tuple[int, PatchPoint, bool]]] = [[] for _ in shots.scenes]
    patches: dict[tuple[int, str], int] = {}
    for number, (scene, exposure) in enumerate(shots.exposures):
        for point in exposure.points:
            if not point.admitted:
                continue
            channel = shots.channels.index(point.channel)
            patch = patches.setdefault((scene, point.patch), len(patches))
            found = _variances(point, lines, offset_dn=offsets_dn[channel], channel=channel, patch=patch)
            owners += [len(points)] * len(found)
            points.append(point)
            variances += found
            by_scene[scene] += [(number, point, one.temporal) for one in found]
    shared = None
    if lines.seen:
        parts = (
            lines.of_variances(own, scene.patches, cfa=shots.cfa)
            for own, scene in zip(by_scene, shots.scenes, strict=True)
            if own
        )
        shared = np.asarray(block_diag(*parts), np.float64)
    return Table(points=tuple(points), observations=_observations(variances, shared), owners=np.array(owners, np.int64))


def _variances(
    point: PatchPoint, lines: LineNoise, *, offset_dn: float, channel: int, patch: int
) -> tuple[_Variance, ...]:
    """Return the variance between the frames of a burst, and that of their mean; of a single frame the one."""
    share = 1.0 / (point.n * point.frames)
    spatial = _Variance(
        signal_dn=point.mean_dn - offset_dn,
        variance_dn2=point.spatial_variance_dn2 + lines.lost(point),
        dof=point.spatial_dof,
        low_signal=share / point.frames**2,
        frames=point.frames,
        temporal=False,
        channel=channel,
        patch=patch,
        line_spread_dn4=lines.spread_dn4(point),
    )
    if point.frames == 1:
        return (spatial,)
    between = point.temporal_variance_dn2 + lines.lost(point, between=True)
    temporal = spatial._replace(variance_dn2=between, dof=point.temporal_dof, low_signal=share, temporal=True)
    return temporal, spatial


def _observations(variances: Sequence[_Variance], shared: NDArray[np.float64] | None) -> Observations:
    spread = np.array([one.line_spread_dn4 for one in variances], np.float64)
    return Observations(
        signal_dn=np.array([one.signal_dn for one in variances], np.float64),
        variance_dn2=np.array([one.variance_dn2 for one in variances], np.float64),
        dof=np.array([one.dof for one in variances], np.float64),
        low_signal=np.array([one.low_signal for one in variances], np.float64),
        frames=np.array([one.frames for one in variances], np.float64),
        temporal=np.array([one.temporal for one in variances], np.bool_),
        channel=np.array([one.channel for one in variances], np.int64),
        patch=np.array([one.patch for one in variances], np.int64),
        line_spread_dn4=None if shared is None else spread,
        line_covariance_dn4=shared,
    )


def fit_channel(table: Table, shots: Shots, channel: str) -> ChartModel | None:
    """Fit one channel; None where it has too few patches or its patches have one level."""
    own = table.observations.of_channel(shots.channels.index(channel))
    if not own.sufficient:
        return None
    try:
        fit = fit_chart_noise(own)
    except ValueError:
        return None
    coefficients, covariance = fit.single_frame()
    n = sum(point.n * point.frames for point in table.points if point.channel == channel)
    return ChartModel(channel=channel, fit=fit, coefficients=coefficients, covariance=covariance, n=n)


def fit_all(table: Table, shots: Shots) -> tuple[ChartModel, SharedModel] | None:
    """Fit all channels together; None where one of them is not sufficient, or there is but one."""
    numbers = range(len(shots.channels))
    if len(numbers) < 2 or not all(table.observations.of_channel(number).sufficient for number in numbers):
        return None
    try:
        shared = fit_shared_noise(table.observations, channels=len(numbers))
    except ValueError:
        return None
    coefficients, covariance = shared.fit.single_frame()
    n = sum(point.n * point.frames for point in table.points)
    model = ChartModel(channel="all", fit=shared.fit, coefficients=coefficients, covariance=covariance, n=n)
    return model, shared
