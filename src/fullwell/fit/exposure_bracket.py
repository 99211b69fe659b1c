"""The black level from several exposures of one still scene, their ratios unknown (METHOD 2.3 (i), 2.5).

Patch i at exposure e has the mean x = b + r_e s_i: light, flare, texture and shading all scale with exposure, the
offset does not. `fit_exposure_bracket` solves one bracket; `solve_bracket` is its engine, for many at once.
"""

import math
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.special import chdtrc, ndtri

from fullwell.fit.goodness import MAX_DROPPED, OUTLIER, is_misfit
from fullwell.units import DN, ONE, Measured

LINEAR_SHARE: Final = 0.1
"""Share of the digital maximum below which a bent response is straight enough (METHOD 2.3)."""
DISTINCT: Final = 4.0
"""Standard errors by which some exposure has to differ from the first."""

_ITERATIONS: Final = 50
_TOLERANCE: Final = 1e-9
"""Largest step at convergence, in standard errors."""
_FEWEST_PATCHES: Final = 3


@dataclass(frozen=True, slots=True, kw_only=True)
class BracketSolution:
    """Solution of `solve_bracket`, leading axes as in the data.

    Parameters
    ----------
    offset
        b, shape (...) [DN].
    ratios
        r_e, shape (..., E), the first one 1.
    signals_dn
        s_i, shape (..., N); 0 where a patch took no part.
    covariance
        Of b and r_1 ... r_(E-1), shape (..., E, E).
    chi_square
        Shape (...).
    residuals
        Over their standard errors, shape (..., E, N); 0 where a mean took no part.
    influence
        By what b moves with each mean, shape (..., E, N); their sum is 1.

    """

    offset: NDArray[np.float64]
    ratios: NDArray[np.float64]
    signals_dn: NDArray[np.float64]
    covariance: NDArray[np.float64]
    chi_square: NDArray[np.float64]
    residuals: NDArray[np.float64]
    influence: NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True)
class ExposureBracket:
    """A bracket of exposures, solved.

    Parameters
    ----------
    offset
        The black level b with its error: that of the means, scaled where ``misfit``, and the drift of the offset [DN].
    ratios
        Exposure of each row of the means over that of the first, the first one exactly 1, length E [1].
    signals_dn
        Profiled signal above black of each patch at the first exposure, shape (N,); NaN where a patch took no part
        [DN].
    chi_square, dof
        Of the residuals, and their degrees of freedom.
    misfit
        Whether chi-square lies beyond its 99 % point even so: errors are scaled and have ``dof`` degrees of freedom.
    restricted
        Whether means above a tenth of the digital maximum were left out because not all fit: a response that bends.
    used
        Means that took part, shape (E, N).
    residuals
        (x - b - r_e s_i) over its standard error, shape (E, N); NaN where a patch took no part.

    """

    offset: Measured
    ratios: tuple[Measured, ...]
    signals_dn: NDArray[np.float64]
    chi_square: float
    dof: int
    misfit: bool
    restricted: bool
    used: NDArray[np.bool_]
    residuals: NDArray[np.float64]


def fit_exposure_bracket(
    means_dn: ArrayLike,
    variances_of_means_dn2: ArrayLike,
    *,
    used: ArrayLike | None = None,
    digital_maximum: float | None = None,
    drift_dn: float = 0.0,
    frames: ArrayLike = 1,
    covariance_dn2: ArrayLike = 0.0,
) -> ExposureBracket:
    """Return the offset that makes exposures of one still scene proportional (METHOD 2.3, 2.5).

    Parameters
    ----------
    means_dn
        Mean of each patch at each exposure, black level included, shape (E, N), any order of exposures [DN].
    variances_of_means_dn2
        Variance of each of them, s^2 / n of all pixel values behind it, shape (E, N) [DN^2].
    used
        Means that may take part, shape (E, N); all finite ones by default. Leave clipped patches out here.
    digital_maximum
        White level less black level D; where the response shows a bend, means with a signal below D / 10 alone are
        used. The brightest mean's signal by default [DN].
    drift_dn
        Standard deviation of the offset of single frames, see `fullwell.fit.offset_drift` [DN].
    frames
        Frames averaged in each exposure, shape (E,) or one for all.
    covariance_dn2
        What means have in common, such as the noise of the rows they share, shape (E, N, E, N); zero for each with
        itself, since its own part is in ``variances_of_means_dn2`` [DN^2].

    Returns
    -------
    ExposureBracket
        Patches whose residuals exceed 4 are dropped, one at a time, at most a tenth of them (hot pixels, dust).

    Raises
    ------
    ValueError
        With fewer than two exposures, with fewer than three patches seen at two exposures or more, or where no exposure
        differs from the first beyond four standard errors: then nothing identifies the offset.

    """
    means = np.asarray(means_dn, np.float64)
    variances = np.asarray(variances_of_means_dn2, np.float64)
    allowed = np.isfinite(means) & np.isfinite(variances) & (variances > 0.0)
    if used is not None:
        allowed &= np.asarray(used, np.bool_)
    attempt = _best_attempt(means, variances, allowed, digital_maximum)
    solution, dof = attempt.solution, attempt.dof
    misfit = is_misfit(float(solution.chi_square), dof)
    covariance = solution.covariance * (float(solution.chi_square) / dof if misfit else 1.0)
    errors = np.sqrt(np.diagonal(covariance))
    if np.all(np.abs(solution.ratios[1:] - 1.0) <= DISTINCT * errors[1:]):
        raise ValueError("the exposures do not differ: give shots of at least two exposures, three stops apart")
    per_frame = drift_dn / np.sqrt(np.broadcast_to(np.asarray(frames, np.float64), solution.ratios.shape))
    drift = float(np.linalg.norm(solution.influence.sum(axis=-1) * per_frame))
    common = np.broadcast_to(np.asarray(covariance_dn2, np.float64), means.shape * 2)
    shared = float(np.einsum("en,enfm,fm->", solution.influence, common, solution.influence))
    law = float(dof) if misfit else None
    error = math.sqrt(max(float(errors[0]) ** 2 + shared, 0.0))
    return ExposureBracket(
        offset=Measured.student(float(solution.offset), math.hypot(error, drift), law, DN),
        ratios=(
            Measured.exact(1.0, ONE),
            *(Measured.student(r, e, law, ONE) for r, e in zip(solution.ratios[1:], errors[1:], strict=True)),
        ),
        signals_dn=np.where(attempt.used.any(axis=0), solution.signals_dn, np.nan),
        chi_square=float(solution.chi_square),
        dof=dof,
        misfit=misfit,
        restricted=attempt.restricted,
        used=attempt.used,
        residuals=np.where(attempt.used, solution.residuals, np.nan),
    )


def solve_bracket(
    means_dn: NDArray[np.float64], variances_of_means_dn2: NDArray[np.float64], *, used: NDArray[np.bool_] | None = None
) -> BracketSolution:
    """Solve x = b + r_e s_i by Gauss and Newton on b and r_e, the s_i profiled out; leading axes are data sets.

    Parameters
    ----------
    means_dn, variances_of_means_dn2
        Shape (..., E, N) [DN, DN^2].
    used
        Means that take part, of the same shape: of each patch at least two, or none; all by default.

    """
    take = np.ones(means_dn.shape, np.bool_) if used is None else used
    weights = np.where(take, 1.0 / np.where(take, variances_of_means_dn2, 1.0), 0.0)
    means = np.where(take, means_dn, 0.0)
    offset, ratios = _start(means, weights)
    for _ in range(_ITERATIONS):
        state = _state(means, weights, offset, ratios)
        step = np.linalg.solve(state.information, state.score[..., None])[..., 0]
        size = np.sqrt(np.abs(np.einsum("...p,...p->...", step, state.score)))
        offset = offset + step[..., 0]
        ratios = np.concatenate([ratios[..., :1], ratios[..., 1:] + step[..., 1:]], axis=-1)
        if np.all(size < _TOLERANCE):
            break
    state = _state(means, weights, offset, ratios)
    covariance = _inverse(state.information)
    return BracketSolution(
        offset=offset,
        ratios=ratios,
        signals_dn=state.signals,
        covariance=covariance,
        chi_square=np.sum(weights * state.residuals**2, axis=(-2, -1)),
        residuals=np.sqrt(weights) * state.residuals,
        influence=np.einsum("...p,...pen->...en", covariance[..., 0, :], state.by_mean),
    )


@dataclass(frozen=True, slots=True, kw_only=True)
class _State:
    """The profiled problem at one guess: signals, residuals, score, information, and d score / d mean."""

    signals: NDArray[np.float64]
    residuals: NDArray[np.float64]
    score: NDArray[np.float64]
    information: NDArray[np.float64]
    by_mean: NDArray[np.float64]


def _state(
    means: NDArray[np.float64], weights: NDArray[np.float64], offset: NDArray[np.float64], ratios: NDArray[np.float64]
) -> _State:
    r = ratios[..., None]
    above = means - offset[..., None, None]
    own = np.sum(weights * r**2, axis=-2)
    safe = np.where(own > 0.0, own, 1.0)
    signals = np.where(own > 0.0, np.sum(weights * r * above, axis=-2) / safe, 0.0)
    s = signals[..., None, :]
    residuals = np.where(weights > 0.0, above - r * s, 0.0)
    exposures = means.shape[-2]
    by_parameter = np.zeros((*means.shape[:-2], exposures, exposures, means.shape[-1]))
    by_parameter[..., 0, :, :] = 1.0
    for one in range(1, exposures):
        by_parameter[..., one, one, :] = signals
    shared = np.einsum("...pen,...en->...pn", by_parameter, weights * r)
    projected = by_parameter - (shared / safe[..., None, :])[..., None, :] * r[..., None, :, :]
    weighted = projected * weights[..., None, :, :]
    return _State(
        signals=signals,
        residuals=residuals,
        score=np.einsum("...pen,...en->...p", weighted, residuals),
        information=np.einsum("...pen,...qen->...pq", weighted, projected),
        by_mean=weighted,
    )


def _start(means: NDArray[np.float64], weights: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return offset and ratios from the lines of each exposure's means against the first's."""
    first, both = means[..., :1, :], weights * (weights[..., :1, :] > 0.0)
    total = both.sum(axis=-1)
    level = (both * first).sum(axis=-1) / total
    mean = (both * means).sum(axis=-1) / total
    about = first - level[..., None]
    ratios = np.sum(both * about * (means - mean[..., None]), axis=-1) / np.sum(both * about**2, axis=-1)
    far = np.argmax(np.abs(np.log(np.maximum(ratios, 1e-6))), axis=-1)[..., None]
    r = np.take_along_axis(ratios, far, -1)[..., 0]
    x, y = (np.take_along_axis(values, far, -1)[..., 0] for values in (level, mean))
    gap = 1.0 - r
    offset = (y - r * x) / np.where(np.abs(gap) > 1e-9, gap, 1e-9)
    return offset, np.concatenate([np.ones_like(ratios[..., :1]), ratios[..., 1:]], axis=-1)


def _inverse(information: NDArray[np.float64]) -> NDArray[np.float64]:
    scale = 1.0 / np.sqrt(np.diagonal(information, axis1=-2, axis2=-1))
    outer = scale[..., :, None] * scale[..., None, :]
    return np.linalg.inv(information * outer) * outer


@dataclass(frozen=True, slots=True, kw_only=True)
class _Attempt:
    solution: BracketSolution
    used: NDArray[np.bool_]
    restricted: bool

    @property
    def dof(self) -> int:
        return int(self.used.sum()) - int(self.used.any(axis=0).sum()) - self.used.shape[0]

    @property
    def fits(self) -> bool:
        return not is_misfit(float(self.solution.chi_square), self.dof)


def _best_attempt(
    means: NDArray[np.float64],
    variances: NDArray[np.float64],
    allowed: NDArray[np.bool_],
    digital_maximum: float | None,
) -> _Attempt:
    """Return the first attempt that fits: all patches, without the bright end, without outliers, without both.

    A bend comes before outliers: dropping its worst patches would hide it and keep half of its bias.
    """
    attempt = _attempt(means, variances, allowed, restricted=False)
    if attempt.fits:
        return attempt
    low = _restricted(means, variances, attempt, digital_maximum)
    if low is not None and low.fits:
        return low
    cleaned = _without_outliers(means, variances, attempt)
    if low is None or cleaned.fits:
        return cleaned
    return _without_outliers(means, variances, low)


def _restricted(
    means: NDArray[np.float64], variances: NDArray[np.float64], attempt: _Attempt, digital_maximum: float | None
) -> _Attempt | None:
    signal = means - float(attempt.solution.offset)
    maximum = float(signal[attempt.used].max()) if digital_maximum is None else digital_maximum
    try:
        return _attempt(means, variances, attempt.used & (signal < LINEAR_SHARE * maximum), restricted=True)
    except ValueError:
        return None


def _attempt(
    means: NDArray[np.float64], variances: NDArray[np.float64], allowed: NDArray[np.bool_], *, restricted: bool
) -> _Attempt:
    used = allowed & (allowed.sum(axis=0) >= 2)
    exposures = used.shape[0]
    if exposures < 2 or used.any(axis=0).sum() < _FEWEST_PATCHES or np.any((used & used[:1]).sum(axis=1) < 2):
        raise ValueError(
            "an exposure bracket needs two exposures or more, each with patches that the first one shows unclipped too"
        )
    return _Attempt(solution=solve_bracket(means, variances, used=used), used=used, restricted=restricted)


def _without_outliers(means: NDArray[np.float64], variances: NDArray[np.float64], attempt: _Attempt) -> _Attempt:
    """Drop one patch at a time while the worst one's |r| exceeds 4 times the residuals' robust scale (METHOD 1.8)."""
    patches = int(attempt.used.any(axis=0).sum())
    for _ in range(min(int(MAX_DROPPED * patches), patches - _FEWEST_PATCHES)):
        size = _patch_residuals(attempt)
        worst = int(np.argmax(size))
        scale = max(1.0, 1.4826 * float(np.median(size[attempt.used.any(axis=0)])))
        if size[worst] <= OUTLIER * scale:
            break
        kept = attempt.used.copy()
        kept[:, worst] = False
        try:
            attempt = _attempt(means, variances, kept, restricted=attempt.restricted)
        except ValueError:
            break
    return attempt


def _patch_residuals(attempt: _Attempt) -> NDArray[np.float64]:
    """Return each patch's chi-square as the |r| of a normal residual of the same probability."""
    dof = np.maximum(attempt.used.sum(axis=0) - 1, 1)
    chi_square = np.sum(attempt.solution.residuals**2, axis=0)
    size = -ndtri(np.maximum(chdtrc(dof, chi_square), np.finfo(np.float64).tiny) / 2.0)
    return np.where(attempt.used.any(axis=0), size, 0.0)
