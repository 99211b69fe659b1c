"""A tensor of cubic splines, its roughness penalized as cross-validation asks (METHOD 6.2)."""

from typing import Final

import numpy as np
from scipy.linalg import LinAlgError, eigh

from fullwell.fit.shading.solution import Solution
from fullwell.fit.shading.weighting import FloatArray, TensorGrid, WeightedBins, sandwich
from fullwell.model.shading import TensorSurface

TERMS: Final = (12, 16)
"""Splines along rows and columns."""

_ORDER: Final = 3
"""Differences penalized: third ones, so that a quadratic surface is not."""

_SMALLEST: Final = 1e-8
"""Least penalty, relative to the bins' own information: it decides only where there are no bins."""

_UNDERSMOOTHED: Final = 0.1
"""Share of the penalty that cross-validation asks for. There the bias at the borders is up to two standard errors;
at a tenth it is a fifth of one, for errors larger by a third."""


def spline_terms(bins: WeightedBins) -> tuple[int, int]:
    """Return how many splines suit a grid of bins: 12 x 16, on small grids half as many as bins.

    Raises
    ------
    ValueError
        Where the grid is smaller than 8 x 8, or there are not more bins than splines.

    """
    rows, columns = bins.signal_dn.shape
    if min(rows, columns) < 8:
        raise ValueError(f"a spline surface needs 8 x 8 bins or more; there are {rows} x {columns}")
    terms = (min(TERMS[0], rows // 2), min(TERMS[1], columns // 2))
    if bins.bins <= terms[0] * terms[1]:
        raise ValueError(f"{terms[0]} x {terms[1]} splines need more than the {bins.bins} bins there are")
    return terms


def fit_spline(bins: WeightedBins, surface: TensorSurface) -> Solution:
    """Return the penalized spline surface; the penalty by generalized cross-validation, then a tenth of it.

    Parameters
    ----------
    bins
        Of the plane.
    surface
        A tensor of splines with no more terms than bins.

    Returns
    -------
    Solution
        Its covariance is that of its scatter about its own expectation.

    Raises
    ------
    ValueError
        Where the bins do not determine even a quadratic surface.

    """
    grid = TensorGrid.of(surface, bins.rows, bins.columns)
    weight = bins.fitting_weight
    gram, moments = grid.gram(weight), grid.moments(weight * bins.signal_dn)
    roughness = _roughness(surface.kept.shape)
    least = _SMALLEST * float(np.trace(gram) / np.trace(roughness))
    try:
        spread, vectors = eigh(roughness, gram + least * roughness)
    except LinAlgError as error:
        raise ValueError("the bins do not determine a spline surface") from error
    spread = np.clip(spread, 0.0, 1.0 / least)
    squares = float(np.sum(weight * bins.signal_dn**2))
    own = vectors.T @ moments
    penalty = _UNDERSMOOTHED * _cross_validated(spread, own, squares, least=least, bins=_count(bins))
    shrunk = 1.0 / (1.0 + (penalty - least) * spread)
    bread = (vectors * shrunk) @ vectors.T
    total, temporal = bins.scatter_weights()
    return Solution(
        values=vectors @ (shrunk * own),
        covariance=sandwich(bread, gram if bins.robust_weight is None else grid.gram(total)),
        temporal_covariance=sandwich(bread, grid.gram(temporal)),
        terms=float(np.sum((1.0 - least * spread) * shrunk)),
    )


def _roughness(terms: tuple[int, ...]) -> FloatArray:
    """Return the sum of squared third differences along rows and along columns as a matrix."""
    rows, columns = (np.diff(np.eye(count), _ORDER, axis=0) for count in terms)
    return np.kron(rows.T @ rows, np.eye(terms[1])) + np.kron(np.eye(terms[0]), columns.T @ columns)


def _cross_validated(spread: FloatArray, own: FloatArray, squares: float, *, least: float, bins: float) -> float:
    """Return the penalty that generalized cross-validation asks for, among steps of a quarter decade.

    In the basis where information plus least penalty is 1 and roughness is ``spread``, a fit shrinks each moment by
    1/(1 + (penalty - least) spread), and all penalties cost one sum each.
    """
    penalties = least * 10.0 ** np.arange(1.0, 16.0, 0.25)
    shrunk = 1.0 / (1.0 + (penalties[:, None] - least) * spread)
    information = 1.0 - least * spread
    terms = shrunk @ information
    residual = squares + ((information * shrunk - 2.0) * shrunk) @ own**2
    score = residual / np.maximum(1.0 - terms / bins, 1e-3) ** 2
    return float(penalties[int(np.argmin(score))])


def _count(bins: WeightedBins) -> float:
    return float(bins.bins) if bins.robust_weight is None else float(np.sum(bins.robust_weight[bins.weight > 0.0]))
