"""The chapter on EMVA 1288 in report.html: what the datasheet holds, on the page."""

from collections.abc import Iterator, Sequence

from fullwell.report.datasheet.contents import Datasheet, Fact, Graph, ItemGroup, OperationPoint
from fullwell.report.material import Part, Section, WordTable
from fullwell.report.plots import picture_of


def emva_section(sheet: Datasheet) -> Section:
    """Return the chapter of a datasheet."""
    return Section(
        anchor="emva-1288",
        title="EMVA 1288",
        lead=(
            f"Evaluated with profile {sheet.profile}: {sheet.release}. Fullwell does not claim compliance with the "
            "standard. The same stands, set for print, in report.pdf."
        ),
        tables=tuple(_missing(sheet)),
        parts=(
            *(_summary(point) for point in sheet.points),
            _general(sheet),
            *(_graph(graph, point, sheet) for point in sheet.points for graph in point.graphs),
        ),
    )


def plain_symbol(symbol: str) -> str:
    """Return a symbol without mark-up.

    Examples
    --------
    >>> plain_symbol("μ_{e.min}")
    'μ_e.min'

    """
    return symbol.replace("{", "").replace("}", "")


def _missing(sheet: Datasheet) -> Iterator[WordTable]:
    if sheet.missing:
        yield WordTable(
            title="Missing of what the standard asks for",
            head=("Item", "Reason"),
            lines=tuple((one.item, one.reason) for one in sheet.missing),
        )


def _summary(point: OperationPoint) -> Part:
    names = tuple(channel.channel for channel in point.channels)
    tables = [
        WordTable(
            title="Figures in the order of the standard; ± is one standard error",
            head=("Figure", "Symbol", *names, "Unit"),
            lines=tuple(_lines([channel.groups for channel in point.channels])),
            note=" ".join(_notes(point)),
        )
    ]
    beside = [channel.beside for channel in point.channels if channel.beside]
    if len(beside) == len(names):
        tables.append(
            WordTable(
                title="Beside EMVA 1288: the attenuation of the high-pass divided out",
                head=("Figure", "Symbol", *names, "Unit"),
                lines=tuple(_lines(beside)),
            )
        )
    return Part(title=f"Summary, {point.title}", tables=tuple(tables))


def _lines(channels: Sequence[tuple[ItemGroup, ...]]) -> Iterator[tuple[str, ...]]:
    """Yield one line a figure, a cell a channel."""
    for groups in zip(*channels, strict=True):
        for at, lines in enumerate(zip(*(group.lines for group in groups), strict=True)):
            title = groups[0].title if at == 0 else ""
            cells = (f"{one.value} ± {one.error}" if one.error else one.value for one in lines)
            yield (title, plain_symbol(lines[0].symbol), *cells, lines[0].unit)


def _notes(point: OperationPoint) -> Iterator[str]:
    """Yield why figures are missing, and what the flags of others mean, each once."""
    return iter(dict.fromkeys(text for channel in point.channels for text in channel.reasons))


def _general(sheet: Datasheet) -> Part:
    points = tuple(
        Fact(label=f"{point.title}: {fact.label}", text=fact.text) for point in sheet.points for fact in point.facts
    )
    facts = (*sheet.basic, *sheet.equipment, *points)
    return Part(
        title="General",
        details=(
            WordTable(
                title="Basic information, test equipment, operation points",
                head=("Item", "As stated"),
                lines=tuple((fact.label, fact.text) for fact in facts),
            ),
        ),
    )


def _graph(graph: Graph, point: OperationPoint, sheet: Datasheet) -> Part:
    title = graph.title if len(sheet.points) == 1 else f"{graph.title}, {point.title}"
    if not graph.drawing:
        return Part(title=title, missing=graph.missing)
    return Part(
        title=title,
        pictures=(picture_of(graph.drawing, alt=title, caption=graph.caption),),
        details=tuple(
            WordTable(
                title=f"Data{f' of channel {table.channel}' if table.channel else ''}",
                head=table.head,
                lines=table.lines,
                note=f"{len(table.lines)} of {table.total} lines" if len(table.lines) < table.total else "",
            )
            for table in graph.tables
        ),
    )
