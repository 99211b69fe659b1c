"""Truth beside measurement, as the demo prints it."""

import math
from collections.abc import Callable, Sequence
from itertools import groupby
from pathlib import Path
from typing import Final

from rich.console import Console
from rich.markup import escape

from fullwell.cli.tables import plain_table, print_findings
from fullwell.raw.cfa import channel_rank, leading_channel
from fullwell.report.numbers import show, show_plain, show_unit
from fullwell.units import DECIBEL, DN, ELECTRON, ELECTRON_PER_SECOND, STOP
from fullwell.workflow.demo import DemoOutcome, DemoRow

_UNIT_ORDER: Final = (ELECTRON, ELECTRON_PER_SECOND, STOP, DECIBEL, DN)
_NOTABLE_PULL: Final = 3.0
_NORMAL_95: Final = 1.96


def print_outcome(console: Console, outcome: DemoOutcome, *, out: Path) -> None:
    """Print findings, a table per quantity with a line per ISO and the pulls of all channels, and how they spread."""
    print_findings(console, outcome.findings)
    console.print(
        "Truth and measurement per ISO, of all channels together where they share a figure, of G1 elsewhere; under "
        "each channel its pull: the error in standard errors.\n",
        highlight=False,
    )
    recommended = [row for row in outcome.rows if row.recommended and not row.quantity.endswith("_variance")]
    for _name, rows in groupby(sorted(recommended, key=_name_order(recommended)), key=_title):
        _print_quantity(console, list(rows))
    for sentence in (_spread(outcome.pulls), _closing(outcome, out)):
        console.print(sentence, highlight=False, soft_wrap=True)


def _print_quantity(console: Console, rows: Sequence[DemoRow]) -> None:
    unit = min((row.measured.unit for row in rows), key=_unit_rank)
    shown = [row for row in rows if row.measured.unit == unit]
    channels = sorted({row.channel for row in shown}, key=channel_rank)
    title = f"{_title(rows[0])}, {show_unit(unit)}".removesuffix(", ")
    table = plain_table(">ISO", ">truth", ">measured", *(f">{channel}" for channel in channels), title=title)
    for iso in sorted({row.iso for row in shown}, key=lambda iso: iso or 0.0):
        lines = {row.channel: row for row in shown if row.iso == iso}
        chosen = lines[leading_channel(lines)]
        table.add_row(
            "" if iso is None else f"{iso:g}",
            show_plain(chosen.truth),
            show(chosen.measured, chosen.flags),
            *(_pull(lines[channel].pull) if channel in lines else "" for channel in channels),
        )
    console.print(table)


def _name_order(rows: Sequence[DemoRow]) -> Callable[[DemoRow], int]:
    """Return what puts quantities into the order of the results."""
    first = {_title(row): at for at, row in reversed(list(enumerate(rows)))}
    return lambda row: first[_title(row)]


def _title(row: DemoRow) -> str:
    threshold = "" if row.snr_threshold in {None, 1.0} else f" (SNR {row.snr_threshold:g})"
    return row.quantity.replace("_", " ") + threshold


def _unit_rank(unit: str) -> int:
    return _UNIT_ORDER.index(unit) if unit in _UNIT_ORDER else len(_UNIT_ORDER)


def _pull(pull: float | None) -> str:
    if pull is None:
        return ""
    text = f"{pull:+.1f}"
    return f"[bold red]{text}[/bold red]" if abs(pull) > _NOTABLE_PULL else text


def _spread(pulls: Sequence[float]) -> str:
    if not pulls:
        return "No figure has a pull."
    inside = sum(abs(pull) <= _NORMAL_95 for pull in pulls)
    rms = math.sqrt(sum(pull**2 for pull in pulls) / len(pulls))
    return (
        f"{len(pulls)} pulls (error in standard errors): root mean square {rms:.2f} (1 is honest), "
        f"{100.0 * inside / len(pulls):.1f} % within 1.96 (95 % is honest), largest {max(map(abs, pulls)):.1f}."
    )


def _closing(outcome: DemoOutcome, out: Path) -> str:
    return (
        f"{outcome.frames} frames simulated in {outcome.simulated_s:.1f} s, "
        f"measured in {outcome.characterized_s:.1f} s.\n"
        f"Every figure beside its truth: {escape(str(out / 'demo.json'))}\nReport: {escape(str(out / 'report.html'))}"
    )
