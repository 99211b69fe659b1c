"""The two main pictures of a chart: noise, and signal-to-noise ratio, against the normalized signal."""

from collections.abc import Sequence
from typing import Final

import numpy as np
from numpy.typing import NDArray

from fullwell.report.curves import Table, Value
from fullwell.report.drawing import Axes, Figure
from fullwell.report.drawing.style import INK, QUIET
from fullwell.report.numbers import show_iso
from fullwell.report.pictures import RenderedPoints
from fullwell.report.plots import WIDTH_IN, Picture, canvas, color_of, finite_range, picture
from fullwell.report.plots_chart_model import (
    DARK,
    FIXED,
    SHOT,
    NoiseCurve,
    Patches,
    along,
    circle_keys,
    common_lines,
    decibel,
    leading_curve,
    model_key,
    model_line,
    noise_curves,
    normalized_axes,
    patches_of,
    scatter,
)

_SIGNAL: Final = "Normalized signal above black  V = S / D"
_ONE_CURVE: Final = "Noise depends on the raw value alone, so every colour lies on one curve. "
_HEIGHT_IN: Final = 5.9
_BROAD: Final = 5.5
_DASHES: Final = (5.0, 2.5)

Facts = Sequence[tuple[str, str]]
"""Names and values written into a picture."""


def noise_curve(points: Table, models: Table, iso: Value, *, facts: Facts, one_curve: bool) -> Picture | None:
    """Draw noise against signal with model, asymptotes and residuals for one ISO; None without a model.

    Parameters
    ----------
    points, models
        Curves `chart_points` and `chart_noise_model` of the ISO.
    iso
        Of the tables.
    facts
        Figures to write beside the curve.
    one_curve
        Whether the channels share the model.

    """
    curves = noise_curves(models)
    leading = leading_curve(curves)
    if leading is None:
        return None
    every = patches_of(points, leading.digital_maximum)
    figure = Figure((WIDTH_IN, _HEIGHT_IN))
    main, rest = figure.subplots(2, heights=(0.79, 0.21))
    span = _span(every, leading)
    noises = [one.noise[one.signal > span[0]] for one in every]
    grid = np.geomspace(*span, 241)
    limits = finite_range(*noises, leading.noise(grid), positive=True) or (1e-4, 1e-1)
    main.set(xlim=span, ylim=(limits[0] / 1.9, limits[1] * 2.4))
    normalized_axes(main)
    for one in common_lines(curves):
        model_line(main, grid, one.noise(grid), width=_BROAD)
    _noise_asymptotes(main, leading)
    for one in every:
        scatter(main, one, one.noise)
    main.set_ylabel("Normalized noise  σ / D")
    _strip(rest, main, every)
    main.facts(facts, corner=(0.014, 0.975))
    _legend(figure, every)
    return picture(
        figure,
        alt=f"Photon transfer noise curve at {_named(iso)}: noise of every patch against its signal, with the model",
        caption=(
            f"Photon transfer noise curve at {_named(iso)}. Each circle is one patch in one channel of one frame; the "
            "grey line is the fitted noise model. Its parts are the dashed lines: dark noise is the same everywhere, "
            "shot noise grows with the square root of the signal, fixed pattern in proportion to it"
            f"{'' if np.isfinite(leading.coefficients[2]) else ', but none is seen'}. "
            f"{_ONE_CURVE if one_curve else ''}Below: deviation from the channel's own model in "
            "standard deviations, grey: ±2."
        ),
    )


def snr_curve(
    points: Table, models: Table, iso: Value, *, facts: Facts, saturation: float | None, range_text: str
) -> Picture | None:
    """Draw the signal-to-noise ratio in dB against signal, with model and asymptotes, for one ISO.

    Parameters
    ----------
    points, models, iso
        As in `noise_curve`.
    facts
        Figures to write beside the curve.
    saturation
        Normalized signal at saturation; None where unknown.
    range_text
        Dynamic range to write over the arrow from SNR 1 to saturation.

    """
    curves = noise_curves(models)
    leading = leading_curve(curves)
    if leading is None:
        return None
    every = patches_of(points, leading.digital_maximum)
    figure, (axes,) = canvas(1, 1, height_in=4.7)
    span = _span(every, leading, deep=False)
    grid = np.geomspace(*span, 241)
    axes.set(xlim=span, ylim=(-8.0, _highest_snr(every, leading, grid)))
    axes.set_xscale("powers")
    for one in common_lines(curves):
        model_line(axes, grid, decibel(grid / one.noise(grid)), width=_BROAD)
    _snr_asymptotes(axes, leading)
    for one in every:
        scatter(axes, one, one.snr)
    axes.set_yticks(np.arange(0.0, axes.get_ylim()[1], 10.0))
    axes.set(xlabel=_SIGNAL, ylabel="Signal / noise [dB]")
    _range_arrow(axes, leading.detection, saturation, range_text)
    axes.facts(facts, corner=(0.955, 0.5), right=True)
    _legend(figure, every)
    return picture(
        figure,
        alt=f"Signal-to-noise ratio in dB against signal at {_named(iso)}, with the model and its three asymptotes",
        caption=(
            f"Signal-to-noise ratio of one frame at {_named(iso)}, 20 log10 of signal over noise. The curve rises by "
            "20 dB per decade where dark noise rules, by 10 dB where shot noise does, and would level off where the "
            "fixed pattern does. The dynamic range reaches from SNR 1 (0 dB) to saturation."
        ),
    )


def jumbled(points: Table, models: Table, iso: Value, rendered: RenderedPoints) -> Picture | None:
    """Draw noise against signal of the raw file beside that of a developed picture of the same scene."""
    curves = noise_curves(models)
    leading = leading_curve(curves)
    if leading is None:
        return None
    figure, (left, right) = canvas(1, 2, height_in=3.7)
    every = patches_of(points, leading.digital_maximum)
    span = _span(every, leading)
    grid = np.geomspace(*span, 121)
    for one in common_lines(curves):
        model_line(left, grid, one.noise(grid), width=0.8 * _BROAD)
    for one in every:
        scatter(left, one, one.noise, size=4.0)
    left.set(xlim=span)
    for index, channel in enumerate(rendered.channels):
        _rendered(right, channel, rendered.mean[index], rendered.noise[index])
    left.set_title("Raw file: one curve")
    right.set_title("Developed picture: no curve")
    left.set(xlabel=_SIGNAL, ylabel="Normalized noise  σ / D")
    right.set(xlabel="Pixel value / largest value", ylabel="Noise / largest value")
    for axes in (left, right):
        normalized_axes(axes)
    figure.legend(circle_keys(every))
    return picture(
        figure,
        alt=f"Noise against signal at {_named(iso)}: the raw file on one curve, {rendered.file} scattered",
        caption=(
            f"The same scene at {_named(iso)} as raw file (left) and developed, {rendered.file} (right). Developing "
            "mixes the colours, scales each by the white balance, bends them with a tone curve, smooths and sharpens "
            "by what is around, and rounds to few bits. What noise is left depends on all of that and no longer on "
            "the level alone: the curve is jumbled, and no noise model can be read from it."
        ),
    )


def _rendered(axes: Axes, channel: str, mean: NDArray[np.float64], noise: NDArray[np.float64]) -> None:
    shown = np.flatnonzero((mean > 0.0) & (noise > 0.0))
    order = shown[np.argsort(mean[shown])]
    color = color_of(channel)
    axes.plot(mean[order], noise[order], color=color, linewidth=0.7, alpha=0.45)
    axes.plot(mean[order], noise[order], linestyle="none", marker="o", color=color, markersize=4.0, alpha=0.85)


def _named(iso: Value) -> str:
    return show_iso(iso if isinstance(iso, (int, float)) else None)


def _span(every: Sequence[Patches], leading: NoiseCurve, *, deep: bool = True) -> tuple[float, float]:
    """Return the signals to show: from far below SNR 1 where patches are that dark, else from a little below it."""
    seen = finite_range(*[one.signal for one in every], positive=True) or (1e-4, 1.0)
    start = leading.detection
    low = seen[0] / 1.6
    if np.isfinite(start):
        low = max(low, 0.06 * start) if deep else 0.3 * start
    return low, max(1.05, 1.3 * seen[1])


def _highest_snr(every: Sequence[Patches], leading: NoiseCurve, grid: NDArray[np.float64]) -> float:
    """Return the top of the SNR picture [dB]: above all points, above the line of the fixed pattern if that is near."""
    seen = finite_range(*[one.snr for one in every], decibel(grid / leading.noise(grid)))
    top = (seen[1] if seen else 40.0) + 6.0
    fixed = -20.0 * np.log10(leading.coefficients[2])
    return max(top, float(fixed) + 5.0) if fixed < top + 8.0 else top


def _strip(axes: Axes, main: Axes, every: Sequence[Patches]) -> None:
    axes.axhspan(-2.0, 2.0, color="#eef2f5")
    axes.axhline(0.0, color=QUIET, linewidth=0.8)
    for one in every:
        scatter(axes, one, one.residual, size=3.4)
    largest = finite_range(*[np.abs(one.residual) for one in every])
    bound = max(4.4, 1.12 * largest[1]) if largest else 4.4
    axes.set(xlim=main.get_xlim(), ylim=(-bound, bound), xlabel=_SIGNAL, ylabel="Residual [σ]")
    axes.set_xscale("powers")
    axes.locator_params(axis="y", nbins=5)
    main.tick_params(axis="x", labels=False)


def _noise_asymptotes(axes: Axes, model: NoiseCurve) -> None:
    """Draw the three parts of the noise, each named on its line."""
    (low, high), (bottom, top) = axes.get_xlim(), axes.get_ylim()
    dark, shot, fixed = model.coefficients
    parts = (
        (dark, 0.0, DARK, "dark noise"),
        (shot, 0.5, SHOT, "shot noise  ∝ √V"),
        (fixed, 1.0, FIXED, "fixed pattern  ∝ V"),
    )
    for factor, power, color, text in parts:
        if not np.isfinite(factor):
            continue
        ends = np.array([low, high])
        axes.plot(ends, factor * ends**power, color=color, linestyle=_DASHES, linewidth=1.1, zorder=2.5)
        at = _label_place(factor, power, (low, high), (bottom, top))
        if at is not None:
            along(axes, text, at, slope=power, color=color, below=power > 0.0)


def _label_place(
    factor: float, power: float, across: tuple[float, float], up: tuple[float, float]
) -> tuple[float, float] | None:
    """Return where to name a line: the dark one at the far end, the others soon after they enter from below."""
    share = 0.78 if power == 0.0 else 0.05
    start = across[0] if power == 0.0 else max(across[0], (up[0] / factor) ** (1.0 / power))
    x = 10.0 ** ((1.0 - share) * np.log10(start) + share * np.log10(across[1]))
    y = factor * x**power
    return (float(x), float(y)) if up[0] <= y <= 0.5 * up[1] and x < across[1] else None


def _snr_asymptotes(axes: Axes, model: NoiseCurve) -> None:
    dark, shot, fixed = model.coefficients
    ends = np.array(axes.get_xlim())
    parts = (
        (dark, 1.0, DARK, "dark noise alone"),
        (shot, 0.5, SHOT, "shot noise alone"),
        (fixed, 0.0, FIXED, "fixed pattern alone"),
    )
    for factor, power, color, text in parts:
        if not np.isfinite(factor):
            continue
        levels = 20.0 * np.log10(ends**power / factor)
        axes.plot(ends, levels, color=color, linestyle=_DASHES, linewidth=1.1, zorder=2.5)
        _name_snr_line(axes, text, float(levels[0]), 20.0 * power, color)


def _name_snr_line(axes: Axes, text: str, first: float, slope: float, color: str) -> None:
    """Name a line that starts at ``first`` dB on the left and rises by ``slope`` dB per decade."""
    (low, high), (_, top) = axes.get_xlim(), axes.get_ylim()
    decades = float(np.log10(high / low))
    share = 0.03 if slope == 0.0 else min(0.72, (0.86 * top - first) / slope / decades - 0.16)
    if share > 0.0 and first + slope * share * decades < top - 3.0:
        along(axes, text, (low * 10.0 ** (share * decades), first + slope * share * decades), slope=slope, color=color)


def _range_arrow(axes: Axes, start: float, saturation: float | None, text: str) -> None:
    """Mark SNR 1 and saturation, and the dynamic range between them."""
    axes.axhline(0.0, color=INK, linewidth=0.8, zorder=1.0)
    if saturation is None or not np.isfinite(start) or not start < saturation:
        return
    bottom = axes.get_ylim()[0]
    axes.plot([saturation, saturation], [bottom, axes.get_ylim()[1]], color=QUIET, linestyle=":", linewidth=1.1)
    axes.plot([start, start], [bottom, 0.0], color=QUIET, linestyle=":", linewidth=1.1)
    level = 0.45 * bottom
    axes.arrow((start, level), (saturation, level))
    axes.text((start * saturation) ** 0.5, level, text, ha="center", va="center", size=8.5, on_paper=True)


def _legend(figure: Figure, every: Sequence[Patches]) -> None:
    figure.legend([*circle_keys(every), model_key()])
