"""What a datasheet holds, page after page."""

from dataclasses import dataclass


@dataclass(frozen=True, slots=True, kw_only=True)
class Fact:
    """A label with its text; ``stated`` is False where nobody said it."""

    label: str
    text: str
    stated: bool = True


@dataclass(frozen=True, slots=True, kw_only=True)
class ItemLine:
    """One figure of the summary.

    Parameters
    ----------
    symbol
        Symbol as marked-up text: ``_{...}`` below, ``^{...}`` above.
    value
        To the decimals of the standard's template; a limit where only that is known; a dash where missing.
    error
        One standard error, empty where unknown.
    unit
        As people write it.
    note
        Mark of a footnote, empty where none.

    """

    symbol: str
    value: str
    error: str
    unit: str
    note: str = ""


@dataclass(frozen=True, slots=True, kw_only=True)
class ItemGroup:
    """The figures under one heading of the summary."""

    title: str
    lines: tuple[ItemLine, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class FigureLine:
    """One row of the results in full."""

    title: str
    method: str
    value: str
    error: str
    interval: str
    dof: str
    unit: str
    flags: str


@dataclass(frozen=True, slots=True, kw_only=True)
class DataTable:
    """The data of a graph of one channel, thinned where long.

    Parameters
    ----------
    channel
        Empty for a monochrome sensor.
    head
        Names of the columns with their units.
    lines
        Cells as text.
    total
        Lines before thinning.

    """

    channel: str
    head: tuple[str, ...]
    lines: tuple[tuple[str, ...], ...]
    total: int


@dataclass(frozen=True, slots=True, kw_only=True)
class Graph:
    """One graph of the detail pages with its data.

    Parameters
    ----------
    name
        Identifier, ``photon-transfer`` for example.
    title, caption
        What it shows, in words.
    drawing
        SVG; empty where there are no data.
    tables
        One a channel.
    missing
        Why there are no data; empty otherwise.

    """

    name: str
    title: str
    caption: str
    drawing: bytes
    tables: tuple[DataTable, ...]
    missing: str = ""


@dataclass(frozen=True, slots=True, kw_only=True)
class ChannelSummary:
    """The figures of one channel at one operation point.

    Parameters
    ----------
    channel
        Name of the channel.
    groups
        In the order of the standard's template.
    beside
        The same figures with the attenuation of the high-pass divided out; empty for other profiles.
    notes
        Footnotes: mark and text.
    reasons
        What the footnotes say, flag by flag, each once.
    figures
        Every row in full, for the detail pages.

    """

    channel: str
    groups: tuple[ItemGroup, ...]
    beside: tuple[ItemGroup, ...]
    notes: tuple[tuple[str, str], ...]
    reasons: tuple[str, ...]
    figures: tuple[FigureLine, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class OperationPoint:
    """One operation point.

    Parameters
    ----------
    title
        ISO and temperature.
    facts
        The block on the left of the summary page.
    channels
        One summary page each.
    small
        Photon transfer and SNR as the summary pages show them (SVG).
    graphs
        Of the detail pages.

    """

    title: str
    facts: tuple[Fact, ...]
    channels: tuple[ChannelSummary, ...]
    small: tuple[bytes, ...]
    graphs: tuple[Graph, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class Missing:
    """Something that the standard asks for and that these data do not hold."""

    item: str
    reason: str


@dataclass(frozen=True, slots=True, kw_only=True)
class Datasheet:
    """The whole datasheet.

    Parameters
    ----------
    camera
        Name on the cover.
    profile, release
        Profile identifier, and the text of the standard that it follows.
    date, company
        As stated.
    equipment, basic
        The general page.
    missing
        Mandatory items that are missing, with reasons.
    findings
        What the evaluation has to say, as sentences.
    points
        Operation points.
    thinning
        The rule by which long tables are thinned.

    """

    camera: str
    profile: str
    release: str
    date: str
    company: str
    equipment: tuple[Fact, ...]
    basic: tuple[Fact, ...]
    missing: tuple[Missing, ...]
    findings: tuple[str, ...]
    points: tuple[OperationPoint, ...]
    thinning: str
