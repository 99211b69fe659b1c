"""Noise that rows and columns have in common: what it does to variances and means of patches (METHOD 1.4, 1.8)."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from fullwell.frames.chart.patches import Patch
from fullwell.raw.cfa import cell, channels
from fullwell.statistics.chart import LINE_TERMS, PatchPoint

SIGNIFICANT = 3.0
"""Standard errors at which rows or columns are said to have noise in common."""
_FEWEST_LINES: Final = 8
_LEAST_OWN: Final = 0.1
"""Share of a variance that at least is taken for the pixels' own."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Lines:
    """What the rows, or the columns, of a single frame have in common, not below 0 [DN^2].

    Parameters
    ----------
    whole_dn2
        Noise and fixed pattern.
    moving_dn2
        The part of it that is new in every frame: all of it where no two frames tell.
    seen
        Whether it stands out from its error. Variances are mended only then; errors of means count it in any case,
        since rows too weak to be seen may still be most of what patches beside each other err by.

    """

    whole_dn2: float = 0.0
    moving_dn2: float = 0.0
    seen: bool = False

    @property
    def fixed_dn2(self) -> float:
        """Return the part that stays from frame to frame."""
        return self.whole_dn2 - self.moving_dn2

    @property
    def mended(self) -> "Lines":
        """Return what variances are mended by: nothing where the lines are not seen."""
        return self if self.seen else Lines()


@dataclass(frozen=True, slots=True, kw_only=True)
class LineNoise:
    """Lines in both directions, pooled over patches."""

    row: Lines
    column: Lines

    @property
    def seen(self) -> bool:
        """Tell whether rows or columns are seen to have anything in common."""
        return self.row.seen or self.column.seen

    def spread_dn4(self, point: PatchPoint) -> float:
        """Return k by which the variance s^2 of a patch scatters wider, by 1 + k / s^4 (METHOD 1.8)."""
        row, column = (line.mended.whole_dn2 for line in (self.row, self.column))
        return (point.columns - 1) * row**2 + (point.rows - 1) * column**2

    def of_variances(
        self, variances: Sequence[tuple[int, PatchPoint, bool]], patches: Sequence[Patch], *, cfa: str
    ) -> NDArray[np.float64]:
        """Return the covariance that lines give variances of different planes of patches, which share them.

        Parameters
        ----------
        variances
            Number of the exposure, plane of a patch, and whether it is a variance between frames.
        patches
            Where they are.
        cfa
            Order at the visible top-left pixel.

        Returns
        -------
        ndarray
            Shape (variances, variances), 0 for each with itself [DN^4].

        """
        numbers, points, kinds = zip(*variances, strict=True)
        exposure, temporal = np.array(numbers), np.array(kinds)
        frames = np.array([point.frames for point in points], np.float64)
        same = exposure[:, None] == exposure
        between = temporal[:, None] & temporal & same
        spatial = ~temporal[:, None] & ~temporal
        found = np.zeros(same.shape)
        for line, overlap in zip(
            (self.row.mended, self.column.mended), _overlaps(points, patches, cfa=cfa), strict=True
        ):
            of_mean = (line.fixed_dn2 + np.where(same, line.moving_dn2 / frames, 0.0)) ** 2
            of_frames = line.moving_dn2**2 / np.maximum(frames - 1.0, 1.0)
            found += 2.0 * overlap * (np.where(spatial, of_mean, 0.0) + np.where(between, of_frames, 0.0))
        np.fill_diagonal(found, 0.0)
        return found

    def lost(self, point: PatchPoint, *, between: bool = False) -> float:
        """Return what the surface took of a variance, that ``between`` frames or that of their mean (METHOD 1.4)."""
        row, column = (
            line.moving_dn2 if between else line.fixed_dn2 + line.moving_dn2 / point.frames
            for line in (self.row.mended, self.column.mended)
        )
        rows_left = point.columns * (point.rows - LINE_TERMS) / point.spatial_dof
        columns_left = point.rows * (point.columns - LINE_TERMS) / point.spatial_dof
        return row * (1.0 - rows_left) + column * (1.0 - columns_left)

    def moving(self, points: Sequence[PatchPoint], patches: Sequence[Patch], *, cfa: str) -> NDArray[np.float64]:
        """Return the covariance that lines give means of one single frame, shape (1, points, 1, points) [DN^2]."""
        by_row, by_column = _overlaps(points, patches, cfa=cfa)
        return (self.row.moving_dn2 * by_row + self.column.moving_dn2 * by_column)[None, :, None]

    def of_means(
        self, exposures: Sequence[Sequence[PatchPoint]], patches: Sequence[Patch], *, cfa: str
    ) -> NDArray[np.float64]:
        """Return the covariance that lines give the means of the same patches at several exposures.

        Parameters
        ----------
        exposures
            The same patches and channels in each.
        patches
            Where they are.
        cfa
            Order at the visible top-left pixel.

        Returns
        -------
        ndarray
            Shape (exposures, points, exposures, points) [DN^2].

        """
        by_row, by_column = _overlaps(exposures[0], patches, cfa=cfa)
        fixed = self.row.fixed_dn2 * by_row + self.column.fixed_dn2 * by_column
        moving = self.moving(exposures[0], patches, cfa=cfa)
        averaged = np.diag([1.0 / points[0].frames for points in exposures])
        return averaged[:, None, :, None] * moving + fixed[:, None]


def _overlaps(
    points: Sequence[PatchPoint], patches: Sequence[Patch], *, cfa: str
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the rows, and columns, that two planes of patches share, over the rows of one times those of the other."""
    step, named = cell(cfa), channels(cfa)
    places = {patch.name: patch for patch in patches}
    sites = np.array([divmod(named.index(point.channel), step) for point in points])
    starts = np.array([(places[point.patch].y, places[point.patch].x) for point in points]) // step
    lengths = np.array([(point.rows, point.columns) for point in points])
    shared: list[NDArray[np.float64]] = []
    for site, start, length in zip(sites.T, starts.T, lengths.T, strict=True):
        stop = start + length
        both = np.minimum(stop[:, None], stop) - np.maximum(start[:, None], start)
        shared.append(np.where(site[:, None] == site, np.maximum(both, 0), 0) / (length[:, None] * length))
    return shared[0], shared[1]


def line_noise(points: Sequence[PatchPoint]) -> LineNoise:
    """Return row and column noise from all patches, weighted by what each can tell."""
    usable = [point for point in points if point.admitted and min(point.rows, point.columns) > _FEWEST_LINES]
    if not usable:
        return LineNoise(row=Lines(), column=Lines())
    return LineNoise(row=_lines(usable, "row", "columns", "rows"), column=_lines(usable, "column", "rows", "columns"))


def _lines(points: Sequence[PatchPoint], name: str, length: str, count: str) -> Lines:
    whole, error = _weighted(points, f"{name}_variance_dn2", length, count)
    bursts = [point for point in points if point.frames > 1]
    moving = _weighted(bursts, f"{name}_temporal_dn2", length, count)[0] if bursts else whole
    counted = max(whole, 0.0)
    return Lines(whole_dn2=counted, moving_dn2=min(max(moving, 0.0), counted), seen=whole > SIGNIFICANT * error)


def _weighted(points: Sequence[PatchPoint], name: str, length: str, count: str) -> tuple[float, float]:
    """Return the mean of signed line variances; each errs by what pixels leave in the mean of a line.

    Weights must not know the lines they weigh: they go by what lines do not share.
    """
    value, pixels, lines = (np.array([getattr(one, field) for one in points], float) for field in (name, length, count))
    whole = np.array([point.variance_dn2 for point in points])
    shared = np.array([point.row_variance_dn2 + point.column_variance_dn2 for point in points])
    left = np.maximum(whole - shared, _LEAST_OWN * whole) / pixels
    weight = (lines - LINE_TERMS) / (2.0 * left**2)
    return float(weight @ value / weight.sum()), float(weight.sum() ** -0.5)
