"""Which noise comes by frame, by row, by column and by pixel: a three-way random-effects analysis (METHOD 3.5).

The layout is frame t x row v x column h, one value per cell. Seven mean squares give seven variances, exactly unbiased,
and every other variance of the layout as a linear combination: the temporal variance of a pixel, the variance of the
grand mean.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray
from scipy.special import chdtri

from fullwell.statistics.series import MeanSquares
from fullwell.units import DN2, Measured, welch_dof

EFFECTS: Final = ("t", "v", "h", "tv", "th", "vh", "tvh")


@dataclass(frozen=True, slots=True, kw_only=True)
class VarianceComponents:
    """Variance of each effect, signed, with intervals of the modified large-sample method (Graybill-Wang) [DN^2].

    Parameters
    ----------
    t
        Frame: the whole frame moves.
    v, h
        Row and column fixed pattern.
    tv, th
        Temporal row and column noise.
    vh
        Pixel fixed pattern.
    tvh
        Temporal noise of the pixel alone.

    """

    t: Measured
    v: Measured
    h: Measured
    tv: Measured
    th: Measured
    vh: Measured
    tvh: Measured


@dataclass(frozen=True, slots=True, kw_only=True)
class GrandMeanVariance:
    """Variance of the mean over all frames and pixels [DN^2].

    Parameters
    ----------
    total
        As an estimate of the level of any such sensor: fixed pattern counts.
    temporal
        As an estimate of the level of this sensor, its fixed pattern included: the scatter of the frame means,
        T - 1 degrees of freedom.

    """

    total: Measured
    temporal: Measured


def degrees_of_freedom(shape: tuple[int, int, int]) -> Mapping[str, int]:
    """Return the degrees of freedom of each mean square for T frames, M rows, N columns."""
    edges = dict(zip("tvh", (size - 1 for size in shape), strict=True))
    return {effect: math.prod(edges[letter] for letter in effect) for effect in EFFECTS}


def variance_components(mean_squares: MeanSquares, shape: tuple[int, int, int]) -> VarianceComponents:
    """Return the seven components (METHOD 3.5).

    Parameters
    ----------
    mean_squares
        The seven mean squares [DN^2].
    shape
        T frames (at least two), M rows, N columns.

    """
    return VarianceComponents(**{effect: component(effect, mean_squares, shape) for effect in EFFECTS})


def component(effect: str, mean_squares: MeanSquares, shape: tuple[int, int, int]) -> Measured:
    """Return one of the seven components.

    Parameters
    ----------
    effect
        Of `EFFECTS`.
    mean_squares
        The seven mean squares [DN^2].
    shape
        T frames (at least two), M rows, N columns.

    """
    frames, rows, columns = shape
    combinations: dict[str, dict[str, float]] = {
        "t": _over(rows * columns, t=1, tv=-1, th=-1, tvh=1),
        "v": _over(frames * columns, v=1, tv=-1, vh=-1, tvh=1),
        "h": _over(frames * rows, h=1, th=-1, vh=-1, tvh=1),
        "tv": _over(columns, tv=1, tvh=-1),
        "th": _over(rows, th=1, tvh=-1),
        "vh": _over(frames, vh=1, tvh=-1),
        "tvh": _over(1, tvh=1),
    }
    return combined(mean_squares, shape, combinations[effect], modified_interval=True)


def temporal_variance(
    mean_squares: MeanSquares, shape: tuple[int, int, int], *, pixel_scatter_dn4: float | None = None
) -> Measured:
    """Return the temporal variance of a pixel, t + tv + th + tvh: the mean over pixels of the per-pixel variance.

    Parameters
    ----------
    mean_squares
        The seven mean squares [DN^2].
    shape
        T frames (at least two), M rows, N columns.
    pixel_scatter_dn4
        Variance over pixels of the per-pixel variance; the pixel part of the error is then the larger of what
        chi-square and what this scatter says, which covers telegraph noise (METHOD 3.1) [DN^4].

    Returns
    -------
    Measured
        Its standard error includes the noise that whole frames, rows and columns share [DN^2].

    """
    _, rows, columns = shape
    combination = _over(rows * columns, t=1, tv=rows - 1, th=columns - 1, tvh=(rows - 1) * (columns - 1))
    measured = combined(mean_squares, shape, combination)
    if pixel_scatter_dn4 is None or measured.std_error is None:
        return measured
    pixels = rows * columns
    nu = degrees_of_freedom(shape)["tvh"]
    by_chi_square = 2.0 * (combination["tvh"] * mean_squares.tvh) ** 2 / nu
    excess = max(pixel_scatter_dn4 / pixels - by_chi_square, 0.0)
    return Measured.student(measured.value, float(np.sqrt(measured.std_error**2 + excess)), measured.dof, DN2)


def grand_mean_variance(mean_squares: MeanSquares, shape: tuple[int, int, int]) -> GrandMeanVariance:
    """Return the variance of the grand mean, with and without the fixed pattern (METHOD 3.5).

    Parameters
    ----------
    mean_squares
        The seven mean squares [DN^2].
    shape
        T frames (at least two), M rows, N columns.

    """
    values = math.prod(shape)
    return GrandMeanVariance(
        total=combined(mean_squares, shape, _over(values, t=1, v=1, h=1, tv=-1, th=-1, vh=-1, tvh=1)),
        temporal=combined(mean_squares, shape, _over(values, t=1)),
    )


def combined(
    mean_squares: MeanSquares,
    shape: tuple[int, int, int],
    combination: Mapping[str, float],
    *,
    modified_interval: bool = False,
) -> Measured:
    """Return a linear combination of mean squares with its standard error and degrees of freedom.

    The degrees of freedom are those of the standard error: each mean square counts by its share in the squared error
    (Welch-Satterthwaite), not by its share in the value, so a noisy frame term with few degrees is not hidden behind
    a large pixel term with many.

    Parameters
    ----------
    mean_squares
        The seven mean squares [DN^2].
    shape
        T frames, M rows, N columns.
    combination
        Factor of each mean square; those absent are zero.
    modified_interval
        Take the interval of the modified large-sample method (Graybill-Wang) in place of Student's. The standard error
        counts no mean square for less than what it is expected to be at least: one that came out low would make the
        error of a component near zero too small just where the component is too low.

    Returns
    -------
    Measured
        In DN^2; ``dof`` is None above 10^4.

    """
    every = degrees_of_freedom(shape)
    factor = np.array([combination[effect] for effect in combination])
    square = np.array([getattr(mean_squares, effect) for effect in combination])
    dof = np.array([every[effect] for effect in combination], dtype=np.float64)
    part = factor * square
    value = float(part.sum())
    expected = square
    if modified_interval:
        expected = np.maximum(square, [_least(mean_squares, effect) for effect in combination])
    errors = np.abs(factor) * expected * np.sqrt(2.0 / dof)
    std_error = float(np.sqrt(np.sum(errors**2)))
    known = welch_dof(*zip(errors.tolist(), dof.tolist(), strict=True))
    if not modified_interval:
        return Measured.student(value, std_error, known, DN2)
    return Measured(
        value=value, unit=DN2, std_error=std_error, dof=known, ci95=modified_large_sample_interval(part, dof)
    )


def _least(mean_squares: MeanSquares, effect: str) -> float:
    """Return what a mean square is expected to be where its own component is zero, by the others [DN^2]."""
    if len(effect) == 3:
        return 0.0
    if len(effect) == 2:
        return mean_squares.tvh
    pairs = (getattr(mean_squares, pair) for pair in ("tv", "th", "vh") if effect in pair)
    return float(sum(pairs)) - mean_squares.tvh


def _over(divisor: float, **factors: float) -> dict[str, float]:
    return {effect: factor / divisor for effect, factor in factors.items()}


def modified_large_sample_interval(part: NDArray[np.float64], dof: NDArray[np.float64]) -> tuple[float, float]:
    """Return the 95 % interval of a sum of independent mean squares, each times a factor (Graybill-Wang, METHOD 3.5).

    It is est -+ sqrt(sum of squares), each mean square's one-sided reach swapped where it is subtracted.

    Parameters
    ----------
    part
        Mean squares times their factors, shape (parts,).
    dof
        Degrees of freedom of each.

    """
    down = 1.0 - dof / chdtri(dof, 0.025)
    up = dof / chdtri(dof, 0.975) - 1.0
    added = part >= 0.0
    value = float(part.sum())
    below = float(np.sqrt(np.sum((np.where(added, down, up) * part) ** 2)))
    above = float(np.sqrt(np.sum((np.where(added, up, down) * part) ** 2)))
    return value - below, value + above
