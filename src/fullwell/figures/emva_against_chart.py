"""The ten figures of EMVA 1288 that published comparisons set beside those of a chart, with what each of them means.

Figures of one name are not always figures of one truth: a chart's SNR counts fixed pattern, EMVA 1288's does not. Every
line therefore has both definitions, and says whether the two may be compared.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

from fullwell.figures.differences import Difference, row_difference
from fullwell.figures.propagation import Ingredient, propagated
from fullwell.figures.results import Row
from fullwell.model import conversions
from fullwell.units import (
    DECIBEL,
    DN_PER_ELECTRON,
    ELECTRON,
    ELECTRON2,
    ELECTRON_PER_SECOND,
    ONE,
    PERCENT,
    Measured,
    square_root,
)

BIT: Final = "bit"


@dataclass(frozen=True, slots=True, kw_only=True)
class Told:
    """A figure as one side has it, or why it has none.

    Parameters
    ----------
    definition
        What the figure is on this side.
    measured
        None where this side cannot tell.
    flags
        Of its row, a bound for example.
    reason
        Why it cannot; empty otherwise.

    """

    definition: str
    measured: Measured | None = None
    flags: tuple[str, ...] = ()
    reason: str = ""


@dataclass(frozen=True, slots=True, kw_only=True)
class Line:
    """One figure on both sides.

    Parameters
    ----------
    title, unit
        Of the figure.
    emva, chart
        Both sides.
    difference
        The chart's less EMVA's; None where one is missing.
    note
        How far the two may be compared.

    """

    title: str
    unit: str
    emva: Told
    chart: Told
    difference: Difference | None
    note: str


@dataclass(frozen=True, slots=True, kw_only=True)
class Sides:
    """What the lines are made from.

    Parameters
    ----------
    emva
        Rows of one EMVA profile, one channel and operation point.
    chart
        Figures of the chart's noise model, of one channel and ISO.
    exposure_s
        Exposure of the chart, which the total dark noise is told for; 0 where unknown [s].
    bits
        Of EMVA's and the chart's codes, None where unknown.
    shared
        Whether both come from the same frames.

    """

    emva: Sequence[Row]
    chart: Sequence[Row]
    exposure_s: float = 0.0
    bits: tuple[int | None, int | None] = (None, None)
    shared: bool = False


@dataclass(frozen=True, slots=True, kw_only=True)
class _Figure:
    title: str
    unit: str
    emva: str
    chart: str
    emva_of: Callable[[Sides], Row | None]
    chart_of: Callable[[Sides], Row | None]
    missing: str = "The chart does not tell it."
    note: str = ""
    alike: bool = True


def ten_lines(sides: Sides) -> tuple[Line, ...]:
    """Return the ten figures in the order of the published table."""
    return tuple(_line(figure, sides) for figure in _FIGURES)


def _line(figure: _Figure, sides: Sides) -> Line:
    emva, chart = figure.emva_of(sides), figure.chart_of(sides)
    independent = figure.alike and not sides.shared
    return Line(
        title=figure.title,
        unit=figure.unit,
        emva=_told(figure.emva, emva, missing="The EMVA results do not hold it."),
        chart=_told(figure.chart, chart, missing=figure.missing),
        difference=row_difference(chart, emva, independent=independent) if emva and chart else None,
        note=figure.note,
    )


def _told(definition: str, row: Row | None, *, missing: str) -> Told:
    if row is None:
        return Told(definition=definition, reason=missing)
    return Told(definition=definition, measured=row.measured, flags=row.flags)


def _row(rows: Sequence[Row], quantity: str, unit: str, method: str | None = None) -> Row | None:
    """Return the recommended row of a quantity, else its first."""
    mine = [
        row
        for row in rows
        if (row.quantity, row.measured.unit) == (quantity, unit) and (method is None or row.method == method)
    ]
    return next((row for row in mine if "recommended" in row.flags), mine[0] if mine else None)


def _of_emva(quantity: str, unit: str) -> Callable[[Sides], Row | None]:
    def find(sides: Sides) -> Row | None:
        return _row(sides.emva, quantity, unit)

    return find


def _of_chart(quantity: str, unit: str, method: str | None = None) -> Callable[[Sides], Row | None]:
    def find(sides: Sides) -> Row | None:
        return _row(sides.chart, quantity, unit, method)

    return find


def _apart(quantity: str, unit: str) -> Callable[[Sides], Row | None]:
    """Return a part of the dark noise, where the chart's frames tell it from the others."""

    def find(sides: Sides) -> Row | None:
        row = _row(sides.chart, quantity, unit)
        return None if row is None or "mixed" in row.flags else row

    return find


def _emva_fraction(sides: Sides) -> Row | None:
    prnu = _row(sides.emva, "prnu", PERCENT)
    return None if prnu is None else replace(prnu, measured=prnu.measured.scaled(0.01, ONE))


def _emva_total(sides: Sides) -> Row | None:
    """Return the noise of one frame in the dark from its parts: sigma_d^2 + DSNU^2 + i t + 1/12K^2."""
    parts = {
        "dark": _variance(sides.emva, "dark_noise"),
        "dsnu": _variance(sides.emva, "dsnu"),
        "K": _measured(sides.emva, "system_gain", DN_PER_ELECTRON),
        "i": _measured(sides.emva, "dark_current", ELECTRON_PER_SECOND) or Measured.exact(0.0, ELECTRON_PER_SECOND),
    }
    known = {name: one for name, one in parts.items() if one is not None}
    if len(known) < len(parts) or known["K"].value <= 0.0:
        return None
    names = tuple(known)

    def formula(values: NDArray[np.float64]) -> float:
        at = dict(zip(names, map(float, values), strict=True))
        return conversions.unlit_electrons2(
            at["dark"],
            system_gain=at["K"],
            dsnu_electrons2=at["dsnu"],
            dark_electrons=at["i"] * sides.exposure_s,
        )

    variance = propagated(formula, [Ingredient(measured=one) for one in known.values()], unit=ELECTRON2)
    return _computed(square_root(variance, ELECTRON))


def _computed(measured: Measured) -> Row:
    """Return a figure that follows from others as a row."""
    return Row(quantity="total_dark_noise", channel="all", method="conversion", measured=measured)


def _measured(rows: Sequence[Row], quantity: str, unit: str) -> Measured | None:
    row = _row(rows, quantity, unit)
    return None if row is None else row.measured


def _variance(rows: Sequence[Row], quantity: str) -> Measured | None:
    """Return the variance of a noise in electrons: its signed twin, or else its square."""
    twin = _row(rows, f"{quantity}_variance", ELECTRON2)
    root = _row(rows, quantity, ELECTRON)
    if twin is not None:
        return twin.measured
    if root is None:
        return None
    value, error = root.measured.value, root.measured.std_error
    square = value**2
    return (
        Measured.exact(square, ELECTRON2) if error is None else Measured.normal(square, 2.0 * value * error, ELECTRON2)
    )


def _bits(at: int) -> Callable[[Sides], Row | None]:
    def find(sides: Sides) -> Row | None:
        bits = sides.bits[at]
        return None if bits is None else _computed(Measured.exact(bits, BIT))

    return find


_MIXED: Final = "A chart's patches hold temporal noise and DSNU together: see total dark noise."
_NO_DARK: Final = "A chart is shot at one exposure: nothing tells the rate. Take dark frames of several exposures."

_FIGURES: Final = (
    _Figure(
        title="Dynamic range",
        unit=DECIBEL,
        emva="Saturation over the signal at which temporal noise alone gives SNR 1: mu_p.sat / mu_p.min",
        chart="Saturation over the signal at which all noise of one frame gives SNR 1: V_sat / V_1",
        emva_of=_of_emva("dynamic_range", DECIBEL),
        chart_of=_of_chart("dynamic_range", DECIBEL, "noise-model"),
        note="Another definition: the chart's noise in the dark holds DSNU, EMVA's does not.",
        alike=False,
    ),
    _Figure(
        title="Maximum SNR",
        unit=DECIBEL,
        emva="Photon noise alone: sqrt(mu_e.sat)",
        chart="All noise at saturation, fixed pattern included: V_sat / sigma(V_sat)",
        emva_of=_of_emva("snr_max", DECIBEL),
        chart_of=_of_chart("snr_max", DECIBEL, "noise-model"),
        note="Another definition: only the row `shot-only` of the chart has EMVA's.",
        alike=False,
    ),
    _Figure(
        title="Saturation capacity",
        unit=ELECTRON,
        emva="Mean signal where 0.1 to 0.2 % of the pixels stand at the highest code, eta mu_p.sat",
        chart="Signal of the brightest patch that the noise model still describes, V_sat / k_shot^2",
        emva_of=_of_emva("saturation_capacity", ELECTRON),
        chart_of=_of_chart("saturation_capacity", ELECTRON),
        note="Another definition: a chart finds saturation no finer than its steps of density.",
        alike=False,
    ),
    _Figure(
        title="Dark noise",
        unit=ELECTRON,
        emva="Temporal noise at the shortest exposure without rounding, sigma_d",
        chart="Temporal noise without rounding, where DSNU is known apart",
        emva_of=_of_emva("dark_noise", ELECTRON),
        chart_of=_apart("read_noise", ELECTRON),
        missing=_MIXED,
    ),
    _Figure(
        title="System gain",
        unit=DN_PER_ELECTRON,
        emva="Slope of temporal variance against signal, 0 to 70 % of saturation, K",
        chart="Photon-noise term of the fitted noise model, D k_shot^2",
        emva_of=_of_emva("system_gain", DN_PER_ELECTRON),
        chart_of=_of_chart("system_gain", DN_PER_ELECTRON),
        note="The same truth.",
    ),
    _Figure(
        title="Dark current",
        unit=ELECTRON_PER_SECOND,
        emva="Slope of the mean dark signal against exposure time, mu_c.mean",
        chart="None",
        emva_of=_of_emva("dark_current", ELECTRON_PER_SECOND),
        chart_of=_of_chart("dark_current", ELECTRON_PER_SECOND),
        missing=_NO_DARK,
    ),
    _Figure(
        title="DSNU",
        unit=ELECTRON,
        emva="Spatial standard deviation of the mean dark frame after the high-pass, DSNU1288",
        chart="None",
        emva_of=_of_emva("dsnu", ELECTRON),
        chart_of=_apart("dsnu", ELECTRON),
        missing=_MIXED,
    ),
    _Figure(
        title="Total dark noise",
        unit=ELECTRON,
        emva="From the parts: sqrt(sigma_d^2 + DSNU^2 + i t + 1/12K^2)",
        chart="Dark term of the fitted noise model, k_dark / k_shot^2",
        emva_of=_emva_total,
        chart_of=_of_chart("total_dark_noise", ELECTRON),
        note="The same truth. Published tables add (i t)^2, though charge is Poisson's, and leave rounding out.",
    ),
    _Figure(
        title="PRNU",
        unit=ONE,
        emva="Spatial standard deviation of the response over its mean, PRNU1288",
        chart="Fixed-pattern term of the fitted noise model, k_FPN",
        emva_of=_emva_fraction,
        chart_of=_of_chart("k_fpn", ONE),
        note="k_FPN also holds the texture of the chart: at least PRNU.",
    ),
    _Figure(
        title="Bits of a code",
        unit=BIT,
        emva="Declared, not measured",
        chart="Declared, not measured",
        emva_of=_bits(0),
        chart_of=_bits(1),
        missing="Not declared.",
        alike=False,
    ),
)
