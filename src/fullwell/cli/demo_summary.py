"""Truth beside measurement, as the demo prints it."""

import math
from collections.abc import Iterator, Sequence
from itertools import groupby
from pathlib import Path
from typing import Final

from rich.console import Console
from rich.markup import escape

from fullwell.cli.tables import plain_table, print_findings
from fullwell.raw.cfa import CHANNELS, MONO
from fullwell.report.numbers import show, show_plain, show_unit
from fullwell.units import DECIBEL, DN, ELECTRON, ELECTRON_PER_SECOND, STOP
from fullwell.workflow.demo import DemoOutcome, DemoRow

_UNIT_ORDER: Final = (ELECTRON, ELECTRON_PER_SECOND, STOP, DECIBEL, DN)
_CHANNEL_ORDER: Final = ("all", MONO, "G1", *CHANNELS)
_NOTABLE_PULL: Final = 3.0
_NORMAL_95: Final = 1.96


def print_outcome(console: Console, outcome: DemoOutcome, *, out: Path) -> None:
    """Print findings, one line per quantity and ISO with the pulls of all channels, and how the pulls spread."""
    print_findings(console, outcome.findings)
    table = plain_table("quantity", ">ISO", ">truth", ">measured", "", ">pull", "pulls of the channels")
    for rows in _lines(outcome.rows):
        chosen = min(rows, key=lambda row: _rank(row.channel, _CHANNEL_ORDER))
        others = [row for row in rows if row.channel in CHANNELS]
        table.add_row(
            _title(chosen),
            "" if chosen.iso is None else f"{chosen.iso:g}",
            show_plain(chosen.truth),
            show(chosen.measured, chosen.flags),
            show_unit(chosen.measured.unit),
            _pull(chosen.pull),
            "  ".join(f"{row.channel} {_pull(row.pull)}" for row in others),
        )
    console.print(table)
    for sentence in (_spread(outcome.pulls), _closing(outcome, out)):
        console.print(sentence, highlight=False, soft_wrap=True)


def _title(row: DemoRow) -> str:
    threshold = "" if row.snr_threshold in {None, 1.0} else f" (SNR {row.snr_threshold:g})"
    return row.quantity.replace("_", " ") + threshold


def _lines(rows: Sequence[DemoRow]) -> Iterator[list[DemoRow]]:
    """Yield the recommended rows of one quantity at one ISO, in the unit that says most, by quantity and ISO."""
    recommended = [row for row in rows if row.recommended]
    order = {row.quantity: at for at, row in reversed(list(enumerate(recommended)))}

    def place(row: DemoRow) -> tuple[int, float, float]:
        return (order[row.quantity], row.snr_threshold or 0.0, row.iso or 0.0)

    for _place, group in groupby(sorted(recommended, key=place), key=place):
        members = list(group)
        unit = min((row.measured.unit for row in members), key=lambda unit: _rank(unit, _UNIT_ORDER))
        yield sorted(
            (row for row in members if row.measured.unit == unit), key=lambda row: _rank(row.channel, CHANNELS)
        )


def _rank(name: str, order: Sequence[str]) -> int:
    return order.index(name) if name in order else len(order)


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
