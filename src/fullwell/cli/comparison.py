"""Truth beside measurement, as the demo and the loop print it: a table per quantity, and how the pulls spread."""

import math
from collections.abc import Callable, Sequence
from itertools import groupby
from typing import Final

from rich.console import Console

from fullwell.cli.tables import plain_table
from fullwell.raw.cfa import channel_rank, leading_channel
from fullwell.report.numbers import show, show_plain, show_signed, show_unit
from fullwell.units import DECIBEL, DN, ELECTRON, ELECTRON_PER_SECOND, STOP
from fullwell.workflow.loop.comparison import Comparison

_UNIT_ORDER: Final = (ELECTRON, ELECTRON_PER_SECOND, STOP, DECIBEL, DN)
_NOTABLE_PULL: Final = 3.0
_NORMAL_95: Final = 1.96


def print_comparison(console: Console, compared: Sequence[Comparison]) -> None:
    """Print a table per quantity with a line per ISO and the pulls of all channels; recommended figures only."""
    console.print(
        "Truth and measurement per ISO, of all channels together where they share a figure, of G1 elsewhere; under "
        "each channel its pull: the error in standard errors.\n",
        highlight=False,
    )
    shown = [one for one in compared if one.recommended and not one.row.quantity.endswith("_variance")]
    for _name, rows in groupby(sorted(shown, key=_name_order(shown)), key=_title):
        _print_quantity(console, list(rows))


def print_spread(console: Console, pulls: Sequence[float]) -> None:
    """Print how some pulls spread, beside what is honest."""
    console.print(_spread(pulls), highlight=False, soft_wrap=True)


def _print_quantity(console: Console, compared: Sequence[Comparison]) -> None:
    unit = min((one.row.measured.unit for one in compared), key=_unit_rank)
    shown = [one for one in compared if one.row.measured.unit == unit]
    channels = sorted({one.row.channel for one in shown}, key=channel_rank)
    title = f"{_title(compared[0])}, {show_unit(unit)}".removesuffix(", ")
    table = plain_table(">ISO", ">truth", ">measured", *(f">{channel}" for channel in channels), title=title)
    for iso in sorted({one.row.iso for one in shown}, key=lambda iso: iso or 0.0):
        lines = {one.row.channel: one for one in reversed(shown) if one.row.iso == iso}  # its own temperature is first
        chosen = lines[leading_channel(lines)]
        table.add_row(
            "" if iso is None else f"{iso:g}",
            show_plain(chosen.truth),
            show(chosen.row.measured, chosen.row.flags),
            *(_pull(lines[channel].pull) if channel in lines else "" for channel in channels),
        )
    console.print(table)


def _name_order(compared: Sequence[Comparison]) -> Callable[[Comparison], int]:
    """Return what puts quantities into the order of the results."""
    first = {_title(one): at for at, one in reversed(list(enumerate(compared)))}
    return lambda one: first[_title(one)]


def _title(one: Comparison) -> str:
    threshold = one.row.snr_threshold
    return one.row.quantity.replace("_", " ") + ("" if threshold in {None, 1.0} else f" (SNR {threshold:g})")


def _unit_rank(unit: str) -> int:
    return _UNIT_ORDER.index(unit) if unit in _UNIT_ORDER else len(_UNIT_ORDER)


def _pull(pull: float | None) -> str:
    if pull is None:
        return ""
    text = show_signed(pull)
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
