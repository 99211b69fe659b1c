"""Rows in DN told again in electrons (where the system gain was measured) and volts (where a swing was given)."""

from collections.abc import Iterable
from dataclasses import replace

from fullwell.figures.conversions import to_electrons, to_volts
from fullwell.figures.results import Row
from fullwell.glossary import RECOMMENDED
from fullwell.raw.cfa import ALL
from fullwell.units import DN, DN_PER_SECOND
from fullwell.workflow.measure.levels import ChannelLevels
from fullwell.workflow.measure.section import Section

_IN_DN = {DN, DN_PER_SECOND}
_INPUT_REFERRED = {
    "read_noise",
    "read_noise_variance",
    "read_noise_row",
    "read_noise_row_variance",
    "read_noise_column",
    "read_noise_column_variance",
    "dark_current",
    *(f"dsnu{part}{twin}" for part in ("", "_row", "_column", "_pixel") for twin in ("", "_variance")),
}
_IN_VOLTS = {"read_noise", "dark_current", "dsnu"}


def rows_in_electrons(rows: Iterable[Row], gain_rows: Iterable[Row]) -> Section:
    """Return the convertible rows in electrons; a misfit of the system gain is a misfit of what rests on it.

    Parameters
    ----------
    rows
        Rows of one ISO in DN.
    gain_rows
        The recommended rows of the system gain, ``all`` included where it was pooled.

    """
    known = {row.channel: row for row in gain_rows if row.quantity == "system_gain" and RECOMMENDED in row.flags}
    converted: list[Row] = []
    for row in rows:
        by = known.get(row.channel)
        if by is not None and row.quantity in _INPUT_REFERRED:
            inherited = {"model-misfit"} & set(by.flags)
            converted.append(
                replace(
                    row,
                    measured=to_electrons(row.measured, by.measured),
                    flags=tuple(sorted({*row.flags, *inherited})),
                    source=f"{row.source}; METHOD 0",
                )
            )
    return Section(rows=tuple(converted))


def rows_in_volts(rows: Iterable[Row], levels: Iterable[ChannelLevels], swing_v: float | None) -> Section:
    """Return read noise and dark current in volts: DN * swing / digital maximum, labelled model-based."""
    if swing_v is None:
        return Section()
    known = {level.channel: level.digital_maximum_dn for level in levels if level.digital_maximum_dn}
    if len(known) > 1:
        known[ALL] = max(known.values())
    converted: list[Row] = []
    for row in rows:
        maximum_dn = known.get(row.channel)
        if maximum_dn is not None and row.measured.unit in _IN_DN and row.quantity in _IN_VOLTS:
            converted.append(
                replace(
                    row,
                    measured=to_volts(row.measured, swing_v / maximum_dn),
                    flags=tuple(sorted({*row.flags, "model-based"})),
                    source=f"{row.source}; voltage swing",
                )
            )
    return Section(rows=tuple(converted))
