"""Read noise looked at closely: by the published flows frame by frame, and by region of the frame."""

from collections.abc import Mapping
from typing import Final

import numpy as np

from fullwell.report.curves import Table, Value
from fullwell.report.drawing import key
from fullwell.report.drawing.style import QUIET, Marker
from fullwell.report.plots import (
    Picture,
    canvas,
    channel_legend,
    color_of,
    grid_of,
    iso_axis,
    iso_title,
    marker_of,
    picture,
)

_FLOWS: Final[tuple[tuple[str, str, str, Marker], ...]] = (
    ("flow1", "flow 1: differences", "#b45309", "o"),
    ("flow2", "flow 2: minus the mean", "#1d4ed8", "D"),
)


def published_flows(table: Table) -> Picture:
    """Draw both published flows of every repeat against ISO, and their ratio."""
    figure, (left, right) = canvas(1, 2, height_in=3.2)
    groups = list(table.split("repeat"))
    for index, (_, points) in enumerate(groups):
        iso = points.numbers("iso") * 1.02 ** (index - (len(groups) - 1) / 2.0)
        flows = [points.numbers(name) for name, *_ in _FLOWS]
        for (_, label, color, marker), values in zip(_FLOWS, flows, strict=True):
            name = label if index == 0 else ""
            left.plot(iso, values, linestyle="none", marker=marker, color=color, markerfacecolor="none", label=name)
        ratio = np.divide(*flows, out=np.full_like(iso, np.nan), where=flows[1] > 0.0)
        right.plot(iso, ratio, linestyle="none", marker="o", color=QUIET, markerfacecolor="none")
    count = len(groups)
    if count > 1:
        expected = float(np.sqrt(count / (count - 1)))
        right.axhline(expected, color=QUIET, linewidth=1.0)
        words = f"√({count}/{count - 1}) = {expected:.4f}"
        right.text(0.98, expected, words, x_share=True, offset=(0.0, 3.0), ha="right", color=QUIET)
    left.set(ylabel="Read noise [DN]", title="Published flows, each repeat")
    left.set_ylim(0.0, 1.08 * left.get_ylim()[1])
    right.set(ylabel="Flow 1 / flow 2", title="Their ratio")
    middle = right.get_ylim()
    right.set_ylim(min(middle[0], 0.98), max(middle[1], 1.2))
    for axes in (left, right):
        iso_axis(axes, table.numbers("iso"), label_share=0.07)
    left.legend(loc="upper left")
    return picture(
        figure,
        alt="Read noise by the two published flows, every repeat against ISO, and the ratio of the flows",
        caption=(
            "Read noise as published, every repeat: standard deviation of differences of frames over √2 (flow 1), and "
            "of frames minus their mean (flow 2). The mean of n frames holds a share of each, so flow 2 is low by "
            "√((n−1)/n): the ratio is arithmetic, not a correlation of burst frames."
        ),
    )


def noise_regions(table: Table, p_values: Mapping[Value, float]) -> Picture:
    """Draw read noise by region of the frame, a panel per ISO.

    Parameters
    ----------
    table
        Curve `read_noise_regions`.
    p_values
        Of the test that all regions of a channel have one noise, the channels together, by ISO.

    """
    groups = list(table.split("iso"))
    figure, panels = grid_of(len(groups), panel_height_in=2.35)
    most = 1
    for axes, (iso, part) in zip(panels, groups, strict=True):
        channels = list(part.split("channel"))
        for index, (channel, points) in enumerate(channels):
            order = np.lexsort((points.numbers("x"), points.numbers("y")))
            place = np.arange(1, len(order) + 1) + 0.16 * (index - (len(channels) - 1) / 2.0)
            most = max(most, len(order))
            axes.errorbar(
                place,
                points.numbers("read_noise")[order],
                yerr=np.nan_to_num(points.numbers("std_error")[order]),
                linestyle="none",
                marker=marker_of(str(channel)),
                markersize=3.0,
                color=color_of(str(channel)),
                elinewidth=0.8,
            )
        told = p_values.get(iso)
        title = iso_title(iso if isinstance(iso, (int, float)) else None)
        axes.set_title(title if told is None else f"{title}: p {'< 0.001' if told < 1e-3 else f'= {told:.2g}'}")
        axes.set(xlabel="Region", ylabel="Read noise [DN]")
        axes.locator_params(axis="y", nbins=5)
    for axes in panels:
        axes.set_xticks([place for place in (1, 4, 8, 12, 16) if place <= most] if most == 16 else range(1, most + 1))
    channel_legend(figure, [str(channel) for channel, _ in table.split("channel")], [key("one standard error")])
    return picture(
        figure,
        alt="Read noise in every region of the frame, a panel per ISO, with the probability that all are equal",
        caption=(
            "Read noise by region of the frame, numbered line by line from the top left. p: probability of differences "
            "as large as these if the noise were the same everywhere (all channels together); small where the chip "
            "glows, is warmer on one side, or is read in blocks."
        ),
    )
