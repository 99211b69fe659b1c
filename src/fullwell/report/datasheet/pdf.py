"""The datasheet as report.pdf."""

from dataclasses import asdict
from importlib.resources import files
from typing import cast

from fullwell.report.datasheet.contents import Datasheet, DataTable, Graph, OperationPoint
from fullwell.report.typesetting import pdf_of

_SIDE_BY_SIDE = ((3, 3), (4, 2), (6, 2))
"""Columns of a table up to which so many pieces of it stand side by side."""


_SHORT = 10
"""Lines that a piece of a table has at least."""


def datasheet_pdf(sheet: Datasheet) -> bytes:
    """Return the datasheet set in type."""
    template = files("fullwell.report").joinpath("templates", "datasheet.typ").read_text(encoding="utf-8")
    drawings: dict[str, bytes] = {}
    points = [_point(point, at, drawings) for at, point in enumerate(sheet.points)]
    data = {**cast("dict[str, object]", asdict(sheet)), "points": points}
    return pdf_of(template, data=data, drawings=drawings)


def _point(point: OperationPoint, at: int, drawings: dict[str, bytes]) -> dict[str, object]:
    small = [_named(f"small-{at}-{index}", drawing, drawings) for index, drawing in enumerate(point.small)]
    return {
        "title": point.title,
        "facts": [asdict(fact) for fact in point.facts],
        "channels": [asdict(channel) for channel in point.channels],
        "small": small,
        "graphs": [_graph(graph, at, drawings) for graph in point.graphs],
    }


def _graph(graph: Graph, at: int, drawings: dict[str, bytes]) -> dict[str, object]:
    return {
        "title": graph.title,
        "caption": graph.caption,
        "missing": graph.missing,
        "drawing": _named(f"{graph.name}-{at}", graph.drawing, drawings),
        "tables": [_table(table) for table in graph.tables],
    }


def _named(name: str, drawing: bytes, drawings: dict[str, bytes]) -> str:
    if not drawing:
        return ""
    drawings[f"{name}.svg"] = drawing
    return f"{name}.svg"


def _table(table: DataTable) -> dict[str, object]:
    """Return a table in pieces of like length that stand side by side."""
    columns = len(table.head)
    most_pieces = next((count for most, count in _SIDE_BY_SIDE if columns <= most), 1)
    pieces = min(most_pieces, max(1, len(table.lines) // _SHORT))
    length = -(-len(table.lines) // pieces)
    return {
        "channel": table.channel,
        "head": table.head,
        "total": table.total,
        "shown": len(table.lines),
        "pieces": [table.lines[start : start + length] for start in range(0, len(table.lines), length)],
    }
