"""The graphs of EMVA 1288 with its axes: response, noise and dark current (EMVA1288.md 10.3).

Each function draws one graph with all channels from one curve of one operation point, on a canvas of a given size, and
returns it as SVG.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Final, TypeAlias

import numpy as np
from numpy.typing import NDArray

from fullwell.raw.cfa import MONO
from fullwell.report.curves import Table
from fullwell.report.drawing import Axes, Figure
from fullwell.report.drawing.legend import Place
from fullwell.report.drawing.style import QUIET
from fullwell.report.plots import color_of, marker_of

Array: TypeAlias = NDArray[np.float64]

LARGE: Final = (9.2, 5.0)
"""A graph of the detail pages [inch]."""
SMALL: Final = (4.9, 3.9)
"""A graph of the summary page [inch]."""

_SIGNAL: Final = "Signal − dark signal [DN]"


@dataclass(frozen=True, slots=True, kw_only=True)
class Legend:
    """What stands in a graph's legend per channel, and marks that all channels share.

    Parameters
    ----------
    texts
        Channel and its words.
    marks
        Positions of vertical marks, with their words and channel.

    """

    texts: tuple[tuple[str, str], ...] = ()
    marks: tuple[tuple[str, str, float], ...] = ()

    def text(self, channel: str) -> str:
        """Return the words of a channel, its name where there are none."""
        return named(channel, dict(self.texts).get(channel, ""))


Draw: TypeAlias = Callable[[Table, Legend, tuple[float, float]], bytes]


def panel(size: tuple[float, float]) -> tuple[Figure, Axes]:
    """Return a figure with one panel."""
    figure = Figure(size)
    return figure, figure.subplots()[0]


def abscissa(table: Table) -> tuple[Array, str]:
    """Return photons with the axis's label, exposure times where no photons are known."""
    photons = table.numbers("photons")
    if np.isfinite(photons).any():
        return photons, "Irradiation [photons/pixel]"
    return table.numbers("exposure_s"), "Exposure time [s]"


def points(axes: Axes, x: Array, y: Array, channel: str, *, label: str = "", hollow: bool = False) -> None:
    """Draw the measured points of a channel."""
    axes.plot(
        x,
        y,
        linestyle="none",
        marker=marker_of(channel),
        markersize=3.4,
        color=color_of(channel),
        fillstyle="none" if hollow else "full",
        markeredgewidth=0.8,
        label=label,
    )


def named(channel: object, words: str = "") -> str:
    """Return an entry of the legend; a monochrome sensor's channel needs no name."""
    if channel == MONO:
        return words
    return f"{channel}: {words}" if words else str(channel)


def finish(figure: Figure, axes: Axes, *, x: str, y: str, title: str, place: Place = "best") -> bytes:
    """Label the axes and return the drawing."""
    axes.set(xlabel=x, ylabel=y)
    axes.set_title(title)
    axes.legend(loc=place, size=7.5)
    return figure.svg()


def characteristic(table: Table, legend: Legend, size: tuple[float, float]) -> bytes:
    """Draw signal against irradiation with the line of the responsivity and the range of its fit."""
    figure, axes = panel(size)
    label = ""
    for channel, part in table.split("channel"):
        x, label = abscissa(part)
        points(axes, x, part.numbers("signal"), str(channel), label=legend.text(str(channel)))
        axes.plot(x, part.numbers("fitted"), color=color_of(str(channel)), linewidth=1.0)
        _range_marks(axes, x, part.numbers("in_range"))
    return finish(figure, axes, x=label, y=_SIGNAL, title="Characteristic curve")


def dark_mean(table: Table, _legend: Legend, size: tuple[float, float]) -> bytes:
    """Draw the mean dark value against exposure time."""
    figure, axes = panel(size)
    for channel, part in table.split("channel"):
        measured = part.numbers("measured") > 0.0
        x, y = part.numbers("exposure_s"), part.numbers("dark_mean")
        points(axes, x[measured], y[measured], str(channel), label=named(channel, "measured"))
        if (~measured).any():
            points(
                axes, x[~measured], y[~measured], str(channel), label=named(channel, "by the dark line"), hollow=True
            )
    return finish(figure, axes, x="Exposure time [s]", y="Mean dark value [DN]", title="Dark signal")


def stability(table: Table, _legend: Legend, size: tuple[float, float]) -> bytes:
    """Draw temporal noise and the difference of the two means against signal."""
    figure, axes = panel(size)
    for channel, part in table.split("channel"):
        x = part.numbers("signal")
        points(axes, x, part.numbers("noise"), str(channel), label=named(channel, "temporal noise"))
        name = named(channel, "difference of means")
        points(axes, x, part.numbers("mean_difference"), str(channel), label=name, hollow=True)
    axes.axhline(0.0, color=QUIET, linestyle="--", linewidth=0.9)
    return finish(figure, axes, x=_SIGNAL, y="Noise, difference of means [DN]", title="Stability")


def photon_transfer(table: Table, legend: Legend, size: tuple[float, float]) -> bytes:
    """Draw temporal variance less that of the dark against signal, with line, fit range and saturation."""
    figure, axes = panel(size)
    for channel, part in table.split("channel"):
        name = str(channel)
        x, y = part.numbers("signal"), part.numbers("variance")
        points(axes, x, y, name, label=legend.text(name))
        inside = part.numbers("in_range") > 0.0
        axes.plot(x, part.numbers("fitted"), color=color_of(name), linewidth=1.0, linestyle=":")
        axes.plot(x[inside], part.numbers("fitted")[inside], color=color_of(name), linewidth=1.2)
        _range_marks(axes, x, part.numbers("in_range"))
        full = part.numbers("saturation") > 0.0
        axes.plot(x[full], y[full], linestyle="none", marker="*", markersize=10.0, color=color_of(name))
    _above_zero(axes, table.numbers("variance"))
    return finish(
        figure, axes, x=_SIGNAL, y="Variance − dark variance [DN²]", title="Photon transfer", place="upper left"
    )


def _above_zero(axes: Axes, values: Array) -> None:
    """End the ordinate at what is measured: lines go on beyond."""
    known = values[np.isfinite(values)]
    if known.size and known.max() > 0.0:
        axes.set_ylim(min(0.0, 1.05 * float(known.min())), 1.12 * float(known.max()))


def _range_marks(axes: Axes, x: Array, inside: Array) -> None:
    """Mark both ends of a fit's range."""
    chosen = x[(inside > 0.0) & np.isfinite(x)]
    if chosen.size:
        for end in (chosen.min(), chosen.max()):
            axes.axvline(float(end), color=QUIET, linestyle="--", linewidth=0.9)


def snr(table: Table, legend: Legend, size: tuple[float, float], *, models: Table | None = None) -> bytes:
    """Draw the signal-to-noise ratio, measured and by the models, with the thresholds."""
    figure, axes = panel(size)
    label = ""
    for channel, part in table.split("channel"):
        name = str(channel)
        x, label = abscissa(part)
        for column, words, hollow in (("snr", "temporal", False), ("snr_total", "total", True)):
            y = part.numbers(column)
            lit = (x > 0.0) & (y > 0.0)
            points(axes, x[lit], y[lit], name, label=named(name, words), hollow=hollow)
    if models is not None:
        _snr_models(axes, models)
    _snr_limits(axes, table, models)
    for name, words, at in legend.marks:
        axes.axvline(at, color=color_of(name), linestyle="--", linewidth=0.9)
        axes.text(at, 0.02, words, y_share=True, offset=(-2.0, 0.0), rotation=90.0, size=7.0, color=QUIET)
    axes.set_xscale("log")
    axes.set_yscale("log")
    return finish(figure, axes, x=label, y="SNR", title="Signal-to-noise ratio", place="upper left")


def _snr_models(axes: Axes, models: Table) -> None:
    for at, (channel, part) in enumerate(models.split("channel")):
        color = color_of(str(channel))
        x = part.numbers("photons")
        axes.plot(x, part.numbers("snr"), color=color, linewidth=1.0, label=named(channel, "model"))
        total = named(channel, "model, total")
        axes.plot(x, part.numbers("snr_total"), color=color, linewidth=1.0, linestyle="-.", label=total)
        if at == 0:
            axes.plot(x, part.numbers("ideal"), color=QUIET, linewidth=0.9, linestyle=":", label="ideal sensor")


def _snr_limits(axes: Axes, table: Table, models: Table | None) -> None:
    """Begin the ordinate at 1 and end both axes a little beyond what is measured."""
    x, _ = abscissa(table)
    y = table.numbers("snr")
    lit = (x > 0.0) & (y > 0.0)
    if not lit.any():
        return
    low = float(x[lit].min())
    if models is not None:
        low = min(low, float(np.nanmin(models.numbers("photons"))))
    axes.set_xlim(0.8 * low, 2.0 * float(x[lit].max()))
    axes.set_ylim(1.0, 3.0 * float(y[lit].max()))


def linearity(table: Table, _legend: Legend, size: tuple[float, float]) -> bytes:
    """Draw signal against irradiation with the weighted line between 5 and 95 %."""
    figure, axes = panel(size)
    label = ""
    for channel, part in table.split("channel"):
        name = str(channel)
        x, label = abscissa(part)
        points(axes, x, part.numbers("signal"), name, label=named(name, "measured"))
        axes.plot(x, part.numbers("fitted"), color=color_of(name), linewidth=1.0, label=named(name, "line, 5 to 95 %"))
        _range_marks(axes, x, part.numbers("in_range"))
    return finish(figure, axes, x=label, y=_SIGNAL, title="Linearity")


def deviation(table: Table, _legend: Legend, size: tuple[float, float]) -> bytes:
    """Draw the relative deviation from that line between 5 and 95 %."""
    figure, axes = panel(size)
    label = ""
    for channel, part in table.split("channel"):
        name = str(channel)
        inside = part.numbers("in_range") > 0.0
        x, label = abscissa(part)
        y, error = part.numbers("deviation"), part.numbers("deviation_std_error")
        points(axes, x[inside], y[inside], name, label=named(name))
        known = inside & np.isfinite(error)
        axes.errorbar(x[known], y[known], yerr=error[known], linestyle="none", color=color_of(name), elinewidth=0.8)
    axes.axhline(0.0, color=QUIET, linestyle="--", linewidth=0.9)
    return finish(figure, axes, x=label, y="Deviation from linearity [%]", title="Deviation from linearity")


def dark_current_mean(table: Table, legend: Legend, size: tuple[float, float]) -> bytes:
    """Draw the mean dark value against exposure time with its line."""
    title = "Dark current from the mean"
    return _dark_line(table, legend, size, column="dark_mean", y="Mean dark value [DN]", title=title)


def dark_current_variance(table: Table, legend: Legend, size: tuple[float, float]) -> bytes:
    """Draw the temporal dark variance against exposure time with its line."""
    title = "Dark current from the variance"
    return _dark_line(table, legend, size, column="dark_variance", y="Dark variance [DN²]", title=title)


def _dark_line(table: Table, legend: Legend, size: tuple[float, float], *, column: str, y: str, title: str) -> bytes:
    figure, axes = panel(size)
    for channel, part in table.split("channel"):
        name = str(channel)
        x = part.numbers("exposure_s")
        points(axes, x, part.numbers(column), name, label=legend.text(name))
        axes.plot(x, part.numbers(f"{column}_fitted"), color=color_of(name), linewidth=1.0)
    return finish(figure, axes, x="Exposure time [s]", y=y, title=title)
