"""How figures of a noise model are defined, and what several of them share."""

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeAlias

from fullwell.figures.noise_model import Conventions, NativeModel

Formula: TypeAlias = Callable[[NativeModel, Conventions], float | None]


@dataclass(frozen=True, slots=True, kw_only=True)
class Definition:
    """How one figure follows from a noise model.

    Parameters
    ----------
    quantity, unit, method, source, snr_threshold
        As in a result row.
    symbol, equation
        What people write for it, and how it follows from A, B = K, C and D.
    formula
        The equation; None where the model has no such figure.
    root
        Whether the formula gives the figure's signed variance.
    rests_on
        ``saturation``: the level where the signal ends; ``split``: DSNU known apart from read noise; ``fixed``: PRNU
        known apart from other fixed pattern; ``rounding``: noise that rounding may hide.
    direct
        Whether a measurement of that quantity in that unit stands for it.

    """

    quantity: str
    unit: str
    symbol: str
    equation: str
    formula: Formula
    method: str = "conversion"
    source: str = "METHOD 8"
    snr_threshold: float | None = None
    root: bool = False
    rests_on: frozenset[str] = frozenset()
    direct: bool = True


def dark_electrons(model: NativeModel, to: Conventions) -> float:
    """Return the dark current's charge in the exposure [e-]."""
    return (model.dark_current or 0.0) * to.exposure_s


def saturation(model: NativeModel, to: Conventions) -> float:
    """Return the signal at saturation, or where the converter ends [DN]."""
    return to.signal_range if model.saturation_dn is None else model.saturation_dn


def saturation_e(model: NativeModel, to: Conventions) -> float:
    """Return that signal in electrons [e-]."""
    return saturation(model, to) / model.system_gain


def times(value: float | None, factor: float) -> float | None:
    """Return a value in another unit, where there is one."""
    return None if value is None else value * factor


def decibel(ratio: float | None) -> float | None:
    """Return 20 log10 of a ratio; None where there is none to be told."""
    return 20.0 * math.log10(ratio) if ratio is not None and math.isfinite(ratio) and ratio > 0.0 else None
