"""Every figure against ISO, straight from the rows."""

from collections.abc import Mapping, Sequence
from typing import TypeAlias

import numpy as np

from fullwell.figures.results import Row
from fullwell.raw.cfa import channel_rank
from fullwell.report.drawing import Axes
from fullwell.report.numbers import show_unit
from fullwell.report.plots import (
    Picture,
    beside,
    channel_legend,
    color_of,
    grid_of,
    iso_axis,
    marker_of,
    picture,
)
from fullwell.units import DECIBEL, STOP

Panels: TypeAlias = Mapping[tuple[str, str], Sequence[Row]]
"""Title and unit of each panel with its rows: one figure per ISO and channel."""


def against_iso(panels: Panels, *, alt: str, caption: str) -> Picture:
    """Draw one panel per figure: value with its 95 % interval against ISO, a line per channel."""
    figure, axes = grid_of(len(panels), panel_height_in=2.3)
    channels: set[str] = set()
    for one, ((title, unit), rows) in zip(axes, panels.items(), strict=True):
        _panel(one, rows)
        one.set_title(_wrapped(title))
        one.set_ylabel(f"[{show_unit(unit) or '1'}]")
        iso_axis(one, [row.iso for row in rows if row.iso is not None], label_share=0.11)
        channels |= {row.channel for row in rows}
    channel_legend(figure, channels)
    return picture(figure, alt=alt, caption=caption)


def _wrapped(title: str, longest: int = 30) -> str:
    """Return a title in at most two lines."""
    if len(title) <= longest:
        return title
    cut = title.rfind(" ", 0, longest)
    return f"{title[:cut]}\n{title[cut + 1 :]}" if cut > 0 else title


def _panel(axes: Axes, rows: Sequence[Row]) -> None:
    channels = sorted({row.channel for row in rows}, key=channel_rank)
    for index, channel in enumerate(channels):
        mine = sorted((row for row in rows if row.channel == channel), key=lambda row: row.iso or 0.0)
        iso = beside(np.array([row.iso or 0.0 for row in mine]), index, len(channels))
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
    axes.margins(y=0.15)
    if _spans_decades(rows):
        axes.set_yscale("log")
    else:
        axes.locator_params(axis="y", nbins=5)


def _spans_decades(rows: Sequence[Row]) -> bool:
    """Tell whether the values ask for a logarithmic scale: all clearly positive, eightfold apart, not one already."""
    lowest = min((row.measured.ci95 or (row.measured.value,))[0] for row in rows)
    highest = max(row.measured.value for row in rows)
    return rows[0].measured.unit not in (DECIBEL, STOP) and lowest > 0.0 and highest > 8.0 * lowest
