"""The loop closed, as it is drawn: photon transfer beside the original, pulls, and how often intervals hold."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from fullwell.report.curves import Table, Value
from fullwell.report.drawing import Axes, key
from fullwell.report.drawing.style import INK
from fullwell.report.loop_figures import Together
from fullwell.report.pivots import title_of
from fullwell.report.plots import (
    DENSE,
    Picture,
    canvas,
    channel_legend,
    color_of,
    finite_range,
    iso_title,
    marker_of,
    picture,
)

_TRUTH = "#c3cbd4"
_NAMES = {"original": "Original", "simulated": "Simulated and measured again"}


def transfer_beside(table: Table, iso: Value) -> Picture:
    """Draw noise against signal of the original and of the simulated camera on the same axes, with the true noise."""
    shown = [name for name in _NAMES if name in table.values("whose")]
    figure, panels = canvas(1, len(shown), height_in=3.9)
    truth = _of(table, "truth")
    limits = [finite_range(table.numbers(name), positive=True) for name in ("signal", "variance")]
    channels = sorted({str(channel) for channel in table.values("channel")} - {"all"})
    for axes, name in zip(panels, shown, strict=True):
        axes.plot(truth.numbers("signal"), np.sqrt(truth.numbers("variance")), color=_TRUTH, linewidth=4.5, zorder=1.5)
        for channel, points in _of(table, name).split("channel"):
            _points(axes, points, str(channel))
        if limits[0] and limits[1]:
            axes.set_xlim(limits[0][0] / 1.5, limits[0][1] * 1.5)
            axes.set_ylim(np.sqrt(limits[1][0]) / 1.4, np.sqrt(limits[1][1]) * 1.4)
        axes.set_xscale("log")
        axes.set_yscale("log")
        axes.set(xlabel="Signal above black [DN]", ylabel="Noise [DN]")
        axes.set_title(_NAMES[name])
    channel_legend(figure, channels, [key("truth of the simulation", color=_TRUTH)])
    return picture(
        figure,
        alt=f"Noise against signal at {iso_title(iso)}: {' beside '.join(_NAMES[name].lower() for name in shown)}",
        caption=(
            f"Photon transfer at {iso_title(iso)}. Points: noise against signal"
            f"{', as first measured (left) and of the simulated camera (right)' if len(shown) > 1 else ''}; grey line: "
            "the noise that the simulation was given. "
            + (
                "The two panels have the same axes: what the original shows and the simulation does not is what the "
                "model of the camera leaves out."
                if len(shown) > 1
                else "Points that lie on the line are measured as they were made."
            )
        ),
    )


def _of(table: Table, whose: str) -> Table:
    return table.chosen(value == whose for value in table.values("whose"))


def _points(axes: Axes, points: Table, channel: str) -> None:
    variance = points.numbers("variance")
    dense = len(points) > DENSE
    good = variance > 0.0
    axes.plot(
        points.numbers("signal")[good],
        np.sqrt(variance[good]),
        linestyle="none",
        marker=marker_of(channel),
        markerfacecolor="none",
        color=color_of(channel),
        markersize=3.0 if dense else 4.5,
        markeredgewidth=0.9,
        zorder=2.5,
        dense=dense,
    )


def pulls(table: Table) -> Picture:
    """Draw the distribution of all pulls beside the normal one, and their quantiles against normal quantiles."""
    from scipy.special import ndtri  # noqa: PLC0415 - loads when used

    figure, (left, right) = canvas(1, 2, height_in=3.7)
    every = table.numbers("pull")
    groups = list(table.split("quantity"))
    share = np.concatenate([part.numbers("of") / len(part) for _, part in groups])
    order = np.concatenate([part.numbers("pull") for _, part in groups])
    _histogram(left, order, share)
    reach = max(3.3, 1.1 * float(np.abs(every).max()))
    for _, part in groups:
        right.plot(ndtri(part.numbers("probability")), part.numbers("pull"), color="#8fa3b8", linewidth=0.9, alpha=0.8)
    right.plot([-reach, reach], [-reach, reach], color=INK, linestyle="--", linewidth=0.9)
    right.set(xlabel="Quantile of the normal distribution", ylabel="Pull", xlim=(-3.6, 3.6), ylim=(-reach, reach))
    right.set_title("Every quantity against the normal distribution")
    total = int(sum(part.numbers("of")[0] for _, part in groups))
    figure.legend([key("standard normal", linestyle="--"), key("one quantity", color="#8fa3b8")])
    return picture(
        figure,
        alt="Histogram of pulls with the standard normal curve, and a quantile plot with a line per quantity",
        caption=(
            f"{total} pulls of the recommended figures: error over standard error, each put on the scale of a normal "
            "number by its degrees of freedom. Honest errors give the dashed line. A line that is steeper has errors "
            "that are too small, one that is flatter too large, one that is shifted a bias."
        ),
    )


def _histogram(axes: Axes, values: NDArray[np.float64], weights: NDArray[np.float64]) -> None:
    bins = np.linspace(-4.5, 4.5, 46)
    density, _ = np.histogram(np.clip(values, bins[0], bins[-1]), bins=bins, weights=weights, density=True)
    axes.fill(np.repeat(bins, 2), np.concatenate([[0.0], np.repeat(density, 2), [0.0]]), color="#b7c7d8", zorder=2.0)
    grid = np.linspace(-4.5, 4.5, 181)
    axes.plot(grid, np.exp(-0.5 * grid**2) / np.sqrt(2.0 * np.pi), color=INK, linestyle="--", linewidth=1.1, zorder=3.0)
    axes.set(xlabel="Pull", ylabel="Density", xlim=(-4.5, 4.5), ylim=(0.0, None))
    axes.set_title("All pulls")


def coverage(lines: Sequence[Together]) -> Picture | None:
    """Draw how often 95 % intervals hold the truth, a line per quantity; None without intervals."""
    shown = [(one, found) for one in lines if (found := one.coverage) is not None]
    if not shown:
        return None
    figure, (axes,) = canvas(1, 1, height_in=0.9 + 0.24 * len(shown))
    places = np.arange(len(shown), dtype=np.float64)[::-1]
    middle, low, high = (np.array([found[at] for _, found in shown]) * 100.0 for at in range(3))
    axes.axvline(95.0, color=INK, linestyle="--", linewidth=0.9, zorder=1.5)
    errors = (middle - low, high - middle)
    off = (low > 95.0) | (high < 95.0)
    for mine, color in ((~off, color_of("B")), (off, color_of("R"))):
        axes.errorbar(
            middle[mine],
            places[mine],
            xerr=(errors[0][mine], errors[1][mine]),
            linestyle="none",
            marker="o",
            color=color,
            markersize=4.0,
            elinewidth=1.1,
        )
    axes.set_yticks(places, [_label(one) for one, _ in shown])
    axes.set_ylim(-0.7, len(shown) - 0.3)
    axes.set_xlim(min(88.0, float(low.min()) - 1.0), 100.6)
    axes.set_xlabel("95 % intervals that hold the truth [%]")
    axes.grid(visible=False, axis="y")
    return picture(
        figure,
        alt="Share of 95 % intervals that hold the truth, one line per quantity, with its own interval",
        caption=(
            "How often the 95 % interval of a figure holds the truth, over all cameras, channels and ISOs. Bars: what "
            "so many trials can tell (Clopper and Pearson, 95 %; one in twenty of them misses the dashed line by "
            "chance, and red says that it does)."
        ),
    )


def _label(one: Together) -> str:
    threshold = "" if one.snr_threshold in {None, 1.0} else f", SNR {one.snr_threshold:g}"
    return f"{title_of(one.quantity)}{threshold}"
