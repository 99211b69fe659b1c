"""What people read after ``fullwell compare``: what is compared, EMVA against chart, figures and their differences."""

from collections.abc import Sequence
from pathlib import Path
from typing import Final

from rich.console import Console
from rich.markup import escape

from fullwell.cli.tables import plain_table, print_findings
from fullwell.figures.differences import Difference
from fullwell.figures.matching import Crossing, Match
from fullwell.figures.results import Row
from fullwell.figures.side_by_side import Comparison, Side, TenFigures
from fullwell.glossary import RECOMMENDED
from fullwell.glossary.comparable import Kinship
from fullwell.report.compare_page import Cell, difference_cell, relative, told_cell, where
from fullwell.report.numbers import MISSING, show, show_iso, show_signed, show_unit

_MOST: Final = 60


def print_comparison(console: Console, comparison: Comparison, *, out: Path | None) -> None:
    """Print the sides, the ten figures, recommended figures by the same method, and those by different ones."""
    print_findings(console, comparison.findings)
    for side in comparison.sides:
        console.print(_about(side), highlight=False, soft_wrap=True)
    for ten in comparison.tens:
        _print_ten(console, ten)
    shown = [match for match in comparison.matches if _is_leading(match)]
    _print_matches(console, comparison.sides, shown[:_MOST])
    _print_crossings(console, comparison.sides, [one for one in comparison.crossings if _is_told(one)])
    left = len(comparison.matches) - len(shown[:_MOST])
    if left:
        console.print(f"{left} further figures by the same method: -o OUT or --json.", highlight=False, soft_wrap=True)
    if out is not None:
        console.print(f"Report: {escape(str(out / 'report.html'))}", highlight=False, soft_wrap=True)


def _about(side: Side) -> str:
    parts = [side.name, side.camera, *side.bodies]
    parts += ["simulated"] if side.simulated else []
    parts += [f"EMVA profile {side.emva}"] if side.emva else []
    parts += ["chart"] if side.chart else []
    return f"[bold]{side.label}[/bold] {escape('; '.join(part for part in parts if part))}"


def _is_leading(match: Match) -> bool:
    row = match.reference
    best = any(one is not None and RECOMMENDED in one.flags for one in match.rows)
    return best and row.region is None and not row.quantity.endswith("_variance") and row.exposure_s is None


def _is_told(crossing: Crossing) -> bool:
    row = crossing.rows[0]
    return crossing.verdict.kinship is not Kinship.UNKNOWN and not row.quantity.endswith("_variance")


def _print_matches(console: Console, sides: Sequence[Side], matches: Sequence[Match]) -> None:
    """Print a table per ISO."""
    isos = dict.fromkeys(match.reference.iso for match in matches)
    for iso in isos:
        mine = [match for match in matches if match.reference.iso == iso]
        title = f"{show_iso(iso)}: recommended figures by the same method"
        table = plain_table("figure", *_heads(sides), title=title)
        for column in table.columns[1 + len(sides) :]:
            column.no_wrap = True
        for match in mine:
            cells = [_value(one) for one in match.rows]
            for one in match.differences[1:]:
                cells += [_relative(one), _size(one)]
            table.add_row(_placed(match.reference), *cells)
        console.print(table, highlight=False)
    if matches:
        console.print("s.e.: the difference from A in its standard errors, bold below p = 0.01.", highlight=False)


def _heads(sides: Sequence[Side]) -> list[str]:
    heads = [f">{side.label}" for side in sides]
    for side in sides[1:]:
        heads += [f">{side.label}/A", ">s.e."]
    return heads


def _placed(*rows: Row) -> str:
    return f"{_named(rows[0])} {escape(where(*rows, iso=False))}"


def _relative(one: Difference | None) -> str:
    return MISSING if one is None else relative(one) or MISSING


def _size(one: Difference | None) -> str:
    """Return a difference in standard errors, bold where chance makes one as large less than once in a hundred."""
    if one is None or one.statistic is None:
        return MISSING
    text = show_signed(one.statistic)
    return f"[bold]{text}[/bold]" if difference_cell(one).notable else text


def _named(row: Row) -> str:
    return f"{row.quantity.replace('_', ' ')} [dim]{show_unit(row.measured.unit) or '1'}[/dim]"


def _value(row: Row | None) -> str:
    return MISSING if row is None else show(row.measured, row.flags)


def _marked(cell: Cell) -> str:
    return f"[bold]{cell.text}[/bold]" if cell.notable else cell.text


def _print_crossings(console: Console, sides: Sequence[Side], crossings: Sequence[Crossing]) -> None:
    """Print a table per ISO."""
    shown = crossings[:_MOST]
    for iso in dict.fromkeys(one.rows[0].iso for one in shown):
        title = f"{show_iso(iso)}: by different methods"
        table = plain_table("figure", ">one", ">other", ">difference", "comparable", title=title)
        for one in (one for one in shown if one.rows[0].iso == iso):
            labels = (sides[one.first].label, sides[one.second].label)
            figures = [
                f"{label} {show(row.measured, row.flags)}\n[dim]{row.method}[/dim]"
                for label, row in zip(labels, one.rows, strict=True)
            ]
            cells = (*figures, _marked(difference_cell(one.difference)), one.verdict.kinship)
            table.add_row(_placed(*one.rows), *cells)
        console.print(table, highlight=False)
    left = len(crossings) - len(shown)
    if left:
        console.print(f"{left} further figures by different methods: -o OUT or --json.", highlight=False)


def _print_ten(console: Console, ten: TenFigures) -> None:
    at = "" if ten.iso is None else f", {show_iso(ten.iso)}"
    title = f"EMVA 1288 of {ten.emva} ({ten.profile}) against the chart of {ten.chart}, {ten.channel}{at}"
    table = plain_table("figure", ">EMVA", "is", ">chart", "is", ">chart less EMVA", title=title)
    for line in ten.lines:
        chart = line.chart.definition if line.chart.measured else line.chart.reason
        table.add_row(
            f"{line.title} [dim]{show_unit(line.unit) or '1'}[/dim]",
            told_cell(line.emva).text,
            f"[dim]{escape(line.emva.definition)}[/dim]",
            told_cell(line.chart).text,
            f"[dim]{escape(chart)}[/dim]",
            _marked(difference_cell(line.difference)),
        )
    console.print(table, highlight=False)
