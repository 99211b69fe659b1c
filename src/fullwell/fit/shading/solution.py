"""What a fit of one surface finds, before the models are compared."""

from dataclasses import dataclass

import numpy as np

from fullwell.fit.shading.projection import Normal
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


def from_normal(found: Normal, *, total: FloatArray | None, temporal: FloatArray) -> Solution:
    """Return a least-squares solution with the covariance that its derivatives J give.

    Parameters
    ----------
    found
        At the minimum.
    total
        J W J' with the weights of the scatter of robustly weighted bins; None: as the fit's own.
    temporal
        The same with those of temporal noise alone.

    """
    bread = symmetric_inverse(found.information, whole=False)
    return Solution(
        values=found.parameters,
        covariance=bread if total is None else sandwich(bread, total),
        temporal_covariance=sandwich(bread, temporal),
        terms=float(found.parameters.size),
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
    shape = surface.value(bins.rows[:, None], bins.columns[None, :], np.ones(1))

    def sum_of(weight: FloatArray) -> FloatArray:
        return np.array([[np.sum(weight * shape**2)]])

    information = sum_of(bins.fitting_weight)
    moment = np.sum(bins.fitting_weight * shape * bins.signal_dn)
    found = Normal(parameters=moment / information[0], information=information, gradient=np.zeros(1), chi_square=np.nan)
    total, temporal = (sum_of(weight) for weight in bins.scatter_weights())
    return from_normal(found, total=None if bins.robust_weight is None else total, temporal=temporal)
