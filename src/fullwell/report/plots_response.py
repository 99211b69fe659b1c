"""Response against exposure, and histograms of lit frames."""

import numpy as np

from fullwell.report.curves import Table, Value
from fullwell.report.drawing import Axes, Figure, key
from fullwell.report.drawing.style import QUIET
from fullwell.report.plots import (
    WIDTH_IN,
    Picture,
    channel_legend,
    color_of,
    iso_title,
    marker_of,
    picture,
    stepped,
)


def exposure_series(response: Table | None, histograms: Table | None, iso: Value) -> Picture:
    """Draw response and deviation against exposure, and the histograms of the series, for one ISO."""
    parts = [part for part in (response, histograms) if part is not None]
    figure = Figure((WIDTH_IN, 2.9 * len(parts) + 0.2))
    grid = figure.grid(len(parts), 2)
    if response is not None:
        _response(grid.axes(0, 0), grid.axes(0, 1), response)
    if histograms is not None:
        _histograms(grid.axes(len(parts) - 1, 0, columns=2), histograms)
    channels = {str(channel) for part in parts for channel, _ in part.split("channel")}
    channel_legend(figure, channels, [key("proportional")] if response is not None else [])
    return picture(
        figure,
        alt=f"Exposure series at {iso_title(iso)}: response, deviation from proportionality, histograms",
        caption=(
            f"Exposure series at {iso_title(iso)}. "
            + ("Top: mean signal against exposure time and how far it lies off proportion. " if response else "")
            + ("Histogram of each exposure: a peak per channel moves right with the light; " if histograms else "")
            + ("a spike at the right end is saturation." if histograms else "")
        ).strip(),
    )


def _response(main: Axes, rest: Axes, table: Table) -> None:
    for channel, points in table.split("channel"):
        exposure, color, marker = points.numbers("exposure_s"), color_of(str(channel)), marker_of(str(channel))
        order = np.argsort(exposure)
        main.plot(exposure, points.numbers("signal"), linestyle="none", marker=marker, color=color)
        main.plot(exposure[order], points.numbers("fitted")[order], color=color, linewidth=1.0)
        rest.plot(
            exposure[order],
            points.numbers("deviation")[order],
            linestyle=":",
            linewidth=0.9,
            marker=marker,
            color=color,
        )
    for axes in (main, rest):
        axes.set_xscale("log")
        axes.set_xlabel("Exposure time [s]")
    main.set_yscale("log")
    main.set_ylabel("Signal above black [DN]")
    main.set_title("Response")
    rest.axhline(0.0, color=QUIET, linewidth=0.8)
    rest.set_ylabel("Deviation [%]")
    rest.set_title("Deviation from proportionality")
    low, high = rest.get_ylim()
    rest.set_ylim(min(low, -0.2), max(high, 0.2))


def _histograms(axes: Axes, table: Table) -> None:
    for channel, part in table.split("channel"):
        for _, points in part.split("exposure_s"):
            codes, counts = stepped(points.numbers("code"), points.numbers("count"))
            axes.plot(codes, counts, drawstyle="steps-mid", color=color_of(str(channel)), linewidth=0.9, alpha=0.85)
    axes.set_yscale("log")
    axes.set(xlabel="Raw value [DN]", ylabel="Pixel values")
    axes.set_title("Histograms, every exposure")
    axes.margins(x=0.01)
