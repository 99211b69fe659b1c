"""What the black level does to the patches of a chart: clustering, tonal response, proportional exposures."""

from collections.abc import Mapping
from typing import Final

import numpy as np
from numpy.typing import NDArray

from fullwell.report.curves import Table, Value
from fullwell.report.drawing import Axes, key
from fullwell.report.drawing.style import QUIET
from fullwell.report.numbers import show_plain
from fullwell.report.plots import (
    Picture,
    canvas,
    channel_legend,
    color_of,
    finite_range,
    iso_title,
    marker_of,
    picture,
)
from fullwell.report.plots_chart_model import (
    BRIGHTEST,
    NoiseCurve,
    Patches,
    channel_circles,
    circle_keys,
    common_lines,
    leading_curve,
    model_key,
    model_line,
    noise_curves,
    normalized_axes,
    patches_of,
    scatter,
)

_PARTLY: Final = 0.98
"""Share of the black level that the middle panel takes off: 500 of 511 in the published figure."""


_LIGHT: Final = 0.25
"""Share of the range of densities whose patches nothing flattens."""


def clustering(points: Table, models: Table, iso: Value) -> Picture | None:
    """Draw the noise curve with no, nearly all and all of the black level taken off, side by side, for one ISO.

    None without a model, or with a black level of zero.
    """
    curves = noise_curves(models)
    leading = leading_curve(curves)
    if leading is None or leading.black_level <= 0.0:
        return None
    every = patches_of(points, leading.digital_maximum)
    black = leading.black_level
    guess = _guess(black)
    figure, panels = canvas(1, 3, height_in=3.3)
    low = min(_lowest(every), 0.3 * (black - guess) / leading.digital_maximum)
    titles = (
        "Black level left in",
        f"{show_plain(guess)} of {black:.5g} DN taken off",
        f"{black:.5g} DN taken off",
    )
    for axes, title, left in zip(panels, titles, (black, black - guess, 0.0), strict=True):
        _shifted(axes, every, common_lines(curves), left / leading.digital_maximum, low)
        axes.set_title(title)
        axes.set_xlabel("Normalized signal")
    limits = finite_range(*[one.noise[one.signal > 0.0] for one in every], positive=True) or (1e-4, 1e-1)
    for axes in panels:
        axes.set(xlim=(low / 1.5, 1.4), ylim=(limits[0] / 1.5, limits[1] * 1.6))
        normalized_axes(axes)
    for axes in panels[1:]:
        axes.tick_params(axis="y", labels=False)
    panels[0].set_ylabel("Normalized noise")
    figure.legend([*circle_keys(every), model_key()])
    return picture(
        figure,
        alt=f"Noise curve at {iso_title(_known(iso))} with no, part and all of the black level taken off",
        caption=(
            f"Why the black level matters, at {iso_title(_known(iso))}. The noise is the same in all three; only the "
            "signal is counted from another level. With the black level left in, the dark patches cluster at one "
            "signal, and dark and shot noise cannot be told apart; a guess that is a little off still bends the curve. "
            "All three fit a noise model equally well: the right level is known from other evidence alone."
        ),
    )


def _shifted(axes: Axes, every: tuple[Patches, ...], lines: tuple[NoiseCurve, ...], left: float, low: float) -> None:
    """Draw one panel: signals with ``left`` of the normalized black level in them."""
    grid = np.geomspace(low, 1.2, 161)
    for line in lines:
        model_line(axes, grid + left, line.noise(grid), width=4.0)
    for one in every:
        moved = Patches(
            channel=one.channel,
            signal=one.signal + left,
            noise=one.noise,
            residual=one.residual,
            used=one.used,
            brightest=one.brightest,
        )
        scatter(axes, moved, moved.noise, size=3.6)
    if left > 0.0:
        axes.axvline(left, color=QUIET, linestyle=":", linewidth=0.9)


def _guess(black: float) -> float:
    """Return a round level a little below the black level."""
    aim = _PARTLY * black
    step = 10.0 ** np.floor(np.log10(max(black - aim, 1e-6)))
    return float(np.floor(aim / step) * step)


def _lowest(every: tuple[Patches, ...]) -> float:
    """Return a signal below all but the few patches that hardly have any."""
    signal = np.concatenate([one.signal for one in every])
    positive = signal[signal > 0.0]
    return float(np.percentile(positive, 1.0)) if positive.size else 1e-4


def tonal_response(table: Table, blacks: Mapping[str, float], iso: Value) -> Picture:
    """Draw log pixel value against log exposure, with and without the black level, and the slope, for one ISO.

    Parameters
    ----------
    table
        Curve `chart_tonal_response` of the ISO.
    blacks
        Black level of each channel, and of ``all`` where they share one [DN].
    iso
        Of the table.

    """
    figure, (left, right, slope) = canvas(1, 3, height_in=3.5)
    channels = [str(channel) for channel, _ in table.split("channel")]
    for channel, part in table.split("channel"):
        for axes, column in ((left, "log_pixel"), (right, "log_signal"), (slope, "slope")):
            _response_line(axes, str(channel), part.numbers("log_exposure"), part.numbers(column))
    exposures = finite_range(table.numbers("log_exposure")) or (-1.0, 0.0)
    lowest = finite_range(table.numbers("log_pixel"), table.numbers("log_signal")) or (-1.0, 0.0)
    for axes in (left, right):
        axes.set_ylim(lowest[0] - 0.15, 0.25)
        axes.set_ylabel("log_{10} (pixel value / white level)")
        _proportional(axes, table, exposures)
    shared = {"all": blacks["all"]} if "all" in blacks else blacks
    named = ", ".join(sorted({f"{level:.5g} DN" for level in shared.values()}))
    left.set_title("Black level left in")
    right.set_title("Black level taken off")
    slope.set_title("Slope, black level taken off")
    slope.axhline(1.0, color=QUIET, linestyle="--", linewidth=0.9)
    steep = finite_range(table.numbers("slope")) or (0.0, 1.0)
    slope.set_ylim(min(-0.05, max(steep[0], -0.5)), min(max(1.25, 1.08 * steep[1]), 2.5))
    slope.set_ylabel("Slope")
    for axes in (left, right, slope):
        axes.locator_params(axis="x", nbins=6)
        axes.set_xlabel("log_{10} exposure  (−density)")
    channel_legend(figure, channels, [key("proportional", color=QUIET, linestyle="--")])
    return picture(
        figure,
        alt=f"Tonal response at {iso_title(_known(iso))}: log pixel value against log exposure, with its slope",
        caption=(
            f"Tonal response at {iso_title(_known(iso))} over the same scale with the black level left in and taken "
            f"off{f' ({named})' if named else ''}. A sensor answers in proportion to light: slope 1, dashed. Left in, "
            "the black level flattens all that is dark. What stays flat after it is taken off is stray light in lens "
            "and room, which falls on the dark patches too."
        ),
    )


def _response_line(axes: Axes, channel: str, exposure: NDArray[np.float64], values: NDArray[np.float64]) -> None:
    axes.plot(
        exposure,
        values,
        color=color_of(channel),
        marker=marker_of(channel),
        markersize=3.2,
        linewidth=0.9,
        alpha=0.9,
    )


def _proportional(axes: Axes, table: Table, exposures: tuple[float, float]) -> None:
    """Draw slope 1 through the lightest patches of the channel that sees most: nothing flattens their response."""
    groups = [(part.numbers("log_exposure"), part.numbers("log_signal")) for _, part in table.split("channel")]
    groups = [(exposure, signal) for exposure, signal in groups if np.isfinite(signal).any()]
    if not groups:
        return
    exposure, signal = max(groups, key=lambda one: float(np.nanmax(one[1])))
    light = np.isfinite(signal) & (exposure >= exposures[1] - _LIGHT * (exposures[1] - exposures[0]))
    height = float(np.median(signal[light] - exposure[light])) if light.any() else 0.0
    ends = np.array(exposures)
    axes.plot(ends, ends + height, color=QUIET, linestyle="--", linewidth=0.9, zorder=1.0)


def proportional_exposures(table: Table, iso: Value) -> Picture | None:
    """Draw how far the patches of darker exposures are from one line through black, for one ISO.

    Parameters
    ----------
    table
        Curve `chart_bracket` of the ISO.
    iso
        Of the table.

    Returns
    -------
    Picture or None
        None without a darker exposure.

    """
    brightest = {_patch(one): one[-1] for one in _lines(table) if one[-2] == BRIGHTEST}
    darker = [(number, part) for number, part in table.split("exposure") if number != BRIGHTEST]
    if not darker:
        return None
    figure, panels = canvas(1, len(darker), height_in=2.7)
    bound = finite_range(np.abs(table.numbers("residual")))
    top = max(4.2, 1.1 * bound[1]) if bound else 4.2
    for axes, (_, part) in zip(panels, darker, strict=True):
        axes.axhspan(-2.0, 2.0, color="#eef2f5")
        axes.axhline(0.0, color=QUIET, linewidth=0.8)
        for channel, points in part.split("channel"):
            signal = np.array([brightest.get(_patch(one), np.nan) for one in _lines(points)])
            shown = np.array([value != "no" for value in points.values("used")]) & (signal > 0.0)
            axes.plot(
                signal[shown],
                points.numbers("residual")[shown],
                linestyle="none",
                marker="o",
                markersize=3.8,
                color=color_of(str(channel)),
                alpha=0.85,
            )
        ratio = finite_range(part.numbers("ratio"))
        axes.set_title(f"Exposure × {ratio[0]:.4g}" if ratio else "Darker exposure")
        axes.set_ylim(-top, top)
        axes.set_xlabel("Signal of the patch in the brightest exposure [DN]")
        axes.set_xscale("log")
    panels[0].set_ylabel("Residual [σ]")
    keys = channel_circles(str(channel) for channel, _ in table.split("channel"))
    figure.legend(keys)
    return picture(
        figure,
        alt=f"Residuals of the exposure bracket at {iso_title(_known(iso))}, a panel per darker exposure",
        caption=(
            f"Two exposures of one still scene at {iso_title(_known(iso))} differ by a factor above the black level, "
            "whatever the patches and the stray light are: the one level for which that holds is the black level. "
            "Deviation of each patch from it in standard deviations, grey: ±2."
        ),
    )


def _lines(table: Table) -> list[tuple[Value, Value, Value, Value, float]]:
    """Return scene, channel, patch, exposure and signal of each point."""
    names = ("scene", "channel", "patch", "exposure")
    return list(zip(*(table.values(name) for name in names), table.numbers("signal").tolist(), strict=True))


def _patch(line: tuple[Value, Value, Value, Value, float]) -> tuple[Value, Value, Value]:
    return line[0], line[1], line[2]


def _known(iso: Value) -> float | None:
    return iso if isinstance(iso, (int, float)) else None
