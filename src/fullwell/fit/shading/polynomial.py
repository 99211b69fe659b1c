"""Polynomials of row and column by weighted least squares (METHOD 6.2)."""

from functools import cache
from typing import Final

import numpy as np

from fullwell.fit.shading.solution import Solution
from fullwell.fit.shading.surface import ShadingModel
from fullwell.fit.shading.weighting import (
    FloatArray,
    TensorGrid,
    WeightedBins,
    gram_of_pairs,
    sandwich,
    symmetric_inverse,
)
from fullwell.model.shading import TensorSurface, legendre, polynomial_surface

_POWERS: Final = ((0, 0), (1, 0), (0, 1), (2, 0), (1, 1), (0, 2))
_PLACES: Final = np.array([(0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (0.5, 0.0), (0.0, 0.5), (0.5, 0.5)])
"""Six places that determine a polynomial of degree two, as fractions of the plane."""


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
    degree = surface.kept.shape[0] - 1
    grid = TensorGrid.of(surface, bins.rows, bins.columns)
    bread = symmetric_inverse(polynomial_gram(bins, bins.fitting_weight, degree), cutoff=1e-10)
    total, temporal = bins.scatter_weights()
    return Solution(
        values=bread @ grid.moments(bins.fitting_weight * bins.signal_dn),
        covariance=bread if bins.robust_weight is None else sandwich(bread, polynomial_gram(bins, total, degree)),
        temporal_covariance=sandwich(bread, polynomial_gram(bins, temporal, degree)),
        terms=float(terms),
    )


def polynomial_gram(bins: WeightedBins, weight: FloatArray, degree: int) -> FloatArray:
    """Return the sums over the bins of weighted products of two polynomials of a total degree, shape (P, P).

    A product of two Legendre polynomials is a sum of such up to twice the degree: these are what is summed.

    Parameters
    ----------
    bins
        Their places.
    weight
        Shape (V, H).
    degree
        The highest.

    """
    rows, columns = (
        legendre(places, size, 2 * degree)
        for places, size in ((bins.rows, bins.plane.rows), (bins.columns, bins.plane.columns))
    )
    share = _products(degree)
    pairs = share @ (rows.T @ weight @ columns) @ share.T
    return gram_of_pairs(pairs, polynomial_surface(bins.plane, degree).kept)


@cache
def _products(degree: int) -> FloatArray:
    """Return what products of two Legendre polynomials hold of each, shape ((degree + 1)^2, 2 degree + 1)."""
    nodes, shares = np.polynomial.legendre.leggauss(2 * degree + 1)
    values = np.polynomial.legendre.legvander(nodes, 2 * degree)
    low, norms = values[:, : degree + 1], np.arange(2 * degree + 1) + 0.5
    return np.einsum("q,qi,qj,qk,k->ijk", shares, low, low, values, norms, optimize=True).reshape(-1, 2 * degree + 1)


def monomial_coefficients(model: ShadingModel) -> tuple[tuple[str, float, float], ...]:
    """Return name, value and standard error of p00, p10, p01, p20, p11, p02 of a polynomial of degree two.

    Parameters
    ----------
    model
        A ``poly22``; x is the row and y the column of its plane, counted from 1 [DN, DN/pixel, DN/pixel^2].

    """
    size = np.asarray(model.plane_shape, dtype=np.float64)
    values, covariance = model.surface_and_covariance(*(_PLACES * size - 1.0).T)
    solve = np.linalg.inv(np.stack([_PLACES[:, 0] ** x * _PLACES[:, 1] ** y for x, y in _POWERS], axis=1))
    solve /= np.array([size[0] ** x * size[1] ** y for x, y in _POWERS])[:, np.newaxis]
    errors = np.sqrt(np.maximum(np.diag(solve @ covariance @ solve.T), 0.0))
    names = (f"p{x}{y}" for x, y in _POWERS)
    return tuple(zip(names, (solve @ values).tolist(), errors.tolist(), strict=True))
