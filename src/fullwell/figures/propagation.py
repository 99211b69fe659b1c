"""Errors of figures that are computed from others, by the delta method with derivatives taken numerically."""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from fullwell.units import Measured, combined_dof

_STEP: Final = 1e-3
"""Step of the difference quotient in standard errors: curvature enters with its square."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Ingredient:
    """A number that others are computed from.

    Parameters
    ----------
    measured
        Its value; without a standard error it is exact.
    fit
        What it was fitted with: ingredients of one fit have errors of unknown correlation, so theirs are added as
        they are, which is never too little. Those of different fits, and of None, are independent.

    """

    measured: Measured
    fit: str | None = None


def propagated(
    function: Callable[[NDArray[np.float64]], float], ingredients: Sequence[Ingredient], *, unit: str
) -> Measured:
    """Return a figure with the error that its ingredients leave it.

    Parameters
    ----------
    function
        From the values of the ingredients, shape (N,), to the figure.
    ingredients
        What it is computed from.
    unit
        Unit of the figure.

    Returns
    -------
    Measured
        With the interval of Student's t; without an error where no ingredient that matters has one.

    """
    at = np.array([one.measured.value for one in ingredients], dtype=np.float64)
    value = function(at)
    parts = _parts(function, at, ingredients)
    error = math.sqrt(sum(part**2 for part, _ in parts))
    if error == 0.0 or not math.isfinite(error):
        return Measured.exact(value, unit)
    return Measured.student(value, error, combined_dof(*parts), unit)


def _parts(
    function: Callable[[NDArray[np.float64]], float], at: NDArray[np.float64], ingredients: Sequence[Ingredient]
) -> list[tuple[float, float | None]]:
    """Return error and degrees of freedom that every fit contributes."""
    parts: dict[str, list[tuple[float, float | None]]] = {}
    for index, one in enumerate(ingredients):
        if one.measured.std_error:
            step = np.zeros_like(at)
            step[index] = max(_STEP * one.measured.std_error, 1e-7 * abs(float(at[index])))
            slope = (function(at + step) - function(at - step)) / (2.0 * float(step[index]))
            key = str(index) if one.fit is None else f"fit {one.fit}"
            parts.setdefault(key, []).append((abs(slope) * one.measured.std_error, one.measured.dof))
    return [
        (sum(error for error, _ in own), min((dof for error, dof in own if error and dof is not None), default=None))
        for own in parts.values()
    ]
