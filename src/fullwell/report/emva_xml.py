"""Results written as the package emva1288 writes its own: one XML file per channel and operation point.

What the package knows stands in its sections, with its tags, symbols and units: figures of the profile
``emva1288-py-1.0`` where the results have its system gain, else those of Release 4.0. The root of a variance below
zero is ``nan``, as the package has it. What the package does not know, standard errors and limits above all, stands in
a section ``toolkit`` of its own.
"""

from collections.abc import Iterator, Sequence
from typing import Final
from xml.etree.ElementTree import Element, SubElement, indent, tostring

from fullwell.figures.results import Results, Row
from fullwell.report.curves import Table, table_named
from fullwell.report.datasheet.build import LINEAR, PACKAGE, RELEASES
from fullwell.report.emva_items import HISTOGRAMS, ITEMS, Item

_SECTIONS: Final = ("dark_current", "defect_pixel", "info", "linearity", "sensitivity", "spatial")
_TOOLKIT: Final = "toolkit"
_PROFILES: Final = (PACKAGE, LINEAR)


def reference_files(results: Results) -> tuple[tuple[str, str], ...]:
    """Return name and text of every file."""
    held = {row.method for row in results.rows if row.quantity == "system_gain"} or {row.method for row in results.rows}
    profile = next((one for one in _PROFILES if one in held), None)
    if profile is None:
        return ()
    rows = [row for row in results.rows if row.method == profile and row.region is None]
    places = dict.fromkeys((row.channel, row.iso, row.temperature_c) for row in rows)
    return tuple(
        (
            f"{_name(channel, iso, temperature)}.xml",
            _file(results, [row for row in rows if (row.channel, row.iso, row.temperature_c) == place], profile),
        )
        for place in places
        for channel, iso, temperature in (place,)
    )


def _name(channel: str, iso: float | None, temperature_c: float | None) -> str:
    parts = [
        channel,
        *([] if iso is None else [f"iso{iso:g}"]),
        *([] if temperature_c is None else [f"{temperature_c:g}c"]),
    ]
    return "_".join(parts)


def _file(results: Results, rows: Sequence[Row], profile: str) -> str:
    root = Element("results")
    sections = {name: SubElement(root, name) for name in (*_SECTIONS, _TOOLKIT)}
    for item in sorted(ITEMS, key=lambda one: one.tag):
        value = _value(item, rows)
        if value is not None:
            _add(sections[item.section], item, value)
    for tag, short in HISTOGRAMS:
        table = _histogram(results, tag, rows[0])
        if table is not None:
            _add_histogram(sections["defect_pixel"], tag, short, table)
    for tag, short, unit, value in _beyond(rows):
        _add(sections[_TOOLKIT], Item(section=_TOOLKIT, tag=tag, short=short, unit=unit), value)
    for tag, text in (("profile", profile), ("release", RELEASES[profile])):
        entry = SubElement(sections[_TOOLKIT], tag)
        SubElement(entry, "comment").text = text
        SubElement(entry, "value").text = "None"  # the package's reader wants a value, and takes this for none
    for section in list(root):
        if not len(section):
            root.remove(section)
    indent(root)
    return tostring(root, encoding="unicode") + "\n"


def _value(item: Item, rows: Sequence[Row]) -> str | None:
    """Return the value of an item as the package writes it; None where no row holds it."""
    if item.tag == "index_start":
        return "0"
    row = next(
        (
            row
            for row in rows
            if (row.quantity, row.measured.unit) == (item.quantity, item.row_unit) and row.snr_threshold in {None, 1.0}
        ),
        None,
    )
    if row is None:
        return None
    return _number(row)


def _number(row: Row) -> str:
    """Return a value; nan for the root of a variance at or below zero."""
    value = float(row.measured.value)
    return "nan" if "upper-limit" in row.flags and value <= 0.0 else repr(value)


def _add(section: Element, item: Item, value: str) -> None:
    entry = SubElement(section, item.tag)
    fields = (
        ("section", item.section),
        ("short", item.short),
        ("symbol", item.symbol),
        ("unit", item.unit),
        ("latexname", item.latexname),
        ("value", value),
    )
    for name, text in fields:
        if text:
            SubElement(entry, name).text = text


def _histogram(results: Results, tag: str, row: Row) -> Table | None:
    """Return the histogram that belongs to a row's profile, ISO, temperature and channel."""
    which = "dsnu" if "DSNU" in tag else "prnu"
    kind = "accumulated" if tag.endswith("accumulated") else "histogram"
    table = table_named(results.curves, f"emva_{kind}_{which}")
    if table is None:
        return None
    of_this = (row.method, row.iso, row.temperature_c, row.channel)
    mine = table.chosen(line == of_this for line in table.lines("method", "iso", "temperature_c", "channel"))
    return mine if len(mine) else None


def _add_histogram(section: Element, tag: str, short: str, table: Table) -> None:
    entry = SubElement(section, tag)
    SubElement(entry, "section").text = section.tag
    SubElement(entry, "short").text = short
    data = SubElement(entry, "data")
    values = "share" if tag.endswith("accumulated") else "pixels"
    for name, column in (("bins", "deviation"), ("values", values), ("model", "model")):
        numbers = table.values(column)
        if any(number is not None for number in numbers):
            SubElement(data, name).text = " ".join("nan" if number is None else f"{number}" for number in numbers)


def _beyond(rows: Sequence[Row]) -> Iterator[tuple[str, str, str, str]]:
    """Yield what the package has no place for: figures of Release 4.0; the standard error or limit of each figure."""
    placed = {(item.quantity, item.row_unit): item.tag for item in ITEMS if item.quantity}
    for row in rows:
        measured = row.measured
        if row.snr_threshold not in {None, 1.0}:
            continue
        tag = placed.get((row.quantity, measured.unit))
        if tag is None:
            tag = f"{row.quantity}_{_plain(measured.unit)}".rstrip("_")
            yield (tag, row.quantity.replace("_", " "), measured.unit, _number(row))
        if measured.std_error is not None:
            yield (f"{tag}_uncertainty", f"one standard error of {tag}", measured.unit, repr(measured.std_error))
        elif "upper-limit" in row.flags and measured.ci95 is not None:
            yield (f"{tag}_upper_limit", f"{tag} is at most this", measured.unit, repr(float(measured.ci95[1])))
        elif "lower-bound" in row.flags:
            yield (f"{tag}_lower_bound", f"{tag} is at least this", measured.unit, _number(row))


def _plain(unit: str) -> str:
    """Return a unit as a tag may have it."""
    text = unit.replace("%", "percent").replace("e-", "e").replace("/", "_per_").replace("^", "")
    return "" if unit == "1" else text
