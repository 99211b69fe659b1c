"""From points to the noise model: what takes part, with which weights, channel by channel and all together."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fullwell.fit.chart_noise import ChartFit, Observations, SharedModel, fit_chart_noise, fit_shared_noise
from fullwell.statistics.chart import PatchPoint
from fullwell.workflow.measure.chart.shots import Shots

SIGNIFICANT = 3.0
"""Standard errors at which rows or columns are said to have noise in common."""


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
class LineNoise:
    """What rows and columns have in common in a single frame, pooled over patches, signed [DN^2]."""

    row_dn2: float
    column_dn2: float
    row_significant: bool
    column_significant: bool

    def inflation(self, point: PatchPoint) -> float:
        """Return how much wider a variance scatters for it (METHOD 1.8)."""
        wider = 1.0
        if self.row_significant:
            wider += (point.columns - 1) * (self.row_dn2 / point.variance_dn2) ** 2
        if self.column_significant:
            wider += (point.rows - 1) * (self.column_dn2 / point.variance_dn2) ** 2
        return wider


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


def line_noise(points: Sequence[PatchPoint]) -> LineNoise:
    """Return row and column noise from all patches, weighted by what each can tell."""
    usable = [point for point in points if point.admitted and min(point.rows, point.columns) > 8]
    if not usable:
        return LineNoise(row_dn2=0.0, column_dn2=0.0, row_significant=False, column_significant=False)
    variance = np.array([point.variance_dn2 for point in usable])
    rows, columns = (np.array([getattr(point, name) for point in usable], np.float64) for name in ("rows", "columns"))
    row, row_error = _weighted([point.row_variance_dn2 for point in usable], variance / columns, rows)
    column, column_error = _weighted([point.column_variance_dn2 for point in usable], variance / rows, columns)
    return LineNoise(
        row_dn2=row,
        column_dn2=column,
        row_significant=row > SIGNIFICANT * row_error,
        column_significant=column > SIGNIFICANT * column_error,
    )


def _weighted(values: Sequence[float], left: NDArray[np.float64], lines: NDArray[np.float64]) -> tuple[float, float]:
    """Return the mean of signed line variances; each errs by what pixels leave in the mean of a line."""
    weight = (lines - 3.0) / (2.0 * left**2)
    return float(weight @ np.asarray(values) / weight.sum()), float(weight.sum() ** -0.5)


def tabulate(shots: Shots, offsets_dn: Sequence[float], *, lines: LineNoise) -> Table:
    """Return the admitted points of all channels as observations, signals counted from ``offsets_dn`` per channel."""
    points: list[PatchPoint] = []
    patches: list[int] = []
    names: dict[tuple[int, str], int] = {}
    for scene, exposure in shots.exposures:
        for point in exposure.points:
            if point.admitted:
                points.append(point)
                patches.append(names.setdefault((scene, point.patch), len(names)))
    rows: list[tuple[float, float, float, float, float, bool, int, int]] = []
    owners: list[int] = []
    for owner, (point, patch) in enumerate(zip(points, patches, strict=True)):
        channel = shots.channels.index(point.channel)
        signal = point.mean_dn - offsets_dn[channel]
        wider = lines.inflation(point)
        share = 1.0 / (point.n * point.frames)
        if point.frames > 1:
            dof = point.temporal_dof / wider
            rows.append((signal, point.temporal_variance_dn2, dof, share, point.frames, True, channel, patch))
            owners.append(owner)
        weight = share / point.frames**2
        rows.append(
            (signal, point.spatial_variance_dn2, point.spatial_dof / wider, weight, point.frames, False, channel, patch)
        )
        owners.append(owner)
    return Table(points=tuple(points), observations=_observations(rows), owners=np.array(owners, np.int64))


def _observations(rows: Sequence[tuple[float, float, float, float, float, bool, int, int]]) -> Observations:
    columns = list(zip(*rows, strict=True)) or [()] * 8
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
