"""Photon transfer and the signal-to-noise curve."""

import numpy as np
from numpy.typing import NDArray

from fullwell.report.curves import Table, Value
from fullwell.report.drawing import Axes, key
from fullwell.report.drawing.style import INK, QUIET
from fullwell.report.plots import (
    DENSE,
    Picture,
    canvas,
    channel_legend,
    color_of,
    finite_range,
    grid_of,
    iso_title,
    marker_of,
    picture,
)


def photon_transfer(table: Table, iso: Value) -> Picture:
    """Draw variance against signal with the fit, and the residuals, for one ISO and all channels."""
    figure, (main, rest) = canvas(1, 2, height_in=4.1)
    channels = [str(channel) for channel, _ in table.split("channel")]
    for channel, points in table.split("channel"):
        _transfer_points(main, points, str(channel))
        _residuals(rest, points, str(channel))
    main.set_xscale("log")
    main.set_yscale("log")
    main.set(xlabel="Signal above black [DN]", ylabel="Variance [DN²]")
    main.set_title("Variance against signal")
    rest.axhspan(-2.0, 2.0, color="#eef2f5")
    rest.axhline(0.0, color=QUIET, linewidth=0.8)
    rest.set(xlabel="Signal above black [DN]", ylabel="Residual [standard deviations]")
    rest.set_title("Residuals of the fit")
    rest.set_xscale("log")
    largest = finite_range(np.abs(table.numbers("residual")))
    bound = max(4.5, 1.1 * largest[1]) if largest else 4.5
    rest.set_ylim(-bound, bound)
    extra = [key("fit"), key("dark", linestyle=":"), key("left out", color=QUIET, linestyle="none", marker="x")]
    channel_legend(figure, channels, extra)
    return picture(
        figure,
        alt=f"Photon transfer at {iso_title(iso)}: variance against signal, and residuals, for {', '.join(channels)}",
        caption=(
            f"Photon transfer at {iso_title(iso)}. Left: variance of every burst against its signal above black, with "
            "the fitted noise model; dotted: variance in the dark. Where the line has slope 1 shot noise rules, and "
            "variance over signal is the system gain. Right: deviation of each point in standard deviations; two "
            "thirds of them belong within ±1, the grey band is ±2."
        ),
    )


def _transfer_points(axes: Axes, points: Table, channel: str) -> None:
    signal, variance = points.numbers("signal"), points.numbers("variance")
    fitted, error = points.numbers("fitted"), points.numbers("variance_std_error")
    lit = _lit(points) & (signal > 0.0) & (variance > 0.0)
    used = lit & _used(points)
    color = color_of(channel)
    dense = bool(used.sum() > DENSE)
    axes.plot(
        signal[used],
        variance[used],
        linestyle="none",
        marker=marker_of(channel),
        color=color,
        markersize=2.0 if dense else 4.0,
        alpha=0.35 if dense else 0.9,
        markeredgewidth=0.0,
        dense=dense,
    )
    if not dense:
        axes.errorbar(signal[used], variance[used], yerr=error[used], linestyle="none", color=color, elinewidth=0.9)
    out = lit & ~used
    axes.plot(
        signal[out],
        variance[out],
        linestyle="none",
        marker="x",
        color=QUIET,
        markersize=4.0,
        dense=dense,
    )
    order = _spread(np.argsort(signal[lit]))
    axes.plot(signal[lit][order], fitted[lit][order], color=color, linewidth=1.2)
    dark = ~_lit(points) & (variance > 0.0)
    if dark.any():
        axes.axhline(float(np.mean(variance[dark])), color=color, linestyle=":", linewidth=1.0)


def _spread(order: NDArray[np.intp], most: int = 120) -> NDArray[np.intp]:
    """Return at most ``most`` of the ordered indices, both ends kept: enough for a smooth line."""
    if len(order) <= most:
        return order
    return order[np.unique(np.linspace(0, len(order) - 1, most).round().astype(np.intp))]


def _lit(points: Table) -> NDArray[np.bool_]:
    return np.array([kind == "flat" for kind in points.values("kind")])


def _used(points: Table) -> NDArray[np.bool_]:
    return np.array([value != "no" for value in points.values("used")])


def _residuals(axes: Axes, points: Table, channel: str) -> None:
    signal, residual = points.numbers("signal"), points.numbers("residual")
    shown = _lit(points) & (signal > 0.0) & np.isfinite(residual) & _used(points)
    dense = bool(shown.sum() > DENSE)
    axes.plot(
        signal[shown],
        residual[shown],
        linestyle="none",
        marker=marker_of(channel),
        color=color_of(channel),
        markersize=2.0 if dense else 4.0,
        alpha=0.35 if dense else 0.9,
        markeredgewidth=0.0,
        dense=dense,
    )


def signal_to_noise(table: Table) -> Picture:
    """Draw signal over noise against signal, one panel per ISO, modelled and measured."""
    groups = list(table.split("iso"))
    unit = "e" if np.isfinite(table.numbers("signal_e")).any() else "dn"
    column, label = ("signal_e", "Signal [e⁻]") if unit == "e" else ("signal", "Signal above black [DN]")
    figure, panels = grid_of(len(groups), panel_height_in=2.35)
    limits = finite_range(table.numbers("snr"), positive=True)
    span = finite_range(table.numbers(column), positive=True)
    for axes, (iso, part) in zip(panels, groups, strict=True):
        for channel, points in part.split("channel"):
            _snr(axes, points, column, str(channel))
        if limits and span:
            axes.set_xlim(max(span[0] / 1.3, span[1] * 1e-5), span[1] * 1.5)
            axes.set_ylim(max(limits[0] / 1.3, limits[1] * 1e-4), limits[1] * 1.6)
        axes.set_xscale("log")
        axes.set_yscale("log")
        axes.set_title(iso_title(iso))
        axes.set(xlabel=label, ylabel="Signal / noise [1]")
        axes.axhline(1.0, color=INK, linestyle="--", linewidth=0.8)
    extra = [key("model"), key("measured", linestyle="none", marker="o"), key("SNR 1", linestyle="--")]
    channel_legend(figure, [str(channel) for channel, _ in table.split("channel")], extra)
    return picture(
        figure,
        alt="Signal-to-noise ratio against signal, one panel per ISO",
        caption=(
            "Signal-to-noise ratio against signal. Lines: the fitted noise model; points: what the bursts show. The "
            "dashed line is SNR 1, where the dynamic range begins; the curve ends at saturation."
        ),
    )


def _snr(axes: Axes, points: Table, column: str, channel: str) -> None:
    signal, ratio = points.numbers(column), points.numbers("snr")
    good = (signal > 0.0) & (ratio > 0.0)
    modelled = good & np.array([kind == "model" for kind in points.values("kind")])
    measured = good & ~modelled
    order = np.argsort(signal[modelled])
    axes.plot(signal[modelled][order], ratio[modelled][order], color=color_of(channel), linewidth=1.3)
    axes.plot(
        signal[measured],
        ratio[measured],
        linestyle="none",
        marker=marker_of(channel),
        color=color_of(channel),
        markerfacecolor="white",
        markersize=4.0,
        dense=bool(measured.sum() > DENSE),
    )
