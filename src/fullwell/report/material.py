"""What the chapters of a report are made of: pictures, tabs, tables, and what is missing where they show nothing."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Final

from fullwell import glossary
from fullwell.figures.results import Results, Row, at_main_temperature
from fullwell.report import plots_iso
from fullwell.report.curves import Table, Value, table_named
from fullwell.report.numbers import show_iso
from fullwell.report.pictures import Pictures
from fullwell.report.pivots import Pivot, pivot, recommended, title_of
from fullwell.report.plots import Picture

_POSITION: Final = {entry.name: position for position, entry in enumerate(glossary.QUANTITIES)}


@dataclass(frozen=True, slots=True, kw_only=True)
class WordTable:
    """A table whose cells are read rather than compared: the last column wraps."""

    title: str
    head: tuple[str, ...]
    lines: tuple[tuple[str, ...], ...]
    note: str = ""


@dataclass(frozen=True, slots=True, kw_only=True)
class Tab:
    """What belongs to one ISO, or to one of several ways to look at the same thing."""

    label: str
    pictures: tuple[Picture, ...] = ()
    pivots: tuple[Pivot, ...] = ()


@dataclass(frozen=True, slots=True, kw_only=True)
class Part:
    """One step of a long chapter, under a heading of its own."""

    title: str
    lead: str = ""
    pictures: tuple[Picture, ...] = ()
    tabs: tuple[Tab, ...] = ()
    pivots: tuple[Pivot, ...] = ()
    tables: tuple[WordTable, ...] = ()
    details: tuple[WordTable, ...] = ()
    missing: str = ""

    @property
    def shown(self) -> bool:
        """Tell whether there is anything to see, be it only what is missing."""
        return any((self.pictures, self.tabs, self.pivots, self.tables, self.details, self.missing))


@dataclass(frozen=True, slots=True, kw_only=True)
class Section(Part):
    """One measurement: a chapter of the report."""

    anchor: str
    parts: tuple[Part, ...] = field(default=())

    @property
    def shown(self) -> bool:
        """Tell whether there is anything to see, in the chapter or in one of its parts."""
        return bool(self.parts) or any((self.pictures, self.tabs, self.pivots, self.tables, self.missing))


@dataclass(frozen=True, slots=True, kw_only=True)
class Material:
    """What the sections are made from.

    Parameters
    ----------
    results
        Everything the run found.
    rows
        Its recommended rows of the whole plane.
    pictures
        Arrays to show.

    """

    results: Results
    rows: tuple[Row, ...]
    pictures: Pictures

    def table(self, name: str) -> Table | None:
        """Return a curve as a table, None where it is missing or empty."""
        return table_named(self.results.curves, name)

    def pivots(self, *wanted: tuple[str, str]) -> tuple[Pivot, ...]:
        """Return the tables of some (quantity, unit) that have rows."""
        made = (pivot(self.rows, quantity, unit) for quantity, unit in wanted)
        return tuple(one for one in made if one)


def material_of(results: Results, pictures: Pictures | None) -> Material:
    """Return what the sections of a report are made from."""
    return Material(results=results, rows=recommended(results.rows), pictures=pictures or Pictures())


def parts_shown(*parts: Part) -> tuple[Part, ...]:
    """Return the parts that have something to show."""
    return tuple(part for part in parts if part.shown)


def drawn(table: Table | None, draw: Callable[[Table], Picture]) -> tuple[Picture, ...]:
    """Return the picture of a table, nothing where there is no table."""
    return (draw(table),) if table is not None else ()


def iso_tabs(table: Table | None, draw: Callable[[Table, Value], Picture]) -> tuple[Tab, ...]:
    """Return one tab per ISO of a table, each with its picture."""
    if table is None:
        return ()
    return tuple(Tab(label=iso_label(iso), pictures=(draw(part, iso),)) for iso, part in table.split("iso"))


def iso_label(iso: Value) -> str:
    """Return what a tab calls an ISO."""
    return show_iso(iso if isinstance(iso, (int, float)) else None)


def over_isos(material: Material) -> dict[tuple[str, str], dict[float, list[Row]]]:
    """Return the figures measured at more than one ISO by quantity and unit, and within them by SNR threshold."""
    panels: dict[tuple[str, str], dict[float, list[Row]]] = {}
    for row in sorted(at_main_temperature(material.rows), key=_glossary_order):
        if row.iso is not None and row.exposure_s is None and not row.quantity.endswith("_variance"):
            thresholds = panels.setdefault((row.quantity, row.measured.unit), {})
            thresholds.setdefault(row.snr_threshold or 0.0, []).append(row)
    return {
        what: dict(sorted(thresholds.items()))
        for what, thresholds in panels.items()
        if len({row.iso for rows in thresholds.values() for row in rows}) > 1
    }


def course(material: Material, caption: str, *wanted: tuple[str, str]) -> tuple[Picture, ...]:
    """Return one picture of some figures against ISO, nothing where none was measured at several."""
    several = over_isos(material)
    panels: dict[tuple[str, str], list[Row]] = {}
    for quantity, unit in wanted:
        for threshold, rows in several.get((quantity, unit), {}).items():
            name = title_of(quantity)
            panels[(f"{name}, SNR {threshold:g}" if threshold else name, unit)] = rows
    titles = ", ".join(dict.fromkeys(title for title, _ in panels))
    return (plots_iso.against_iso(panels, alt=f"{titles} against ISO", caption=caption),) if panels else ()


def _glossary_order(row: Row) -> tuple[int, str, int]:
    """Order rows by quantity as the glossary does, then by unit."""
    entry = glossary.quantity(row.quantity)
    if entry is None:
        return (len(glossary.QUANTITIES), row.quantity, 0)
    unit = row.measured.unit
    return (_POSITION.get(row.quantity, 0), row.quantity, entry.units.index(unit) if unit in entry.units else 9)


def isos_of(rows: Sequence[Row]) -> tuple[float, ...]:
    """Return the ISOs that have figures, ascending."""
    return tuple(sorted({row.iso for row in rows if row.iso is not None}))
