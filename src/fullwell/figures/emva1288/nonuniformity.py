"""Spatial variances of an averaged stack and their split into rows, columns and pixels (EMVA1288 7).

Signed throughout: a variance below zero is a result. `split_literal` is the standard's; `split_corrected` divides out
what its high-pass filter takes from white noise (EMVA1288 6).
"""

from dataclasses import dataclass

import numpy as np

from fullwell.figures.emva1288.sweep import Floats
from fullwell.statistics.high_pass import LINE_SPREAD, LINE_VARIANCE_GAIN, PIXEL_SPREAD, VARIANCE_GAIN


@dataclass(frozen=True, slots=True, kw_only=True)
class StackMoments:
    """What is needed of an averaged stack.

    Parameters
    ----------
    rows, columns
        M and N of the plane, after the filter where there was one.
    frames
        L.
    temporal
        Mean over pixels of the variance over frames, (65) [DN^2].
    measured
        Variance over pixels of the average, (35) [DN^2].
    column_means, row_means
        Variance over the means of columns, and of rows, temporal noise left in [DN^2].
    filtered
        Whether the average was high-passed: neighbours are no longer independent then.

    """

    rows: int
    columns: int
    frames: int
    temporal: float
    measured: float
    column_means: float
    row_means: float
    filtered: bool = False


@dataclass(frozen=True, slots=True, kw_only=True)
class Split:
    """Signed spatial variances with standard errors [DN^2]."""

    total: float
    row: float
    column: float
    pixel: float
    column_means: float
    row_means: float
    total_error: float
    row_error: float
    column_error: float
    pixel_error: float


def stack_moments(average: Floats, *, frames: int, temporal: float, filtered: bool = False) -> StackMoments:
    """Return the moments of an average of ``frames`` frames, shape (M, N) [DN].

    Examples
    --------
    >>> average = np.array([[4.0, 6, 5], [8, 9, 10], [3, 5, 7], [9, 8, 10]])
    >>> split = split_literal(stack_moments(average, frames=10, temporal=0.5))
    >>> round(split.column * 30, 9), round(split.row * 5, 9), round(split.pixel * 20, 9)
    (11.0, 18.0, 23.0)

    """
    rows, columns = average.shape
    mean = float(average.mean())
    return StackMoments(
        rows=rows,
        columns=columns,
        frames=frames,
        temporal=temporal,
        measured=float(np.einsum("ij,ij->", average, average) / average.size - mean**2),
        column_means=float(average.mean(axis=0).var()),
        row_means=float(average.mean(axis=1).var()),
        filtered=filtered,
    )


def split_literal(moments: StackMoments) -> Split:
    """Return the split of (36), (38), (41), (44)."""
    return _split(moments, pixel_gain=1.0, line_gain=1.0)


def split_corrected(moments: StackMoments) -> Split:
    """Return the split with the gains of the high-pass filter divided out."""
    return _split(moments, pixel_gain=VARIANCE_GAIN, line_gain=LINE_VARIANCE_GAIN)


def _split(moments: StackMoments, *, pixel_gain: float, line_gain: float) -> Split:
    rows, columns = moments.rows, moments.columns
    left = moments.temporal / moments.frames
    total = moments.measured - pixel_gain * left
    column_means = moments.column_means - line_gain * left / rows
    row_means = moments.row_means - line_gain * left / columns
    pixel = (total - column_means - row_means) / (pixel_gain - line_gain / rows - line_gain / columns)
    column = column_means / line_gain - pixel / rows
    row = row_means / line_gain - pixel / columns
    inflated = (PIXEL_SPREAD, LINE_SPREAD) if moments.filtered else (1.0, 1.0)
    unexplained = max(moments.measured - moments.column_means - moments.row_means, 0.0)
    spread = _spread(unexplained, rows * columns) * inflated[0]
    temporal_error = left * np.sqrt(2.0 / (rows * columns * max(moments.frames - 1, 1)))
    pixel_error = float(np.hypot(spread, temporal_error)) / pixel_gain
    of_lines = inflated[1] / line_gain
    column_error = float(np.hypot(_spread(moments.column_means, columns) * of_lines, pixel_error / rows))
    row_error = float(np.hypot(_spread(moments.row_means, rows) * of_lines, pixel_error / columns))
    return Split(
        total=pixel + column + row,
        row=row,
        column=column,
        pixel=pixel,
        column_means=column_means,
        row_means=row_means,
        total_error=float(np.sqrt(pixel_error**2 + column_error**2 + row_error**2)),
        row_error=row_error,
        column_error=column_error,
        pixel_error=pixel_error,
    )


def _spread(variance: float, count: int) -> float:
    """Return the standard error of a variance over ``count`` normal values."""
    return variance * float(np.sqrt(2.0 / max(count - 1, 1)))
