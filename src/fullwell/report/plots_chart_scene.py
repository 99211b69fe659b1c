"""The chart itself with its patches, and noise and signal-to-noise ratio against its densities."""

from typing import Final

import numpy as np
from numpy.typing import NDArray

from fullwell.report.curves import Table, Value
from fullwell.report.drawing import Axes, Figure, key
from fullwell.report.drawing.style import QUIET
from fullwell.report.numbers import show_iso
from fullwell.report.pictures import ChartPicture
from fullwell.report.plots import (
    WIDTH_IN,
    Picture,
    canvas,
    channel_legend,
    color_of,
    finite_range,
    iso_title,
    marker_of,
    picture,
)
from fullwell.report.plots_chart_model import BRIGHTEST, decibel

_TALLEST_IN: Final = 7.5
_OUTLINE: Final = "#ffe14d"
_LEFT_OUT: Final = "#ff7a45"
_HALO: Final = "#111827"
_LOWEST_DECIBEL: Final = -22.0
"""Below it a patch has no signal to speak of."""
_LIGHT: Final = 235.0
"""Display value that the lightest patch is brought to."""
_MOST_BRIGHTENED: Final = 3.0
_SMALLEST_LETTERS: Final = 3.2


def annotated_chart(chart: ChartPicture) -> Picture:
    """Draw the chart with the patches that were measured."""
    height, width = chart.image.shape[:2]
    tall = min(WIDTH_IN * height / width, _TALLEST_IN)
    across = tall * width / height / WIDTH_IN
    figure = Figure((WIDTH_IN, tall))
    axes = figure.add_axes(((1.0 - across) / 2.0, 0.0, across, 1.0))
    axes.imshow(_brightened(chart), extent=(0.0, width, height, 0.0), interpolation="smooth")
    axes.set_axis_off()
    for patch in chart.patches:
        _outlined(axes, patch, left_out=patch[0] in chart.left_out, scale=72.0 * WIDTH_IN * across / width)
    if chart.corners:
        x, y = zip(*chart.corners, strict=True)
        axes.fill(x, y, edgecolor="#ffffff", linestyle="--", zorder=2.0)
    return picture(
        figure,
        alt=f"The chart with its {len(chart.patches)} patches outlined, {chart.title}",
        caption=_chart_caption(chart),
    )


def _outlined(axes: Axes, patch: tuple[str, float, float, float, float], *, left_out: bool, scale: float) -> None:
    """Draw a rectangle around a patch with its name inside, where that can be read.

    Parameters
    ----------
    axes
        Where.
    patch
        Name, left, top, width and height [pixel].
    left_out
        Whether it took no part.
    scale
        Points of a pixel.

    """
    name, x, y, wide, high = patch
    color = _LEFT_OUT if left_out else _OUTLINE
    axes.rectangle(x, y, wide, high, edgecolor=color, linewidth=1.1, halo=_HALO)
    words = name.replace("-", " ").split() or [""]
    longest = max(len(word) for word in words)
    size = min(9.0, scale * min(0.7 * high / len(words), 1.45 * wide / max(longest, 1)))
    if size >= _SMALLEST_LETTERS:
        middle = (x + 0.5 * wide, y + 0.5 * high)
        text = "\n".join(words)
        axes.text(*middle, text, color=color, size=size, ha="center", va="center", halo=_HALO, clipped=True)


def _brightened(chart: ChartPicture) -> NDArray[np.uint8]:
    """Return the preview with its lightest patch near white, shape (V, H, 3)."""
    inside = [
        chart.image[round(y) : round(y + high), round(x) : round(x + wide)]
        for name, x, y, wide, high in chart.patches
        if name not in chart.left_out
    ]
    lightest = max((float(np.percentile(one, 90.0)) for one in inside if one.size), default=_LIGHT)
    factor = float(np.clip(_LIGHT / max(lightest, 1.0), 1.0, _MOST_BRIGHTENED))
    return np.clip(chart.image * factor, 0.0, 255.0).astype(np.uint8)


def _chart_caption(chart: ChartPicture) -> str:
    found = (
        "placed as given"
        if chart.confidence is None
        else f"located in the image with a confidence of {chart.confidence:.2f} of 1"
    )
    return (
        f"{chart.title} at {show_iso(chart.iso)}, brightened for the eye: {len(chart.patches)} patches, {found}. "
        "Only what lies inside the outlines was measured."
        + (" Orange: clipped in every channel, not used." if chart.left_out else "")
        + (" Dashed: the chart." if chart.corners else "")
    )


def against_density(points: Table, iso: Value) -> Picture | None:
    """Draw noise and signal-to-noise ratio of the patches against the exposure that their densities give, for one ISO.

    Parameters
    ----------
    points
        Curve `chart_points` of the ISO.
    iso
        Of the table.

    Returns
    -------
    Picture or None
        None where fewer than three densities are known.

    """
    density = points.numbers("density")
    if np.unique(density[np.isfinite(density)]).size < 3:
        return None
    figure, (noise, ratio) = canvas(1, 2, height_in=3.7)
    channels = [str(channel) for channel, _ in points.split("channel")]
    for channel, part in points.split("channel"):
        for exposure, one in part.split("exposure"):
            for _, scene in one.split("scene"):
                _density_points((noise, ratio), scene, str(channel), brightest=exposure == BRIGHTEST)
    noise.set_yscale("log")
    noise.set_title("Noise")
    noise.set_ylabel("Noise of one frame [DN]")
    ratio.set_title("Signal-to-noise ratio")
    ratio.set_ylabel("Signal / noise [dB]")
    ratio.axhline(0.0, color=QUIET, linewidth=0.9)
    ratio.set_ylim(max(ratio.get_ylim()[0], _LOWEST_DECIBEL))
    for axes in (noise, ratio):
        axes.set_xlabel("log_{10} exposure  (−density)")
    extra = [key("darker exposure", color=QUIET, linestyle="none", marker="o")] if _several(points) else []
    channel_legend(figure, channels, extra)
    return picture(
        figure,
        alt=f"Noise and signal-to-noise ratio against exposure at {iso_title(_known(iso))}",
        caption=(
            f"Noise and signal-to-noise ratio of the patches at {iso_title(_known(iso))} against exposure, which is "
            "the negative density of the patch. What the lens adds to dark patches lifts them here, which it does not "
            "against the signal: this is the camera, not the sensor alone."
            + (" Hollow: darker exposures, at the same density." if _several(points) else "")
        ),
    )


def _density_points(panels: tuple[Axes, Axes], part: Table, channel: str, *, brightest: bool) -> None:
    """Draw the patches of one channel in one exposure of one scene."""
    exposure, signal = -part.numbers("density"), part.numbers("signal")
    noise = np.sqrt(np.maximum(part.numbers("variance"), 0.0))
    used = np.array([value != "no" for value in part.values("used")])
    values = (noise, decibel(np.divide(signal, noise, out=np.full(signal.shape, np.nan), where=noise > 0.0)))
    shown = np.flatnonzero(np.isfinite(exposure) & used & (noise > 0.0))
    order = shown[np.argsort(exposure[shown])]
    for axes, drawn in zip(panels, values, strict=True):
        axes.plot(
            exposure[order],
            drawn[order],
            color=color_of(channel),
            marker=marker_of(channel),
            markerfacecolor=color_of(channel) if brightest else "white",
            markersize=3.4,
            linewidth=0.8,
            linestyle="-" if brightest else ":",
            alpha=0.9,
        )


def _several(points: Table) -> bool:
    span = finite_range(points.numbers("exposure"))
    return span is not None and span[1] > 0.0


def _known(iso: Value) -> float | None:
    return iso if isinstance(iso, (int, float)) else None
