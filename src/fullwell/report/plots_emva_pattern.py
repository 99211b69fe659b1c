"""The graphs of EMVA 1288 with its axes: spectrograms, profiles and defect histograms (EMVA1288.md 7.6 to 7.9)."""

from functools import partial
from typing import Final

import numpy as np

from fullwell.report.curves import Table
from fullwell.report.drawing import Axes
from fullwell.report.drawing.style import QUIET, LineStyle
from fullwell.report.plots import color_of
from fullwell.report.plots_emva import Legend, finish, named, panel

_LEVELS: Final[tuple[tuple[str, LineStyle], ...]] = (("pattern", "-"), ("temporal", "--"))
_PROFILE: Final = {"DSNU": "Dark value [DN]", "PRNU": "Bright less dark value [DN]"}
_LINES: Final[tuple[tuple[str, LineStyle, float], ...]] = (
    ("middle", "-", 0.7),
    ("mean", "-", 1.5),
    ("maximum", ":", 0.9),
    ("minimum", ":", 0.9),
)


def _spectrogram(table: Table, _legend: Legend, size: tuple[float, float], *, which: str, direction: str) -> bytes:
    figure, axes = panel(size)
    unit = "DN" if which == "DSNU" else "%"
    for channel, part in table.split("channel"):
        name, color = str(channel), color_of(str(channel))
        x, y = part.numbers("frequency"), part.numbers("amplitude")
        axes.plot(x[x > 0.0], y[x > 0.0], color=color, linewidth=0.6, alpha=0.85, label=named(name))
        for column, style in _LEVELS:
            level = part.numbers(column)
            if np.isfinite(level).any():
                value = float(level[np.isfinite(level)][0])
                words = which if column == "pattern" else "temporal noise of one frame"
                label = named(name, f"{words} {value:.3g} {unit}")
                axes.axhline(value, color=color, linewidth=1.0, linestyle=style, label=label)
    axes.set_xlim(0.0, 0.5)
    axes.margins(y=0.12)
    axes.set_yscale("log")
    label = f"Square root of the power [{unit}]"
    title = f"Spectrogram {which}, {direction}"
    return finish(figure, axes, x="Frequency [cycles/pixel]", y=label, title=title, place="upper right")


def _profile(table: Table, _legend: Legend, size: tuple[float, float], *, which: str, direction: str) -> bytes:
    """Draw profiles along a row to the right, those along a column downwards, as one sees them in the image."""
    figure, axes = panel(size)
    along_row = direction == "horizontal"
    for channel, part in table.split("channel"):
        for column, style, width in _LINES:
            line = (part.numbers("index"), part.numbers(column))
            axes.plot(
                *(line if along_row else line[::-1]),
                color=color_of(str(channel)),
                linestyle=style,
                linewidth=width,
                alpha=0.55 if column == "middle" else 1.0,
                label=named(channel, column),
            )
    ends = (0.0, float(np.nanmax(table.numbers("index"))))
    limits = _profile_limits(table, which=which)
    index, value = ("Column [pixel]" if along_row else "Row [pixel]"), _PROFILE[which]
    if along_row:
        axes.set(xlim=ends, ylim=limits)
    else:
        axes.set(xlim=limits, ylim=(ends[1], ends[0]))
    x, y = (index, value) if along_row else (value, index)
    return finish(figure, axes, x=x, y=y, title=f"Profile {which}, {direction}", place="lower right")


def _profile_limits(table: Table, *, which: str) -> tuple[float, float] | None:
    """Return the bounds of the standard: .9 of the lowest mean line to 1.1 of the highest."""
    names = ("minimum", "maximum") if which == "DSNU" else ("mean", "mean")
    means = [tuple(float(np.nanmean(part.numbers(name))) for name in names) for _, part in table.split("channel")]
    low, high = 0.9 * min(one[0] for one in means), 1.1 * max(one[1] for one in means)
    return (low, high) if high > low else None


def _histogram(table: Table, _legend: Legend, size: tuple[float, float], *, which: str) -> bytes:
    figure, axes = panel(size)
    for channel, part in table.split("channel"):
        color, x, y = color_of(str(channel)), part.numbers("deviation"), part.numbers("pixels")
        seen = np.where(y > 0.0, y, np.nan)
        axes.plot(x, seen, color=color, linewidth=0.9, label=named(channel, "pixels"), marker=".", markersize=2.0)
        axes.plot(x, part.numbers("model"), color=color, linewidth=1.0, linestyle="--", label=named(channel, "normal"))
    _log_from_below_one(axes, float(np.nanmax(table.numbers("pixels"))))
    title = f"Logarithmic histogram {which}"
    return finish(figure, axes, x="Deviation from the mean [DN]", y="Pixels per bin", title=title)


def _log_from_below_one(axes: Axes, highest: float) -> None:
    axes.set_ylim(0.5, max(2.0 * highest, 10.0))
    axes.set_yscale("log")


def _accumulated(table: Table, _legend: Legend, size: tuple[float, float], *, which: str) -> bytes:
    figure, axes = panel(size)
    for channel, part in table.split("channel"):
        y = part.numbers("share")
        x = part.numbers("deviation")
        axes.plot(x[y > 0.0], y[y > 0.0], color=color_of(str(channel)), linewidth=1.2, label=named(channel))
    axes.axhline(100.0, color=QUIET, linewidth=0.7, linestyle=":")
    axes.set_xlim(0.0)
    axes.set_yscale("log")
    x_label, title = "Absolute deviation from the mean [DN]", f"Accumulated histogram {which}"
    return finish(figure, axes, x=x_label, y="Pixels in this bin and beyond [%]", title=title)


spectrogram_dsnu_horizontal = partial(_spectrogram, which="DSNU", direction="horizontal")
spectrogram_dsnu_vertical = partial(_spectrogram, which="DSNU", direction="vertical")
spectrogram_prnu_horizontal = partial(_spectrogram, which="PRNU", direction="horizontal")
spectrogram_prnu_vertical = partial(_spectrogram, which="PRNU", direction="vertical")
profile_dsnu_horizontal = partial(_profile, which="DSNU", direction="horizontal")
profile_dsnu_vertical = partial(_profile, which="DSNU", direction="vertical")
profile_prnu_horizontal = partial(_profile, which="PRNU", direction="horizontal")
profile_prnu_vertical = partial(_profile, which="PRNU", direction="vertical")
histogram_dsnu = partial(_histogram, which="DSNU")
histogram_prnu = partial(_histogram, which="PRNU")
accumulated_dsnu = partial(_accumulated, which="DSNU")
accumulated_prnu = partial(_accumulated, which="PRNU")
