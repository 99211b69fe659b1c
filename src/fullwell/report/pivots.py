"""Rows as small tables: one quantity by ISO and channel, with what its flags say."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from string import ascii_lowercase

from fullwell import glossary
from fullwell.figures.results import Row
from fullwell.raw.cfa import channel_rank
from fullwell.report.numbers import MISSING, show, show_interval, show_iso, show_plain, show_unit


@dataclass(frozen=True, slots=True, kw_only=True)
class Note:
    """What a mark behind a number says."""

    mark: str
    text: str


@dataclass(frozen=True, slots=True, kw_only=True)
class Cell:
    """One number: its text, what hovering over it tells, and the marks of its flags."""

    text: str
    title: str = ""
    marks: str = ""


@dataclass(frozen=True, slots=True, kw_only=True)
class Line:
    """One line of a table."""

    label: str
    cells: tuple[Cell, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class Pivot:
    """One quantity in one unit: a line per ISO, a column per channel."""

    quantity: str
    title: str
    unit: str
    channels: tuple[str, ...]
    lines: tuple[Line, ...]
    notes: tuple[Note, ...]


def recommended(rows: Iterable[Row]) -> tuple[Row, ...]:
    """Return the figures to quote: flagged as recommended, of the whole plane."""
    return tuple(row for row in rows if glossary.RECOMMENDED in row.flags and row.region is None)


def title_of(quantity: str) -> str:
    """Return what people call a quantity, also one the glossary does not know."""
    entry = glossary.quantity(quantity)
    return entry.title if entry else quantity.replace("_", " ").capitalize()


def pivot(rows: Sequence[Row], quantity: str, unit: str) -> Pivot | None:
    """Return one quantity as a table; None where no row has it.

    Parameters
    ----------
    rows
        Every recommended row: where one of them knows its ISO, a row without belongs to all.
    quantity, unit
        As in the rows.

    """
    mine = [row for row in rows if (row.quantity, row.measured.unit) == (quantity, unit)]
    if not mine:
        return None
    channels = tuple(sorted({row.channel for row in mine}, key=channel_rank))
    marks = _marks(mine)
    conditions = sorted({_condition(row) for row in mine})
    many = _varying(conditions)
    beyond = "all ISOs" if any(row.iso is not None for row in rows) else show_iso(None)
    lines = tuple(
        Line(
            label=_label(condition, many, beyond),
            cells=tuple(_cell(mine, condition, channel, marks) for channel in channels),
        )
        for condition in conditions
    )
    return Pivot(
        quantity=quantity,
        title=title_of(quantity),
        unit=show_unit(unit),
        channels=channels,
        lines=lines,
        notes=tuple(Note(mark=mark, text=describe_flag(name)) for name, mark in marks.items()),
    )


def describe_flag(name: str) -> str:
    """Return a flag with what it means."""
    entry = glossary.flag(name)
    return f"{name}: {entry.definition}" if entry else name


def tooltip(row: Row) -> str:
    """Return what hovering over a number tells: interval, method, pixel values, source."""
    parts = [f"95 %: {show_interval(row.measured)}"] if row.measured.ci95 else []
    if row.measured.dof is not None:
        parts.append(f"{row.measured.dof:.4g} degrees of freedom")
    parts.append(f"method {row.method}")
    if row.n is not None:
        parts.append(f"{show_plain(float(row.n))} pixel values")
    if row.source:
        parts.append(row.source)
    return "; ".join(parts)


Condition = tuple[float, float, float, float]


def _condition(row: Row) -> Condition:
    """Return ISO, threshold, exposure and temperature as numbers that sort; -1 is unknown."""
    return (
        -1.0 if row.iso is None else row.iso,
        -1.0 if row.snr_threshold is None else row.snr_threshold,
        -1.0 if row.exposure_s is None else row.exposure_s,
        -300.0 if row.temperature_c is None else row.temperature_c,
    )


def _varying(conditions: Sequence[Condition]) -> tuple[bool, bool, bool]:
    threshold, exposure, temperature = (len({condition[i] for condition in conditions}) > 1 for i in (1, 2, 3))
    return threshold, exposure, temperature


def _label(condition: Condition, many: tuple[bool, bool, bool], beyond: str) -> str:
    iso, threshold, exposure, temperature = condition
    parts = [show_iso(iso) if iso >= 0.0 else beyond]
    if many[0] and threshold >= 0.0:
        parts.append(f"SNR {threshold:g}")
    if many[1] and exposure >= 0.0:
        parts.append(f"{exposure:.4g} s")
    if many[2] and temperature > -300.0:
        parts.append(f"{temperature:.1f} °C")
    return ", ".join(parts)


def _marks(rows: Sequence[Row]) -> dict[str, str]:
    names = sorted({flag for row in rows for flag in row.flags} - {glossary.RECOMMENDED})
    return dict(zip(names, ascii_lowercase, strict=False))


def _cell(rows: Sequence[Row], condition: Condition, channel: str, marks: dict[str, str]) -> Cell:
    row = next((row for row in rows if row.channel == channel and _condition(row) == condition), None)
    if row is None:
        return Cell(text=MISSING)
    shown = " ".join(marks[name] for name in row.flags if name in marks)
    return Cell(text=show(row.measured, row.flags), title=tooltip(row), marks=shown)
