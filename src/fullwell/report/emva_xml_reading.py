"""Result files of the package emva1288 read as rows, in the lower case it writes and the CamelCase it documents."""

import math
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Final
from xml.etree.ElementTree import Element, ParseError

from fullwell.errors import UsageError
from fullwell.figures.results import Results, Row
from fullwell.findings import Finding, Severity, listed
from fullwell.glossary import RECOMMENDED
from fullwell.raw.cfa import MONO
from fullwell.report.emva_items import ITEMS, Item
from fullwell.units import Measured

METHOD: Final = "emva1288-py-1.0"
SOURCE: Final = "EMVA1288-PY"
_LARGEST: Final = 64 * 2**20
"""Bytes of a file that may be a result file: beyond, somebody named another one."""


def read_reference_results(path: Path) -> Results:
    """Return the figures of a result file; what is None or nan there is left out and named in a finding.

    A file that we wrote tells its profile; every other one is the package's own.

    Parameters
    ----------
    path
        XML file that the package wrote, or that was edited by hand: a decimal comma is read.

    Raises
    ------
    UsageError
        Where it cannot be read, or is no such file.

    """
    root = _root(path)
    method = root.findtext("toolkit/profile/comment", default=METHOD)
    items = {item.tag.lower(): item for item in ITEMS}
    rows: list[Row] = []
    missing: list[str] = []
    for tag, fields in _entries(root):
        item = items.get(tag)
        if item is None or not item.quantity or "value" not in fields:
            continue
        value = _number(fields["value"], tag=item.tag, path=path)
        if value is None:
            missing.append(item.tag)
        else:
            rows.append(_row(item, value, method))
    if not rows and not missing:
        raise UsageError(f"{path} holds no figure of the package emva1288 (results, sections, items).")
    return Results(study={"camera": {}}, rows=tuple(rows), findings=tuple(_findings(missing)), curves=())


def _root(path: Path) -> Element:
    from xml.etree.ElementTree import XMLParser, fromstring  # noqa: PLC0415 - entities are refused below

    try:
        text = path.read_bytes()
    except OSError as error:
        raise UsageError(f"Cannot read {path}: {error.strerror}.") from error
    if len(text) > _LARGEST or b"<!DOCTYPE" in text or b"<!ENTITY" in text:
        raise UsageError(f"{path} is no result file of the package emva1288: those have no document type.")
    try:
        root = fromstring(text, parser=XMLParser())  # noqa: S314 - no document type, so no entities
    except ParseError as error:
        raise UsageError(f"{path} is no valid XML: {error}.") from error
    if root.tag.lower() != "results":
        raise UsageError(f"{path} is no result file of the package emva1288: its root is {root.tag}, not results.")
    return root


def _entries(root: Element) -> Iterator[tuple[str, Mapping[str, str]]]:
    """Yield every item, whatever section it stands in, with its fields; tags in lower case."""
    for section in root:
        for item in section:
            yield item.tag.lower(), {field.tag.lower(): (field.text or "").strip() for field in item}


def _number(text: str, *, tag: str, path: Path) -> float | None:
    """Return a value; None where the file says None, nan or nothing."""
    if text.lower() in {"", "none", "nan"}:
        return None
    try:
        value = float(text.replace(",", "."))
    except ValueError as error:
        raise UsageError(f"{path}: {tag} has the value {text!r}, which is no number.") from error
    return value if math.isfinite(value) else None


def _row(item: Item, value: float, method: str) -> Row:
    return Row(
        quantity=item.quantity,
        channel=MONO,
        method=method,
        measured=Measured.exact(value, item.row_unit),
        flags=(RECOMMENDED,),
        source=SOURCE,
    )


def _findings(missing: list[str]) -> Iterator[Finding]:
    if missing:
        yield Finding(
            code="figures-missing",
            severity=Severity.INFO,
            message=f"The file holds no number for {listed(missing)}: the package writes nan for negative variances.",
        )
