"""A result is a row: one figure of merit with its uncertainty, method and source."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import cast

from fullwell.findings import Finding
from fullwell.units import Measured


@dataclass(frozen=True, slots=True, kw_only=True)
class Row:
    """One figure of merit.

    Parameters
    ----------
    quantity, channel, method
        Names of RESULTS section 2; the glossary lists them.
    measured
        Value, unit, standard error, degrees of freedom, 95 % interval.
    n
        Pixel values used.
    iso, exposure_s, temperature_c, region, snr_threshold
        What the figure belongs to; None where it does not apply.
    flags
        In sorted order.
    source
        Citation key and equation, for example ``"METHOD 3.1"``.

    """

    quantity: str
    channel: str
    method: str
    measured: Measured
    n: int | None = None
    iso: float | None = None
    exposure_s: float | None = None
    temperature_c: float | None = None
    region: str | None = None
    snr_threshold: float | None = None
    flags: tuple[str, ...] = ()
    source: str = ""


def at_main_temperature(rows: Iterable[Row]) -> tuple[Row, ...]:
    """Return the rows of each ISO at the temperature that its first row names, and those that name none.

    An ISO is measured at one temperature; figures at others follow, and are theirs alone.
    """
    every = tuple(rows)
    main = {row.iso: row.temperature_c for row in reversed(every) if row.temperature_c is not None}
    return tuple(row for row in every if row.temperature_c in {None, main.get(row.iso)})


@dataclass(frozen=True, slots=True, kw_only=True)
class Column:
    """One column of a curve: what is plotted, with its unit."""

    name: str
    unit: str
    values: tuple[float | int | str | None, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class Curve:
    """A table of plotted points, named as in ``curves`` of results.json."""

    name: str
    columns: tuple[Column, ...]

    def column(self, name: str) -> tuple[float | int | str | None, ...]:
        """Return the values of one column."""
        return next(column.values for column in self.columns if column.name == name)


@dataclass(frozen=True, slots=True, kw_only=True)
class Results:
    """Everything a run found: the document behind results.json, the tables and the report.

    Parameters
    ----------
    study
        What was read: files with content hashes, settings, levels, exclusions (JSON-ready).
    rows
        Every figure, in a fixed order.
    findings
        What is to be said about the data, most severe first.
    curves
        What is plotted.
    citations
        The bibliography that sources refer to by key (JSON-ready).
    run
        All that may differ between two runs on the same input (JSON-ready).

    """

    study: Mapping[str, object]
    rows: tuple[Row, ...]
    findings: tuple[Finding, ...]
    curves: tuple[Curve, ...]
    citations: tuple[Mapping[str, str], ...] = ()
    run: Mapping[str, object] = field(default_factory=dict[str, object])

    @property
    def code_bits(self) -> int | None:
        """Bits of a code as declared: of the white level where files hold wider numbers, None where nobody says."""
        held = self.study.get("bit_depth")
        declared = self.study.get("white_level")
        values = declared.get("values") if isinstance(declared, Mapping) else None
        levels = [level for level in cast("Sequence[object]", values or ()) if isinstance(level, (int, float))]
        told = [int(max(levels)).bit_length()] if levels else []
        return min([*told, *([held] if isinstance(held, int) else [])], default=None)
