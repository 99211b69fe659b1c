"""From points to the noise model: what takes part, with which weights, channel by channel and all together."""

from collections.abc import Sequence
from dataclasses import dataclass

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


def tabulate(shots: Shots, offsets_dn: Sequence[float], *, lines: LineNoise) -> Table:
    """Return the admitted points of all channels as observations, signals counted from ``offsets_dn`` per channel."""
    points: list[PatchPoint] = []
    patches: list[int] = []
    names: dict[tuple[int, str], int] = {}
    seen: list[list[tuple[int, PatchPoint, bool]]] = [[] for _ in shots.scenes]
    for number, (scene, exposure) in enumerate(shots.exposures):
        for point in exposure.points:
            if point.admitted:
                points.append(point)
                patches.append(names.setdefault((scene, point.patch), len(names)))
                seen[scene] += [(number, point, True)] * (point.frames > 1) + [(number, point, False)]
    rows: list[tuple[float, float, float, float, float, bool, int, int, float]] = []
    owners: list[int] = []
    for owner, (point, patch) in enumerate(zip(points, patches, strict=True)):
        channel = shots.channels.index(point.channel)
        signal = point.mean_dn - offsets_dn[channel]
        wider = lines.spread_dn4(point)
        share = 1.0 / (point.n * point.frames)
        if point.frames > 1:
            temporal = point.temporal_variance_dn2 + lines.lost(point, between=True)
            rows.append((signal, temporal, point.temporal_dof, share, point.frames, True, channel, patch, wider))
            owners.append(owner)
        weight = share / point.frames**2
        spatial = point.spatial_variance_dn2 + lines.lost(point)
        rows.append((signal, spatial, point.spatial_dof, weight, point.frames, False, channel, patch, wider))
        owners.append(owner)
    shared = None
    if lines.seen:
        parts = (
            lines.of_variances(one, scene.patches, cfa=shots.cfa)
            for one, scene in zip(seen, shots.scenes, strict=True)
            if one
        )
        shared = np.asarray(block_diag(*parts), np.float64)
    return Table(points=tuple(points), observations=_observations(rows, shared), owners=np.array(owners, np.int64))


def _observations(
    rows: Sequence[tuple[float, float, float, float, float, bool, int, int, float]],
    shared: NDArray[np.float64] | None,
) -> Observations:
    columns = list(zip(*rows, strict=True)) or [()] * 9
    floats = [np.array(column, np.float64) for column in columns[:5]]
    return Observations(
        signal_dn=floats[0],
        variance_dn2=floats[1],
        dof=floats[2],
        low_signal=floats[3],
        frames=floats[4],
        temporal=np.array(columns[5], np.bool_),
        channel=np.array(columns[6], np.int64),
        patch=np.array(columns[7], np.int64),
        line_spread_dn4=None if shared is None else np.array(columns[8], np.float64),
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
