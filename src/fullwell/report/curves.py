"""Curves as tables to draw from: columns by name, split by ISO, channel or exposure."""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from fullwell.figures.results import Curve
from fullwell.raw.cfa import channel_rank

Value: TypeAlias = float | int | str | None


@dataclass(frozen=True, slots=True, kw_only=True)
class Table:
    """A curve, or the part of it that belongs to one group.

    Parameters
    ----------
    columns
        Name and values of each column, all of one length.

    """

    columns: tuple[tuple[str, tuple[Value, ...]], ...]

    def __len__(self) -> int:
        """Return the number of points."""
        return len(self.columns[0][1]) if self.columns else 0

    def values(self, name: str) -> tuple[Value, ...]:
        """Return a column as it is; all None where there is no such column."""
        return next((values for column, values in self.columns if column == name), (None,) * len(self))

    def lines(self, *names: str) -> Iterator[tuple[Value, ...]]:
        """Yield the values of some columns, point by point."""
        return zip(*(self.values(name) for name in names), strict=True)

    def numbers(self, name: str) -> NDArray[np.float64]:
        """Return a column as floats, shape (points,); what is unknown is NaN."""
        return np.array([value if isinstance(value, (int, float)) else np.nan for value in self.values(name)], float)

    def chosen(self, keep: Iterable[bool]) -> "Table":
        """Return the points whose entry in ``keep`` is true."""
        kept = np.flatnonzero(np.fromiter(keep, bool, len(self)))
        return Table(columns=tuple((name, tuple(values[i] for i in kept)) for name, values in self.columns))

    def split(self, name: str) -> Iterator[tuple[Value, "Table"]]:
        """Yield each distinct value of a column with its points: numbers ascending, channels in CFA order."""
        column = self.values(name)
        groups: dict[Value, list[int]] = {}
        for index, value in enumerate(column):
            groups.setdefault(value, []).append(index)
        for value in sorted(groups, key=_rank):
            indices = groups[value]
            parts = tuple((column, tuple(values[i] for i in indices)) for column, values in self.columns)
            yield value, Table(columns=parts)


def _rank(value: Value) -> tuple[int, float, str]:
    if isinstance(value, str):
        return (1, channel_rank(value), value)
    return (0, -np.inf if value is None else float(value), "")


def table_named(curves: Sequence[Curve], name: str) -> Table | None:
    """Return the curves of one name as one table; None where there is none, or none with a point."""
    found = [curve for curve in curves if curve.name == name]
    if not found:
        return None
    columns = tuple(
        (column.name, tuple(value for curve in found for value in curve.column(column.name)))
        for column in found[0].columns
    )
    table = Table(columns=columns)
    return table if len(table) else None
