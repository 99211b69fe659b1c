"""Polynomials of row and column by weighted least squares (METHOD 6.2)."""

import numpy as np

from fullwell.fit.shading.solution import Solution
from fullwell.fit.shading.weighting import TensorGrid, WeightedBins, sandwich, symmetric_inverse
from fullwell.model.shading import TensorSurface


def fit_polynomial(bins: WeightedBins, surface: TensorSurface) -> Solution:
    """Return the polynomial, exactly, by normal equations of Legendre polynomials along the axes.

    Raises
    ------
    ValueError
        Where there are not more bins than terms, or they do not determine every term.

    """
    terms = int(np.count_nonzero(surface.kept))
    if bins.bins <= terms:
        raise ValueError(f"{terms} terms need more than the {bins.bins} bins there are")
    grid = TensorGrid.of(surface, bins.rows, bins.columns)
    bread = symmetric_inverse(grid.gram(bins.fitting_weight), cutoff=1e-10)
    total, temporal = bins.scatter_weights()
    return Solution(
        values=bread @ grid.moments(bins.fitting_weight * bins.signal_dn),
        covariance=bread if bins.robust_weight is None else sandwich(bread, grid.gram(total)),
        temporal_covariance=sandwich(bread, grid.gram(temporal)),
        terms=float(terms),
    )
