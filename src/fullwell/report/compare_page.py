"""A comparison as one page that opens without a network."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import jinja2
from markupsafe import Markup

from fullwell import glossary
from fullwell.figures.differences import Difference
from fullwell.figures.emva_against_chart import Line, Told
from fullwell.figures.matching import Crossing, Match
from fullwell.figures.results import Row
from fullwell.figures.side_by_side import Comparison, Side, TenFigures
from fullwell.report.inventory import run_date
from fullwell.report.numbers import (
    MISSING,
    show,
    show_change,
    show_exposure,
    show_iso,
    show_signed,
    show_unit,
    show_value,
)
from fullwell.report.pivots import title_of, tooltip
from fullwell.report.plots_compare import comparison_pictures
from fullwell.units import DECIBEL, STOP

MOST_LINES: Final = 3000
_NOTABLE: Final = 0.01
_HALF: Final = 0.5


@dataclass(frozen=True, slots=True, kw_only=True)
class Cell:
    """One number on the page: its text, what hovering tells, and whether it is to be noticed."""

    text: str
    title: str = ""
    notable: bool = False
    below: str = ""


@dataclass(frozen=True, slots=True, kw_only=True)
class FigureLine:
    """One figure of several results."""

    where: str
    method: str
    best: bool
    values: tuple[Cell, ...]
    differences: tuple[Cell, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class FigureBlock:
    """One quantity in one unit, with its definition."""

    quantity: str
    title: str
    unit: str
    definition: str
    lines: tuple[FigureLine, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class CrossLine:
    """One quantity by two methods."""

    title: str
    unit: str
    where: str
    figures: tuple[tuple[str, str, Cell], ...]
    difference: Cell
    kinship: str
    reason: str


@dataclass(frozen=True, slots=True, kw_only=True)
class TenLine:
    """One of the ten figures."""

    title: str
    unit: str
    emva: Cell
    emva_definition: str
    chart: Cell
    chart_definition: str
    difference: Cell
    note: str


def comparison_html(comparison: Comparison) -> str:
    """Return the page of a comparison."""
    environment = jinja2.Environment(
        loader=jinja2.PackageLoader("fullwell.report"),
        autoescape=True,
        trim_blocks=True,
        lstrip_blocks=True,
        undefined=jinja2.StrictUndefined,
    )
    css = Markup(environment.get_template("report.css").render())  # noqa: S704 - a constant of the package
    whole = [match for match in comparison.matches if _is_shown(match.reference)]
    return environment.get_template("compare.html").render(
        css=css,
        sides=[_side(side) for side in comparison.sides],
        others=[side.label for side in comparison.sides[1:]],
        findings=comparison.findings,
        tens=[(ten, [_ten(line) for line in ten.lines], _heading(ten)) for ten in comparison.tens],
        pictures=comparison_pictures(comparison),
        blocks=figure_blocks(whole[:MOST_LINES]),
        omitted=len(comparison.matches) - len(whole[:MOST_LINES]),
        crossings=[_crossing(one, comparison.sides) for one in comparison.crossings if _is_shown(one.rows[0])],
    )


def _is_shown(row: Row) -> bool:
    """Tell whether the page has room for a row: of the whole plane, and no signed twin of a root beside it."""
    return row.region is None and not row.quantity.endswith("_variance")


def figure_blocks(matches: Sequence[Match]) -> tuple[FigureBlock, ...]:
    """Return the figures by quantity and unit, in the order of the glossary."""
    order = {entry.name: at for at, entry in enumerate(glossary.QUANTITIES)}
    groups: dict[tuple[str, str], list[Match]] = {}
    for match in matches:
        groups.setdefault((match.reference.quantity, match.reference.measured.unit), []).append(match)
    ranked = sorted(groups.items(), key=lambda item: order.get(item[0][0], len(order)))
    return tuple(_block(quantity, unit, mine) for (quantity, unit), mine in ranked)


def _block(quantity: str, unit: str, matches: Sequence[Match]) -> FigureBlock:
    entry = glossary.quantity(quantity)
    return FigureBlock(
        quantity=quantity,
        title=title_of(quantity),
        unit=show_unit(unit) or "1",
        definition="" if entry is None else f"{entry.definition} {entry.equation}.",
        lines=tuple(_figure_line(match) for match in matches),
    )


def _figure_line(match: Match) -> FigureLine:
    return FigureLine(
        where=where(match.reference),
        method=match.reference.method,
        best=any(row is not None and glossary.RECOMMENDED in row.flags for row in match.rows),
        values=tuple(_value(row) for row in match.rows),
        differences=tuple(difference_cell(one) for one in match.differences[1:]),
    )


def where(*rows: Row, iso: bool = True) -> str:
    """Return channel and conditions of rows of one figure, each condition by the first that knows it.

    Parameters
    ----------
    rows
        The figure as results have it.
    iso
        Whether the ISO is named.

    """
    first = rows[0]
    exposure_s = next((row.exposure_s for row in rows if row.exposure_s is not None), None)
    temperature_c = next((row.temperature_c for row in rows if row.temperature_c is not None), None)
    snr_threshold = next((row.snr_threshold for row in rows if row.snr_threshold is not None), None)
    parts = [first.channel]
    parts += [show_iso(first.iso)] if iso and first.iso is not None else []
    parts += [] if exposure_s is None else [show_exposure(exposure_s)]
    parts += [] if temperature_c is None else [f"{temperature_c:.1f} °C"]
    parts += [] if snr_threshold is None else [f"SNR {snr_threshold:g}"]
    return ", ".join(parts)


def _value(row: Row | None) -> Cell:
    return Cell(text=MISSING) if row is None else Cell(text=show(row.measured, row.flags), title=tooltip(row))


def difference_cell(one: Difference | None) -> Cell:
    """Return a difference with what it is in per cent, its statistic and the chance of it."""
    if one is None:
        return Cell(text=MISSING)
    text = show(one.measured) if one.measured.std_error else show_value(one.measured)
    part = relative(one)
    if one.statistic is None or one.p_value is None:
        title = "no error: one of the figures has none, they have no one truth, or both come from the same frames"
        return Cell(text=text, title=title, below=part)
    statistic = f"{show_signed(one.statistic)} s.e."
    chance = "p < 0.0001" if one.p_value < 1e-4 else f"p = {one.p_value:.2g}"
    below = ", ".join(filter(None, (part, statistic, chance)))
    return Cell(text=text, below=below, notable=one.p_value < _NOTABLE)


def relative(one: Difference) -> str:
    """Return a difference in per cent, as a multiple where large; empty for logarithms and beside zero."""
    if one.ratio is None or one.ratio <= 0.0 or one.measured.unit in {DECIBEL, STOP}:
        return ""
    if not _HALF <= one.ratio <= 1.0 / _HALF:
        return f"{one.ratio:.3g} times"
    return f"{show_change(100.0 * (one.ratio - 1.0))} %"


def _crossing(crossing: Crossing, sides: Sequence[Side]) -> CrossLine:
    row = crossing.rows[0]
    labels = (sides[crossing.first].label, sides[crossing.second].label)
    return CrossLine(
        title=title_of(row.quantity),
        unit=show_unit(row.measured.unit) or "1",
        where=where(*crossing.rows),
        figures=tuple((label, one.method, _value(one)) for label, one in zip(labels, crossing.rows, strict=True)),
        difference=difference_cell(crossing.difference),
        kinship=crossing.verdict.kinship.value,
        reason=crossing.verdict.reason,
    )


def _heading(ten: TenFigures) -> str:
    parts = [f"EMVA 1288 of {ten.emva} ({ten.profile}) against the chart of {ten.chart}", ten.channel]
    return ", ".join([*parts, *([] if ten.iso is None else [show_iso(ten.iso)])])


def _ten(line: Line) -> TenLine:
    return TenLine(
        title=line.title,
        unit=show_unit(line.unit) or "1",
        emva=told_cell(line.emva),
        emva_definition=line.emva.definition,
        chart=told_cell(line.chart),
        chart_definition=line.chart.definition,
        difference=difference_cell(line.difference),
        note=line.note,
    )


def told_cell(told: Told) -> Cell:
    """Return a figure of the ten, or that it is not told, with the reason to hover over."""
    if told.measured is None:
        return Cell(text="not told", title=told.reason)
    return Cell(text=show(told.measured, told.flags))


def _side(side: Side) -> dict[str, object]:
    run = side.results.run
    kinds = [
        *([f"EMVA 1288 by {side.emva}"] if side.emva else []),
        *(["chart"] if side.chart else []),
        {"truth": "truth of a simulation", "emva1288": "result file of the package emva1288"}.get(side.source, ""),
        *(["simulated frames"] if side.simulated and side.source == "results" else []),
    ]
    return {
        "label": side.label,
        "name": side.name,
        "camera": side.camera or MISSING,
        "bodies": side.bodies or ("not named in the files",),
        "kinds": ", ".join(kind for kind in kinds if kind) or "measured",
        "isos": ", ".join("unknown" if iso is None else f"{iso:g}" for iso in side.isos),
        "time": run_date(side.results) or MISSING,
        "version": str(run.get("version") or MISSING),
        "rows": len(side.results.rows),
    }
