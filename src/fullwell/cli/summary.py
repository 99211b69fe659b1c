"""What people read after a measurement: findings, the recommended figures, and where the report is."""

from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Final

from rich.console import Console
from rich.markup import escape

from fullwell.cli.tables import plain_table, print_findings
from fullwell.figures.results import Results, Row, at_main_temperature
from fullwell.glossary import RECOMMENDED
from fullwell.raw.cfa import channel_rank
from fullwell.report.numbers import show, show_iso, show_unit
from fullwell.units import DECIBEL, DN, DN_PER_ELECTRON, DN_PER_SECOND, ELECTRON, ELECTRON_PER_SECOND, STOP

_HEADLINES: Final = (
    ("black_level", (DN,)),
    ("system_gain", (DN_PER_ELECTRON,)),
    ("read_noise", (ELECTRON, DN)),
    ("dark_current", (ELECTRON_PER_SECOND, DN_PER_SECOND)),
    ("saturation_capacity", (ELECTRON, DN)),
    ("snr_max", (DECIBEL,)),
    ("dynamic_range", (STOP, DECIBEL)),
)
"""Quantities of the summary, each with its units from the most to the least wanted."""


def print_summary(console: Console, results: Results, *, out: Path) -> None:
    """Print findings, a table of the recommended figures per ISO, and the report's place."""
    print_findings(console, results.findings)
    recommended = [row for row in at_main_temperature(results.rows) if _is_headline(row)]
    for iso in sorted({row.iso for row in recommended}, key=lambda iso: (iso is not None, iso or 0.0)):
        _print_iso(console, iso, [row for row in recommended if row.iso == iso])
    console.print(f"Report: {escape(str(out / 'report.html'))}", highlight=False, soft_wrap=True)


def _is_headline(row: Row) -> bool:
    return (
        RECOMMENDED in row.flags and row.region is None and row.exposure_s is None and row.snr_threshold in {None, 1.0}
    )


def _print_iso(console: Console, iso: float | None, rows: Sequence[Row]) -> None:
    channels = sorted({row.channel for row in rows}, key=channel_rank)
    table = plain_table("", *(f">{channel}" for channel in channels), "", title=show_iso(iso))
    for quantity, units in _HEADLINES:
        found = [row for row in rows if row.quantity == quantity]
        unit = next((unit for unit in units if any(row.measured.unit == unit for row in found)), None)
        if unit is None:
            continue
        cells = [
            _cell(row for row in found if row.channel == channel and row.measured.unit == unit) for channel in channels
        ]
        table.add_row(quantity.replace("_", " "), *cells, show_unit(unit))
    if table.row_count:
        console.print(table)


def _cell(rows: Iterable[Row]) -> str:
    return ", ".join(show(row.measured, row.flags) for row in rows)
