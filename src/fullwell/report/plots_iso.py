"""Every figure against ISO, straight from the rows."""

from collections.abc import Mapping, Sequence
from typing import TypeAlias

from matplotlib.axes import Axes

from fullwell import glossary
from fullwell.figures.results import Row
from fullwell.report.numbers import show_unit
from fullwell.report.plots import (
    Picture,
    channel_legend,
    color_of,
    grid_of,
    iso_axis,
    marker_of,
    vector_picture,
)

Panels: TypeAlias = Mapping[tuple[str, str], Sequence[Row]]
"""Rows of one (quantity, unit), several ISOs and channels."""


def against_iso(panels: Panels, *, alt: str, caption: str) -> Picture:
    """Draw one panel per quantity and unit: value with its 95 % interval against ISO, a line per channel."""
    figure, axes = grid_of(len(panels), panel_height_in=2.3)
    channels: set[str] = set()
    for one, ((quantity, unit), rows) in zip(axes, panels.items(), strict=True):
        _panel(one, rows)
        entry = glossary.quantity(quantity)
        title = entry.title if entry else quantity
        one.set_title(_wrapped(title))
        one.set_ylabel(f"[{show_unit(unit) or '1'}]")
        iso_axis(one, [row.iso for row in rows if row.iso is not None])
        channels |= {row.channel for row in rows}
    channel_legend(figure, channels)
    return vector_picture(figure, alt=alt, caption=caption)


def _wrapped(title: str, longest: int = 34) -> str:
    """Return a title in at most two lines."""
    if len(title) <= longest:
        return title
    cut = title.rfind(" ", 0, longest)
    return f"{title[:cut]}\n{title[cut + 1 :]}" if cut > 0 else title


def _panel(axes: Axes, rows: Sequence[Row]) -> None:
    for channel in dict.fromkeys(row.channel for row in rows):
        mine = sorted((row for row in rows if row.channel == channel), key=lambda row: row.iso or 0.0)
        iso = [row.iso or 0.0 for row in mine]
        value = [row.measured.value for row in mine]
        ends = [row.measured.ci95 or (row.measured.value, row.measured.value) for row in mine]
        lower = [max(one - low, 0.0) for one, (low, _) in zip(value, ends, strict=True)]
        upper = [max(high - one, 0.0) for one, (_, high) in zip(value, ends, strict=True)]
        axes.errorbar(
            iso,
            value,
            yerr=(lower, upper),
            color=color_of(channel),
            marker=marker_of(channel),
            markersize=3.5,
            linewidth=0.9,
            elinewidth=0.9,
        )
    axes.locator_params(axis="y", nbins=5)
    axes.margins(y=0.15)
