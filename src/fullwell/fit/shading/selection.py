"""All models of a plane's shading, and the one to use (METHOD 6.3)."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np
from numpy.typing import NDArray
from scipy.special import chdtrc

from fullwell.fit.goodness import MISFIT_SIZE
from fullwell.fit.shading.cosine import fit_cosine
from fullwell.fit.shading.data import ShadingData
from fullwell.fit.shading.polynomial import fit_polynomial
from fullwell.fit.shading.radial import fit_radial
from fullwell.fit.shading.robust import MEAN_WEIGHT, MEAN_WEIGHTED_SQUARE, robust_bins
from fullwell.fit.shading.solution import Solution, fit_amplitude
from fullwell.fit.shading.spline import fit_spline, spline_terms
from fullwell.fit.shading.surface import ShadingModel, equation, maximum
from fullwell.fit.shading.weighting import WeightedBins
from fullwell.model.shading import CosineSurface, RadialSurface, Surface, TensorSurface

MODELS: Final = ("cos4-fixed", "cos4", "poly22", "radial", "poly44", "poly66", "poly88", "p-spline")
"""All models, from few terms to many."""
_NOTABLE: Final = 1.1
"""Factor on the errors from which a misfit is worth a flag."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ShadingFits:
    """The models of one plane and the choice among them.

    Parameters
    ----------
    models
        By name, from few effective terms to many.
    chosen
        Name of the model to use (`choose`).
    failures
        By name, a sentence on why a model could not be fitted.
    robust_weight
        Weight that each bin got by its residual, shape (V, H), 0 for an outlier to 1 [1]; None without robust fits.

    """

    models: Mapping[str, ShadingModel]
    chosen: str
    failures: Mapping[str, str]
    robust_weight: NDArray[np.float64] | None

    @property
    def best(self) -> ShadingModel:
        """The chosen model."""
        return self.models[self.chosen]

    def without_errors(self) -> "ShadingFits":
        """Return the same without the covariances of its models."""
        nothing = np.empty((0, 0))
        models = {
            name: replace(model, covariance=nothing, temporal_covariance=nothing) for name, model in self.models.items()
        }
        return replace(self, models=models)


def fit_shading(data: ShadingData, *, models: Sequence[str] = MODELS, robust: bool = False) -> ShadingFits:
    """Return the models of a plane's shading (METHOD 6.2) and the choice among them (METHOD 6.3).

    Parameters
    ----------
    data
        Bins of the plane.
    models
        Which to fit; ``cos4-fixed`` is left out where focal length or pitch is unknown.
    robust
        Give little weight to bins far from the surface, such as dust (Tukey's biweight, METHOD 6.4).

    Raises
    ------
    ValueError
        Where a name is unknown or no model can be fitted; the sentence says why.

    """
    unknown = [name for name in models if name not in MODELS]
    if unknown:
        raise ValueError(f"there is no shading model {unknown[0]!r}; there are {', '.join(MODELS)}")
    bins = WeightedBins.of(data)
    if robust:
        bins = robust_bins(bins)
    found: list[ShadingModel] = []
    failures: dict[str, str] = {}
    for name in models:
        if name == "cos4-fixed" and data.focal_length_pixels is None:
            continue
        try:
            found.append(_fitted(name, bins, data.focal_length_pixels, found))
        except ValueError as error:
            failures[name] = str(error)
    if not found:
        raise ValueError("; ".join(f"{name}: {why}" for name, why in failures.items()) or "no shading model to fit")
    even = _misfit(bins, np.full_like(bins.signal_dn, _level(bins)))[1]
    fitted = _judged(sorted(found, key=lambda model: model.effective_terms), even=even)
    return ShadingFits(
        models={model.name: model for model in fitted},
        chosen=choose(fitted),
        failures=failures,
        robust_weight=bins.robust_weight,
    )


def choose(models: Sequence[ShadingModel]) -> str:
    """Return the name of the model to use: ``radial`` where it describes the lens, else ``p-spline`` (METHOD 6.3).

    Polynomials are fitted for comparison: a global one can be good on the whole and wrong in the corners by many times
    its errors. Where there are too few bins for the spline, all models are candidates.

    Parameters
    ----------
    models
        From few effective terms to many, at least one.

    """
    candidates = [model for model in models if model.name in {"radial", "p-spline"}]
    if not any(model.name == "p-spline" for model in candidates):
        candidates = list(models)
    best = min(candidates, key=lambda model: model.gcv)
    return next(model.name for model in candidates if _near(model, best))


def _near(model: ShadingModel, best: ShadingModel) -> bool:
    """Tell whether a model is within one standard error of the best by cross-validation.

    All models see the same noise, so the standard error is that of the difference: chi-square and two for each term,
    which is what cross-validation comes to, differ by the square root of twice the further terms.
    """
    noise = max(best.chi_square / best.dof, 1.0) if best.dof > 0.0 else 1.0
    further = best.effective_terms - model.effective_terms
    excess = (model.chi_square - best.chi_square) / noise - 2.0 * further
    return excess <= math.sqrt(2.0 * max(further, 0.0))


def _fitted(
    name: str, bins: WeightedBins, focal_length_pixels: float | None, before: Sequence[ShadingModel]
) -> ShadingModel:
    """Fit one model, given those that were fitted before."""
    terms = spline_terms(bins) if name == "p-spline" else None
    focal = focal_length_pixels if name == "cos4-fixed" else None
    surface = equation(name, bins.plane, focal_length_pixels=focal, spline_terms=terms)
    solution = _solved(surface, bins, before)
    fitted = surface.value(bins.rows[:, None], bins.columns[None, :], solution.values)
    count, chi_square = _misfit(bins, fitted)
    row, column, value = maximum(surface, solution.values, bins.plane)
    if not value > 0.0:
        raise ValueError("the surface is nowhere above black")
    gcv = chi_square / count / max(1.0 - solution.terms / count, 1e-3) ** 2
    return ShadingModel(
        name=name,
        plane_shape=(bins.plane.rows, bins.plane.columns),
        parameter_names=surface.parameter_names,
        values=solution.values,
        covariance=solution.covariance,
        temporal_covariance=solution.temporal_covariance,
        effective_terms=solution.terms,
        chi_square=chi_square,
        dof=count - solution.terms,
        gcv=gcv,
        gcv_error=gcv * math.sqrt(2.0 / count),
        error_scale=1.0,
        misfit=False,
        centre=(row, column),
        maximum_dn=value,
        focal_length_pixels=focal,
        spline_terms=terms,
    )


def _solved(surface: Surface, bins: WeightedBins, before: Sequence[ShadingModel]) -> Solution:
    """Fit a surface in the way of its kind."""
    match surface:
        case TensorSurface():
            return fit_spline(bins, surface) if surface.kept.all() else fit_polynomial(bins, surface)
        case CosineSurface():
            return fit_cosine(bins)
        case RadialSurface():
            return fit_radial(bins, cosine=next((model.values for model in before if model.name == "cos4"), None))
        case _:
            return fit_amplitude(bins, surface)


def _misfit(bins: WeightedBins, fitted: NDArray[np.float64]) -> tuple[float, float]:
    """Return the number of bins and chi-square; with robust weights, as normal residuals would give them."""
    squares = float(np.sum(bins.fitting_weight * (bins.signal_dn - fitted) ** 2))
    if bins.robust_weight is None:
        return float(bins.bins), squares
    weights = float(np.sum(bins.robust_weight[bins.weight > 0.0]))
    return weights / MEAN_WEIGHT, squares / MEAN_WEIGHTED_SQUARE


def _level(bins: WeightedBins) -> float:
    """Return the mean of the bins [DN]."""
    return float(np.sum(bins.fitting_weight * bins.signal_dn) / np.sum(bins.fitting_weight))


def _even_p(models: Sequence[ShadingModel], even: float) -> float:
    """Return the chance of so good an improvement on an even plane of chi-square ``even``, by Bonferroni over models.

    Models of few terms see a weak falloff, those of many a strange one.
    """
    nesting = [model for model in models if model.effective_terms >= 2.0]
    chances = [float(chdtrc(model.effective_terms - 1.0, max(even - model.chi_square, 0.0))) for model in nesting]
    return min(len(chances) * min(chances), 1.0) if chances else 0.0


def _judged(models: Sequence[ShadingModel], *, even: float) -> list[ShadingModel]:
    """Scale the errors of models that do not fit, and tell whether they fit better than an even plane.

    The best by cross-validation says how noisy the bins are: beyond the 99 % point of chi-square, all errors are
    scaled. What the richest of the good models explains beyond a smaller one, per further term, says how far off that
    one is.
    """
    best = min(models, key=lambda model: model.gcv)
    richest = [model for model in models if model.gcv <= best.gcv + 3.0 * best.gcv_error][-1]
    noise = _beyond_chance(best.chi_square, best.dof)
    even_p = _even_p([replace(model, chi_square=model.chi_square / noise) for model in models], even / noise)
    out: list[ShadingModel] = []
    for model in models:
        excess, terms = model.chi_square - richest.chi_square, richest.effective_terms - model.effective_terms
        if terms < 1.0:
            excess, terms = model.chi_square, model.dof
        scale = math.sqrt(noise * _beyond_chance(excess / noise, terms))
        out.append(
            replace(
                model,
                covariance=scale**2 * model.covariance,
                temporal_covariance=scale**2 * model.temporal_covariance,
                error_scale=scale,
                misfit=scale > _NOTABLE,
                even_p=even_p,
            )
        )
    return out


def _beyond_chance(chi_square: float, dof: float) -> float:
    """Return chi-square over its degrees of freedom where that is beyond its 99 % point, else 1."""
    return chi_square / dof if dof > 0.0 and chdtrc(dof, max(chi_square, 0.0)) < MISFIT_SIZE else 1.0
