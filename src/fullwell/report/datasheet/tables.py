"""The data behind a graph as tables of text, long ones thinned by one stated rule."""

import math
from collections.abc import Sequence
from typing import Final

from fullwell.raw.cfa import MONO
from fullwell.report.curves import Table, Value
from fullwell.report.datasheet.contents import DataTable
from fullwell.report.numbers import MISSING, show_unit

MOST_LINES: Final = 60
THINNING: Final = (
    f"Tables of more than {MOST_LINES} lines show {MOST_LINES} of them, equally spaced, the first and the last "
    "included; the line above the table says so. All lines are in the curves of results.json."
)
_DIGITS: Final = 6
_MINUS: Final = "\N{MINUS SIGN}"

Columns = Sequence[tuple[str, str, str]]
"""Name in the curve, words of the heading, unit."""


def data_tables(table: Table, columns: Columns) -> tuple[DataTable, ...]:
    """Return a graph's data, one table a channel; columns that hold nothing are left out."""
    return tuple(_data_table(str(channel), part, columns) for channel, part in table.split("channel"))


def _data_table(channel: str, part: Table, columns: Columns) -> DataTable:
    kept = [column for column in columns if any(value is not None for value in part.values(column[0]))]
    values = [part.values(name) for name, _, _ in kept]
    return DataTable(
        channel="" if channel == MONO else channel,
        head=tuple(_heading(words, unit) for _, words, unit in kept),
        lines=tuple(tuple(_text(column[at]) for column in values) for at in thinned_places(len(part))),
        total=len(part),
    )


def thinned_places(length: int, most: int = MOST_LINES) -> list[int]:
    """Return the lines that a table of some length shows.

    Examples
    --------
    >>> thinned_places(5, 3)
    [0, 2, 4]

    """
    if length <= most:
        return list(range(length))
    return [round(at * (length - 1) / (most - 1)) for at in range(most)]


def _heading(words: str, unit: str) -> str:
    shown = show_unit(unit)
    return f"{words} [{shown}]" if shown else words


def _text(value: Value) -> str:
    """Return a number to six digits, without the zeros that say nothing."""
    if value is None:
        return MISSING
    if isinstance(value, str):
        return value
    if not math.isfinite(value):
        return MISSING
    return f"{value:.{_DIGITS}g}".replace("-", _MINUS)
