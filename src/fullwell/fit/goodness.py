"""Does the model fit? The deviance against chi-square, and points that do not belong (METHOD 1.8)."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Final, TypeVar

import numpy as np
from numpy.typing import NDArray
from scipy.special import chdtri

from fullwell.fit.gamma_likelihood import GammaFit, fit_gamma, signed_deviance
from fullwell.units import Measured

OUTLIER: Final = 4.0
"""Largest |r| of a point that is kept, in units of the residuals' robust scale where that exceeds 1."""
MAX_DROPPED: Final = 0.1
"""Share of the points that may be dropped."""
MISFIT_SIZE: Final = 0.01
"""Chance that a perfect fit is called a misfit."""


@dataclass(frozen=True, slots=True, kw_only=True)
class CheckedFit:
    """A gamma fit after outliers were dropped, its errors scaled where the model does not fit.

    Parameters
    ----------
    coefficients
        Shape (p,).
    covariance
        Of the coefficients, shape (p, p); scaled by deviance / deviance_dof where ``misfit``.
    deviance, deviance_dof
        Of the used points, about chi-square.
    misfit
        Whether the deviance lies beyond its 99 % point.
    residuals
        Signed deviance of every point, dropped ones too, shape (N,).
    used
        Shape (N,).

    """

    coefficients: NDArray[np.float64]
    covariance: NDArray[np.float64]
    deviance: float
    deviance_dof: int
    misfit: bool
    residuals: NDArray[np.float64]
    used: NDArray[np.bool_]

    @property
    def dof(self) -> float | None:
        """Return the degrees of freedom of the errors: None unless they come from the residuals."""
        return float(self.deviance_dof) if self.misfit else None

    def coefficient(self, index: int, unit: str) -> Measured:
        """Return one coefficient with its error."""
        std_error = float(np.sqrt(self.covariance[index, index]))
        return Measured.student(float(self.coefficients[index]), std_error, self.dof, unit)


Fit = TypeVar("Fit", bound=CheckedFit)


def fit_checked(
    kind: type[Fit],
    design: NDArray[np.float64],
    response: NDArray[np.float64],
    dof: NDArray[np.float64],
    *,
    low_signal: NDArray[np.float64] | None,
    reject_outliers: bool,
) -> Fit:
    """Fit one data set; drop the worst point while its |r| exceeds 4, at most 10 % of the points (METHOD 1.8).

    Points without a variance above zero or without degrees of freedom have no gamma law: they take no part, and their
    residual is NaN. The fit that comes back is of the ``kind`` asked for.
    """
    coefficients = design.shape[-1]
    lawful = np.isfinite(response) & (response > 0.0) & (dof > 0.0)
    if np.unique(design[lawful], axis=0).shape[0] < coefficients:
        raise ValueError(f"{coefficients} coefficients need as many different levels with a variance above zero")
    response, dof = np.where(lawful, response, 1.0), np.where(lawful, dof, 1.0)

    def fitted(used: NDArray[np.bool_]) -> tuple[GammaFit, NDArray[np.float64]]:
        fit = fit_gamma(design, response, dof, low_signal=low_signal, used=used)
        residuals = signed_deviance(response, fit.predicted, fit.effective_dof)
        return fit, np.where(lawful, residuals, np.nan)

    used = lawful
    fit, residuals = fitted(used)
    if reject_outliers:
        used, fit, residuals = _without_outliers(fitted, used, keep=coefficients + 1)
    deviance = float(np.sum(residuals[used] ** 2))
    deviance_dof = int(used.sum()) - coefficients
    misfit = is_misfit(deviance, deviance_dof)
    return kind(
        coefficients=fit.coefficients,
        covariance=fit.covariance * (deviance / deviance_dof if misfit else 1.0),
        deviance=deviance,
        deviance_dof=deviance_dof,
        misfit=misfit,
        residuals=residuals,
        used=used,
    )


def is_misfit(deviance: float, dof: int) -> bool:
    """Return whether a deviance lies beyond the 99 % point of chi-square; never with no degrees of freedom."""
    return dof > 0 and deviance > float(chdtri(dof, MISFIT_SIZE))


def _without_outliers(
    fitted: Callable[[NDArray[np.bool_]], tuple[GammaFit, NDArray[np.float64]]], used: NDArray[np.bool_], *, keep: int
) -> tuple[NDArray[np.bool_], GammaFit, NDArray[np.float64]]:
    """Drop one point at a time; in large sets half a percent at a time, which leaves the same points.

    Where the model fits nowhere, every |r| is large and none is an outlier: dropping the largest would only hide the
    misfit and shrink the errors that are scaled by it. Hence the robust scale.
    """
    budget = min(int(MAX_DROPPED * used.size), used.size - keep)
    at_once = max(1, used.size // 200)
    fit, residuals = fitted(used)
    while budget > 0:
        size = np.abs(np.where(used, residuals, 0.0))
        worst = np.argsort(size)[::-1][: min(at_once, budget)]
        worst = worst[size[worst] > OUTLIER * _robust_scale(size[used])]
        if worst.size == 0:
            break
        used = used.copy()
        used[worst] = False
        budget -= worst.size
        fit, residuals = fitted(used)
    return used, fit, residuals


def _robust_scale(sizes: NDArray[np.float64]) -> float:
    return max(1.0, 1.4826 * float(np.median(sizes)))
