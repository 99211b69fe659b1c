"""How well the light at a chart's supposed patches agrees with the chart: even inside, and in the right proportions."""

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage, optimize

from fullwell.frames.chart.definition import ChartDefinition
from fullwell.frames.chart.homography import mapped
from fullwell.frames.chart.preview import Preview

_INNER: Final = 0.5
"""Share of a patch's edges that is sampled."""
_STEPS: Final = 5
"""Samples along an edge."""
_STEP: Final = 1.6
"""Steps of a chart that touch each other which its contrast is at most."""
_CONTRASTS: Final = (0.4, 3.0)
"""Exponents between the densities that a grey chart is said to have and those it has."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Agreement:
    """What the picture says about a supposed place.

    Parameters
    ----------
    inside
        Patches that lie in the picture whole, shape (patches,).
    visible
        Patches that stand out from the dark, shape (patches,).
    clipped
        Patches at the white level, shape (patches,).
    proportion
        Share of the variance of the logarithm of light that the chart explains, at most 1; below 0 is worse than
        nothing.
    scatter
        Standard deviation of the logarithm of light inside a patch, but for noise, over the contrast between patches,
        shape (patches,).

    """

    inside: NDArray[np.bool_]
    visible: NDArray[np.bool_]
    clipped: NDArray[np.bool_]
    proportion: float
    scatter: NDArray[np.float64]


def agreement(picture: Preview, definition: ChartDefinition, matrix: NDArray[np.float64]) -> Agreement:
    """Compare a picture with a chart at a place.

    Parameters
    ----------
    picture
        The preview.
    definition
        The chart.
    matrix
        From fractions between the chart's corners to pixels of the preview, shape (3, 3).

    """
    points = _samples(definition, matrix)
    rows, columns = picture.light.shape
    x, y = points[..., 0], points[..., 1]
    with np.errstate(invalid="ignore"):
        within = (x >= 0) & (y >= 0) & (x <= columns - 1) & (y <= rows - 1)
    inside = within.all(axis=1)
    place = np.stack((np.where(within, y, 0.0), np.where(within, x, 0.0)))
    values = np.stack([ndimage.map_coordinates(plane, place, order=1) for plane in picture.image], axis=-1)
    clipped = picture.clipped[tuple(np.round(place).astype(np.intp))].mean(axis=1) > 0.2
    light = np.log(np.maximum(values.mean(axis=2), 0.0) + picture.floor)
    means = values.mean(axis=1)
    usable = inside & ~clipped
    visible = inside & (means.mean(axis=1) > picture.floor)
    noise = picture.noise / np.exp(light.mean(axis=1))
    within_patch = np.sqrt(np.maximum(light.var(axis=1) - noise**2, 0.0))
    return Agreement(
        inside=inside,
        visible=visible,
        clipped=clipped & inside,
        proportion=_proportion(means[usable], definition.colours[usable], picture.floor, grey=not definition.coloured),
        scatter=within_patch / max(_contrast(light.mean(axis=1), inside, definition), 1e-9),
    )


def _contrast(light: NDArray[np.float64], inside: NDArray[np.bool_], definition: ChartDefinition) -> float:
    """Return the contrast of the patches in the logarithm of light: their scatter, or a step or two where they touch.

    Half a step out of place, a patch would hold a border; where steps touch nothing else would tell.
    """
    if not inside.any():
        return 0.0
    between = float(np.std(light[inside]))
    if not definition.touching:
        return between
    known = np.log(definition.colours.mean(axis=1))
    return min(between, _STEP * float(np.median(np.abs(np.diff(known)))))


def _samples(definition: ChartDefinition, matrix: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the points where patches are sampled, shape (patches, samples, 2) [preview pixel]."""
    steps = np.linspace(-0.5, 0.5, _STEPS) * _INNER
    offsets = np.stack(np.meshgrid(steps, steps), axis=-1).reshape(-1, 2)
    return mapped(matrix, definition.centres[:, None, :] + offsets * definition.sizes[:, None, :])


def _proportion(means: NDArray[np.float64], colours: NDArray[np.float64], floor: float, *, grey: bool) -> float:
    """Return the share of the variance of the logarithm of light that the chart explains."""
    if len(means) < 5:
        return 0.0
    fitted = _grey_light(means, colours, floor) if grey else _coloured_light(means, colours, floor)
    seen = np.log(np.maximum(means, floor))
    left = seen - np.log(np.maximum(fitted, floor))
    total = float(np.sum((seen - seen.mean(axis=0)) ** 2))
    return 1.0 - float(np.sum(left**2)) / total if total > 1e-9 else 0.0


def _grey_light(means: NDArray[np.float64], colours: NDArray[np.float64], floor: float) -> NDArray[np.float64]:
    """Return the light of neutral patches: a brightness for every channel and one exponent of the densities."""
    known = np.log(colours.mean(axis=1))
    light = means.mean(axis=1)
    bright = light > 2.0 * floor
    if bright.sum() < 3:
        return np.broadcast_to(means.mean(axis=0), means.shape)
    slope = np.clip(np.polynomial.polynomial.polyfit(known[bright], np.log(light[bright]), 1)[1], *_CONTRASTS)
    offset = np.mean(np.log(np.maximum(means[bright], floor)) - slope * known[bright, None], axis=0)
    return np.exp(offset + slope * known[:, None])


def _coloured_light(means: NDArray[np.float64], colours: NDArray[np.float64], floor: float) -> NDArray[np.float64]:
    """Return the light of coloured patches: for every channel a mixture of red, green and blue, and stray light.

    Weights without a sign would let any six uneven areas look like colours; a camera's filters have none below zero
    that matter, so the mixture is one of non-negative weights.
    """
    design = np.column_stack((colours, np.ones(len(colours))))
    fitted = np.empty_like(means)
    for channel in range(means.shape[1]):
        seen = np.maximum(means[:, channel], floor)
        weights, _ = optimize.nnls(design / seen[:, None], np.ones(len(seen)))
        fitted[:, channel] = design @ weights
    return fitted
