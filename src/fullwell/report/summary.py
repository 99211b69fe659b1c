"""The first page: key figures as cards, and as a table of every ISO and channel."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

from fullwell import glossary
from fullwell.figures.results import Row, at_main_temperature
from fullwell.raw.cfa import channel_rank, leading_channel
from fullwell.report.numbers import show, show_iso, show_unit
from fullwell.report.pivots import Cell, Line, describe_flag, title_of, tooltip

# quantity and its units, the one to show first
_KEY_FIGURES: Final = (
    ("read_noise", ("e-", "DN")),
    ("dynamic_range", ("dB", "EV")),
    ("saturation_capacity", ("e-", "DN")),
    ("snr_max", ("dB", "1")),
    ("system_gain", ("DN/e-",)),
    ("dark_current", ("e-/s", "DN/s")),
    ("black_level", ("DN",)),
    ("prnu", ("%",)),
    ("dsnu", ("e-", "DN")),
)
_SPARK_WIDTH: Final = 120.0
_SPARK_HEIGHT: Final = 34.0


@dataclass(frozen=True, slots=True, kw_only=True)
class Spark:
    """A line of the little picture in a card: the points of an SVG polyline."""

    channel: str
    points: str


@dataclass(frozen=True, slots=True, kw_only=True)
class Card:
    """One key figure at the lowest ISO, with a little picture of how it goes with ISO."""

    quantity: str
    title: str
    value: str
    unit: str
    where: str
    tooltip: str
    flags: tuple[str, ...]
    sparks: tuple[Spark, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class Heading:
    """Head of a column of the summary table."""

    quantity: str
    title: str
    unit: str


@dataclass(frozen=True, slots=True, kw_only=True)
class IsoBlock:
    """All channels of one ISO."""

    iso: str
    lines: tuple[Line, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class Summary:
    """The first page."""

    cards: tuple[Card, ...]
    headings: tuple[Heading, ...]
    blocks: tuple[IsoBlock, ...]


def summarize(rows: Sequence[Row]) -> Summary:
    """Return the first page from the recommended rows."""
    main = at_main_temperature(rows)
    chosen = [found for quantity, units in _KEY_FIGURES if (found := _best_unit(main, quantity, units))]
    cards = tuple(_card(mine) for mine in chosen)
    columns = [{(row.iso, row.channel): row for row in reversed(mine)} for mine in chosen]
    isos = sorted({iso for column in columns for iso, _ in column}, key=lambda iso: -1.0 if iso is None else iso)
    blocks = tuple(_block(columns, iso) for iso in isos)
    headings = tuple(
        Heading(
            quantity=mine[0].quantity, title=title_of(mine[0].quantity), unit=show_unit(mine[0].measured.unit) or "1"
        )
        for mine in chosen
    )
    return Summary(cards=cards, headings=headings, blocks=blocks)


def _best_unit(rows: Sequence[Row], quantity: str, units: Sequence[str]) -> list[Row]:
    """Return the rows of a quantity in the first unit it has, the lowest threshold first."""
    for unit in units:
        if mine := [row for row in rows if (row.quantity, row.measured.unit) == (quantity, unit)]:
            return sorted(mine, key=lambda row: (row.iso or 0.0, row.snr_threshold or 0.0, channel_rank(row.channel)))
    return []


def _card(mine: Sequence[Row]) -> Card:
    lowest = [row for row in mine if row.iso == mine[0].iso]
    leading = leading_channel(row.channel for row in lowest)
    lead = next(row for row in lowest if row.channel == leading)
    channel = {"all": "all channels", "mono": ""}.get(lead.channel, lead.channel)
    entry = glossary.quantity(lead.quantity)
    definition = f"{entry.definition} " if entry else ""
    return Card(
        quantity=lead.quantity,
        title=title_of(lead.quantity),
        value=show(lead.measured, lead.flags),
        unit=show_unit(lead.measured.unit),
        where=", ".join(part for part in (show_iso(lead.iso), channel) if part),
        tooltip=f"{definition}{tooltip(lead)}",
        flags=tuple(flag for flag in lead.flags if flag != glossary.RECOMMENDED),
        sparks=_sparks(mine),
    )


def _sparks(mine: Sequence[Row]) -> tuple[Spark, ...]:
    """Return one polyline per channel over equally spaced ISOs; nothing for fewer than two ISOs."""
    isos = sorted({row.iso for row in mine if row.iso is not None})
    values = [row.measured.value for row in mine]
    if len(isos) < 2:
        return ()
    low, high = min(values), max(values)
    span = (high - low) or 1.0
    lines: list[Spark] = []
    for channel in sorted({row.channel for row in mine}, key=channel_rank):
        seen = {row.iso: row.measured.value for row in reversed(mine) if row.channel == channel}
        points = " ".join(
            f"{2.0 + (_SPARK_WIDTH - 4.0) * index / (len(isos) - 1):.1f},"
            f"{3.0 + (_SPARK_HEIGHT - 6.0) * (1.0 - (seen[iso] - low) / span):.1f}"
            for index, iso in enumerate(isos)
            if iso in seen
        )
        lines.append(Spark(channel=channel, points=points))
    return tuple(lines)


def _block(columns: Sequence[dict[tuple[float | None, str], Row]], iso: float | None) -> IsoBlock:
    channels = sorted({channel for column in columns for at, channel in column if at == iso}, key=channel_rank)
    lines = tuple(
        Line(label=channel, cells=tuple(_cell(column.get((iso, channel))) for column in columns))
        for channel in channels
    )
    return IsoBlock(iso=show_iso(iso), lines=lines)


def _cell(row: Row | None) -> Cell:
    if row is None:
        return Cell(text="")
    told = [describe_flag(flag) for flag in row.flags if flag != glossary.RECOMMENDED]
    return Cell(text=show(row.measured, row.flags), title="; ".join([tooltip(row), *told]), marks="†" if told else "")
