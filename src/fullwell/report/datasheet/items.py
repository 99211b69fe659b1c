"""The figures of a summary page in the order and with the decimals of the standard's template (EMVA1288.md 10.1)."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

from fullwell.figures.results import Row
from fullwell.report.datasheet.contents import ItemGroup, ItemLine
from fullwell.report.numbers import MISSING, show_unit
from fullwell.units import DECIBEL, DN, DN_PER_ELECTRON, ELECTRON, ELECTRON_PER_SECOND, ONE, PERCENT, Measured

_MINUS: Final = "\N{MINUS SIGN}"
_PER_AREA: Final = "e-/um^2"
_FALLING: Final = frozenset({"inverse_snr_max"})
"""Figures that fall as saturation rises: a bound of saturation bounds them from the other side."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Entry:
    """One line of the template: symbol, row and decimals."""

    symbol: str
    quantity: str
    unit: str
    decimals: int


@dataclass(frozen=True, slots=True, kw_only=True)
class Group:
    """The lines under one heading."""

    title: str
    entries: tuple[Entry, ...]


def _group(title: str, *entries: tuple[str, str, str, int]) -> Group:
    return Group(
        title=title,
        entries=tuple(
            Entry(symbol=symbol, quantity=quantity, unit=unit, decimals=decimals)
            for symbol, quantity, unit, decimals in entries
        ),
    )


_PARTS: Final = (("", "1288", ""), ("_column", "1288.col", ""), ("_row", "1288.row", ""), ("_pixel", "1288.pix", ""))

SPATIAL: Final = (
    _group(
        "Spatial nonuniformities",
        *((f"DSNU_{{{low}}}", f"dsnu{part}", ELECTRON, 1) for part, low, _ in _PARTS),
        *((f"PRNU_{{{low}}}", f"prnu{part}", PERCENT, 2) for part, low, _ in _PARTS),
    ),
)

TEMPLATE: Final = (
    _group("Quantum efficiency", ("η", "quantum_efficiency", PERCENT, 1)),
    _group(
        "Overall system gain",
        ("K", "system_gain", DN_PER_ELECTRON, 3),
        ("1/K", "conversion_factor", "e-/DN", 2),
    ),
    _group("Temporal dark noise", ("σ_{d}", "dark_noise", ELECTRON, 1), ("σ_{y.dark}", "dark_noise", DN, 2)),
    _group(
        "Signal-to-noise ratio",
        ("SNR_{max}", "snr_max", ONE, 0),
        ("SNR_{max}", "snr_max", DECIBEL, 1),
        ("1/SNR_{max}", "inverse_snr_max", PERCENT, 2),
    ),
    _group(
        "Absolute sensitivity threshold",
        ("μ_{e.min}", "sensitivity_threshold", ELECTRON, 1),
        ("μ_{e.min.area}", "sensitivity_threshold_per_area", _PER_AREA, 2),
    ),
    _group(
        "Saturation capacity",
        ("μ_{e.sat}", "saturation_capacity", ELECTRON, 0),
        ("μ_{e.sat.area}", "saturation_capacity_per_area", _PER_AREA, 0),
    ),
    _group("Dynamic range", ("DR", "dynamic_range", ONE, 0), ("DR", "dynamic_range", DECIBEL, 1)),
    *SPATIAL,
    _group("Linearity error", ("LE", "linearity_error", PERCENT, 2)),
    _group(
        "Dark current",
        ("μ_{c.mean}", "dark_current", ELECTRON_PER_SECOND, 1),
        ("μ_{c.var}", "dark_current_from_variance", ELECTRON_PER_SECOND, 1),
    ),
)
"""Groups in the order of the template."""

PACKAGE_LINEARITY: Final = _group(
    "Linearity error",
    ("LE_{min}", "linearity_error_min", PERCENT, 2),
    ("LE_{max}", "linearity_error_max", PERCENT, 2),
)
"""What the reference package has for the linearity error."""


def item_groups(template: Sequence[Group], rows: Sequence[Row], marks: dict[str, str]) -> tuple[ItemGroup, ...]:
    """Return the figures of one channel at one operation point.

    Parameters
    ----------
    template
        What to list.
    rows
        Rows of one profile.
    marks
        Quantities with the mark of their footnote.

    """
    return tuple(
        ItemGroup(title=group.title, lines=tuple(_line(entry, rows, marks) for entry in group.entries))
        for group in template
    )


def row_of(entry: Entry, rows: Sequence[Row]) -> Row | None:
    """Return the row of a line: at SNR 1 where it has a threshold."""
    return next(
        (
            row
            for row in rows
            if (row.quantity, row.measured.unit) == (entry.quantity, entry.unit) and row.snr_threshold in {None, 1.0}
        ),
        None,
    )


def _line(entry: Entry, rows: Sequence[Row], marks: dict[str, str]) -> ItemLine:
    row = row_of(entry, rows)
    unit = show_unit(entry.unit)
    if row is None:
        return ItemLine(symbol=entry.symbol, value=MISSING, error="", unit=unit, note=marks.get(entry.quantity, ""))
    return ItemLine(
        symbol=entry.symbol,
        value=_value(row, entry.decimals),
        error=error_text(row.measured),
        unit=unit,
        note=marks.get(entry.quantity, ""),
    )


def _value(row: Row, decimals: int) -> str:
    measured = row.measured
    if "upper-limit" in row.flags and measured.ci95 is not None:
        return f"< {fixed(measured.ci95[1], max(decimals, _places(measured.ci95[1])))}"
    text = fixed(measured.value, decimals)
    if "lower-bound" not in row.flags:
        return text
    return f"≤ {text}" if row.quantity in _FALLING else f"≥ {text}"


def error_text(measured: Measured) -> str:
    """Return the standard error to two significant digits, empty where there is none."""
    if measured.std_error is None or measured.value == 0.0 or not math.isfinite(measured.std_error):
        return ""
    return fixed(measured.std_error, _places(measured.std_error))


def _places(value: float) -> int:
    """Return the decimals that two significant digits need."""
    return 0 if value <= 0.0 else min(max(1 - math.floor(math.log10(value)), 0), 6)


def fixed(value: float, decimals: int) -> str:
    """Return a number with its decimals and a proper minus sign; what rounds to zero has none."""
    text = f"{value:.{decimals}f}"
    return text.removeprefix("-") if float(text) == 0.0 else text.replace("-", _MINUS)
