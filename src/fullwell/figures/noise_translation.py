"""A noise model translated: every figure of every dialect, with the error that what was given leaves it."""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

from fullwell.figures.noise_definition import Definition
from fullwell.figures.noise_dialects import IN_DN, IN_ELECTRONS, NOISE_PROFILE, k_definitions
from fullwell.figures.noise_emva import BY_EMVA
from fullwell.figures.noise_model import (
    DSNU_DN2,
    DSNU_E2,
    PRNU2,
    READ_DN2,
    READ_E2,
    SATURATION_DN,
    SATURATION_E,
    Conventions,
    GivenModel,
    NativeModel,
    native_model,
    native_values,
)
from fullwell.figures.propagation import propagated
from fullwell.figures.results import Row
from fullwell.figures.saturation import bounded
from fullwell.fit.noise_coefficients import boundary_variance
from fullwell.glossary.flags import RECOMMENDED
from fullwell.model.conversions import EMVA_VARIANCE_FLOOR
from fullwell.units import ONE, Measured, square_root

_SAME: Final = 1e-9
_NOT_INHERITED: Final = frozenset({RECOMMENDED, "upper-limit"})


@dataclass(frozen=True, slots=True, kw_only=True)
class Translation:
    """One figure of a noise model in one dialect.

    Parameters
    ----------
    dialect
        Heading that it stands under.
    symbol, equation
        What people write for it, and how it follows from the model.
    row
        The figure; its method is that of the measurement where it was measured directly.

    """

    dialect: str
    symbol: str
    equation: str
    row: Row


def translated(model: GivenModel) -> tuple[Translation, ...]:
    """Return every figure that follows from a noise model, dialect after dialect.

    Every noise has its signed variance beside it, named ``<quantity>_variance``.

    Raises
    ------
    ValueError
        Where the model has no positive system gain.

    """
    at = native_values(model)
    if at.system_gain <= 0.0:
        raise ValueError("a noise model needs a system gain above zero")
    return tuple(
        Translation(
            dialect=dialect,
            symbol=definition.symbol,
            equation=definition.equation,
            row=_measured_directly(model, row) if definition.direct else row,
        )
        for dialect, definitions in _dialects(model.conventions)
        for definition in definitions
        for row in _rows(model, definition, _flags(model, at, definition))
    )


def _dialects(conventions: Conventions) -> Iterator[tuple[str, tuple[Definition, ...]]]:
    """Yield headings with what stands under them, k's by the convention that was given first."""
    own = conventions.digital_maximum
    yield f"k's, D = {own:g} DN ({conventions.digital_maximum_is})", k_definitions(own, direct=True)
    others = ((conventions.white_level, "white level"), (conventions.signal_range, "white level - black level"))
    for other, name in others:
        if conventions.black_level and other is not None and abs(other - own) > _SAME * own:
            yield f"k's, D = {other:g} DN ({name})", k_definitions(other, direct=False)
    yield "DN", IN_DN
    yield "electrons", IN_ELECTRONS
    yield "EMVA 1288", BY_EMVA
    yield "DNG NoiseProfile", NOISE_PROFILE


def _rows(model: GivenModel, definition: Definition, flags: tuple[str, ...]) -> Iterator[Row]:
    """Yield a figure, and its signed variance where it has one; nothing where the model does not tell it."""
    computed = _computed(model, definition)
    if computed is None:
        return
    if definition.root:
        limit = ("upper-limit",) if computed.value <= 0.0 else ()
        root = square_root(computed, definition.unit)
        yield _row(model, definition, definition.quantity, root, (*flags, *limit))
        yield _row(model, definition, f"{definition.quantity}_variance", computed, flags)
    else:
        yield _row(model, definition, definition.quantity, computed, flags)


def _row(model: GivenModel, definition: Definition, quantity: str, measured: Measured, flags: tuple[str, ...]) -> Row:
    return Row(
        quantity=quantity,
        channel=model.channel,
        method=definition.method,
        measured=bounded(measured, flags),
        iso=model.iso,
        snr_threshold=definition.snr_threshold,
        flags=tuple(sorted(set(flags))),
        source=definition.source,
    )


def _measured_directly(model: GivenModel, row: Row) -> Row:
    """Return the measurement of a figure where there is one, or say that the figure was given as it is."""
    name = (row.quantity, row.measured.unit)
    if row.method != "conversion":
        return row
    measured = next((one for one in model.measured if (one.quantity, one.measured.unit) == name), None)
    if measured is not None:
        return measured
    return replace(row, method="given") if _is_given(model, row.quantity.removesuffix("_variance"), name[1]) else row


def _is_given(model: GivenModel, quantity: str, unit: str) -> bool:
    unit = unit.removesuffix("^2")
    squared = unit if unit == ONE else f"{unit}^2"
    of_prnu = quantity == "prnu" and PRNU2 in model.given
    return of_prnu or not model.given.keys().isdisjoint({(quantity, unit), (f"{quantity}_variance", squared)})


def _computed(model: GivenModel, definition: Definition) -> Measured | None:
    """Return a figure, or its signed variance, with its error."""
    names = tuple(model.given)

    def formula(values: NDArray[np.float64]) -> float:
        by_name = {name: float(value) for name, value in zip(names, values, strict=True)}
        value = definition.formula(native_model(by_name, model.conventions), model.conventions)
        return float("nan") if value is None else value

    unit = definition.unit if not definition.root or definition.unit == ONE else f"{definition.unit}^2"
    computed = propagated(formula, tuple(model.given.values()), unit=unit)
    if np.isnan(computed.value):
        return None
    if not definition.root or computed.std_error is None:
        return computed
    return boundary_variance(computed.value, computed.std_error, dof=computed.dof, unit=unit)


def _flags(model: GivenModel, at: NativeModel, definition: Definition) -> tuple[str, ...]:
    """Return what is to be said about a figure, from what it rests on."""
    flags: list[str] = []
    if "saturation" in definition.rests_on:
        flags += _saturation_flags(model)
    if "split" in definition.rests_on and model.given.keys().isdisjoint({READ_E2, READ_DN2, DSNU_E2, DSNU_DN2}):
        flags.append("mixed")
    if "fixed" in definition.rests_on and PRNU2 not in model.given:
        flags.append("mixed")
    if "rounding" in definition.rests_on and _hidden_by_rounding(at, model.conventions):
        flags.append("quantization-limited")
    return tuple(flags)


def _saturation_flags(model: GivenModel) -> tuple[str, ...]:
    if model.given.keys().isdisjoint({SATURATION_DN, SATURATION_E}):
        return ("adc-limited",)
    measured = (one for one in model.measured if one.quantity == "saturation_capacity")
    return tuple(flag for one in measured for flag in one.flags if flag not in _NOT_INHERITED)


def _hidden_by_rounding(at: NativeModel, conventions: Conventions) -> bool:
    """Tell whether the temporal variance in the dark is below the floor of EMVA 1288."""
    dark_electrons = (at.dark_current or 0.0) * conventions.exposure_s
    temporal_dn2 = (at.read_e2 + dark_electrons) * at.system_gain**2 + conventions.step**2 / 12.0
    return temporal_dn2 < EMVA_VARIANCE_FLOOR * conventions.step**2
