"""Bins with the weights they are fitted by (METHOD 6.1), and the normal equations of a surface over them."""

from dataclasses import dataclass
from typing import Final, Self

import numpy as np
from numpy.typing import NDArray

from fullwell.fit.shading.data import ShadingData, local_mean
from fullwell.model.shading import Plane, TensorSurface

FloatArray = NDArray[np.float64]

EXCESS: Final = 1.0371776671
"""By what robust weights w that are taken as given understate the variance of a fit: they say E w^2 / (E w)^2 where w r
scatters by E (w r)^2 / (E (w r)')^2, of normal residuals r."""
TEMPORAL_EXCESS: Final = 1.1426675223
"""The same where a small part of r changes: by E (w r)'^2 / (E (w r)')^2."""
UNDETERMINED: Final = "the bins do not determine every term of the model"


@dataclass(frozen=True, slots=True, kw_only=True)
class WeightedBins:
    """Bins on a grid of V rows and H columns, ready for least squares.

    Parameters
    ----------
    plane
        Size of the plane.
    rows, columns
        Centres of the bins, shapes (V,) and (H,) [pixel].
    signal_dn
        Shape (V, H) [DN]; 0 where the bin is left out.
    weight
        Inverse variance by temporal noise and PRNU, of the same shape [1/DN^2]; 0 where the bin is left out.
    temporal_variance_dn2
        Of the bin mean [DN^2]; 0 where the bin is left out.
    robust_weight
        A further weight from 0 to 1 by the residual [1]; None: all 1.

    """

    plane: Plane
    rows: FloatArray
    columns: FloatArray
    signal_dn: FloatArray
    weight: FloatArray
    temporal_variance_dn2: FloatArray
    robust_weight: FloatArray | None = None

    @classmethod
    def of(cls, data: ShadingData) -> Self:
        """Return the bins with their weights; PRNU counts at the local mean, so that noise does not weight itself.

        Raises
        ------
        ValueError
            Where no bin is left, none shows light, or a variance is not a number above zero.

        """
        used = data.used
        if not used.any():
            raise ValueError("no bin is left to fit shading to: all are saturated or without sound pixels")
        fixed = data.fixed_variance * local_mean(data.signal_dn) ** 2
        variance = np.where(used, data.temporal_variance_dn2 + fixed, 1.0)
        if not (np.isfinite(variance) & (variance > 0.0)).all():
            raise ValueError("every bin needs a variance above zero; give the temporal noise of the burst")
        weight = np.where(used, 1.0 / variance, 0.0)
        signal = np.where(used, data.signal_dn, 0.0)
        if float(np.sum(weight * signal)) <= 0.0:
            raise ValueError("the plane shows no light above black; shading needs a flat field")
        return cls(
            plane=Plane(rows=data.plane_shape[0], columns=data.plane_shape[1]),
            rows=data.rows,
            columns=data.columns,
            signal_dn=signal,
            weight=weight,
            temporal_variance_dn2=np.where(used, data.temporal_variance_dn2, 0.0),
        )

    @property
    def bins(self) -> int:
        """Bins that are used."""
        return int(np.count_nonzero(self.weight))

    @property
    def fitting_weight(self) -> FloatArray:
        """Inverse variance times robust weight, shape (V, H) [1/DN^2]."""
        return self.weight if self.robust_weight is None else self.weight * self.robust_weight

    def scatter_weights(self) -> tuple[FloatArray, FloatArray]:
        """Return fitting weight squared times the variance of the bins: in all, and by temporal noise alone."""
        fitting = self.fitting_weight
        temporal = fitting**2 * self.temporal_variance_dn2
        if self.robust_weight is None:
            return fitting, temporal
        return EXCESS * fitting * self.robust_weight, TEMPORAL_EXCESS * temporal


@dataclass(frozen=True, slots=True, kw_only=True)
class TensorGrid:
    """Basis functions of a tensor surface at the rows and columns of a grid.

    Sums over the grid go along one axis at a time: the array structure of the surface, never one row per bin.

    Parameters
    ----------
    row_basis, column_basis
        Shapes (V, R) and (H, C).
    kept
        Products that take part, shape (R, C).

    """

    row_basis: FloatArray
    column_basis: FloatArray
    kept: NDArray[np.bool_]

    @classmethod
    def of(cls, surface: TensorSurface, rows: FloatArray, columns: FloatArray) -> Self:
        """Return the basis of a surface on a grid."""
        return cls(row_basis=surface.row_basis(rows), column_basis=surface.column_basis(columns), kept=surface.kept)

    def gram(self, weight: FloatArray) -> FloatArray:
        """Return X' W X for weights of shape (V, H), shape (P, P)."""
        return gram_of_pairs(_squared(self.row_basis).T @ weight @ _squared(self.column_basis), self.kept)

    def moments(self, values: FloatArray) -> FloatArray:
        """Return X' z for values of shape (V, H), shape (P,)."""
        return (self.row_basis.T @ values @ self.column_basis)[self.kept]

    def surface(self, parameters: FloatArray) -> FloatArray:
        """Return the surface on the grid, shape (V, H)."""
        coefficients = np.zeros(self.kept.shape)
        coefficients[self.kept] = parameters
        return self.row_basis @ coefficients @ self.column_basis.T


def gram_of_pairs(pairs: FloatArray, kept: NDArray[np.bool_]) -> FloatArray:
    """Return sums of weighted products of surfaces, from those of two functions of the row and two of the column.

    Parameters
    ----------
    pairs
        Shape (R * R, C * C).
    kept
        Which products of a function of the row and one of the column are surfaces, shape (R, C).

    """
    rows, columns = kept.shape
    full = pairs.reshape(rows, rows, columns, columns).transpose(0, 2, 1, 3).reshape(rows * columns, -1)
    chosen = kept.ravel()
    return full if chosen.all() else np.ascontiguousarray(full[np.ix_(chosen, chosen)])


def _squared(basis: FloatArray) -> FloatArray:
    """Return all products of two functions, shape (n, R * R)."""
    return (basis[:, :, None] * basis[:, None, :]).reshape(basis.shape[0], -1)


def symmetric_inverse(matrix: FloatArray, *, cutoff: float = 1e-13, whole: bool = True) -> FloatArray:
    """Return the inverse of a symmetric matrix, its diagonal scaled to 1 meanwhile.

    Parameters
    ----------
    matrix
        Normal equations.
    cutoff
        Directions whose eigenvalue is below this share of the largest are not determined.
    whole
        Refuse these; else drop them.

    Raises
    ------
    ValueError
        Where a parameter is not determined.

    """
    scale = np.sqrt(np.maximum(np.diag(matrix), 0.0))
    if not (np.isfinite(matrix).all() and (scale > 0.0).all()):
        raise ValueError(UNDETERMINED)
    values, vectors = np.linalg.eigh(matrix / np.outer(scale, scale))
    kept = values > cutoff * values[-1]
    if whole and not kept.all():
        raise ValueError(UNDETERMINED)
    inverse = (vectors[:, kept] / values[kept]) @ vectors[:, kept].T
    return inverse / np.outer(scale, scale)


def sandwich(bread: FloatArray, filling: FloatArray) -> FloatArray:
    """Return bread' filling bread, symmetric to the last bit."""
    product = bread @ filling @ bread
    return 0.5 * (product + product.T)
