"""What a fit of one surface finds, before the models are compared."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fullwell.fit.shading.weighting import FloatArray, WeightedBins, sandwich, symmetric_inverse
from fullwell.model.shading import Surface


@dataclass(frozen=True, slots=True, kw_only=True)
class Solution:
    """Parameters of a surface and their covariance.

    Parameters
    ----------
    values
        Shape (P,).
    covariance, temporal_covariance
        With PRNU and without, shape (P, P).
    terms
        Effective number of parameters.

    """

    values: FloatArray
    covariance: FloatArray
    temporal_covariance: FloatArray
    terms: float


def at_minimum(surface: Surface, values: FloatArray, bins: WeightedBins) -> Solution:
    """Return a least-squares solution with the covariance that its derivatives give.

    Parameters
    ----------
    surface
        Any surface.
    values
        Parameters at the minimum.
    bins
        What they were fitted to.

    """
    used: NDArray[np.bool_] = bins.weight > 0.0
    slopes = surface.jacobian(*places(bins), values)
    total, temporal = (weight[used] for weight in bins.scatter_weights())
    bread = symmetric_inverse((slopes * bins.fitting_weight[used]) @ slopes.T, whole=False)
    covariance = bread if bins.robust_weight is None else sandwich(bread, (slopes * total) @ slopes.T)
    return Solution(
        values=values,
        covariance=covariance,
        temporal_covariance=sandwich(bread, (slopes * temporal) @ slopes.T),
        terms=float(values.size),
    )


def fit_amplitude(bins: WeightedBins, surface: Surface) -> Solution:
    """Return the amplitude of a surface that has no other parameter.

    Raises
    ------
    ValueError
        Where there are not two bins.

    """
    if bins.bins < 2:
        raise ValueError(f"1 term needs more than the {bins.bins} bins there are")
    used = bins.weight > 0.0
    weight = bins.fitting_weight[used]
    shape = surface.jacobian(*places(bins), np.ones(1))[0]
    amplitude = (weight * shape) @ bins.signal_dn[used] / ((weight * shape) @ shape)
    return at_minimum(surface, np.array([amplitude]), bins)


def places(bins: WeightedBins) -> tuple[FloatArray, FloatArray]:
    """Return row and column of the bins that are used, shape (n,) each [pixel]."""
    used = bins.weight > 0.0
    row, column = np.broadcast_arrays(bins.rows[:, None], bins.columns[None, :])
    return row[used], column[used]
