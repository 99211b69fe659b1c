"""Frames without light: dark signal, the histogram around black, read noise, differences of frames."""

from collections.abc import Mapping
from typing import Final

import numpy as np

from fullwell.report.curves import Table
from fullwell.report.drawing import Axes, key, shades
from fullwell.report.drawing.style import INK
from fullwell.report.pictures import DarkZoom, DifferencePicture
from fullwell.report.plots import (
    Picture,
    beside,
    canvas,
    channel_legend,
    color_of,
    finite_range,
    grid_of,
    iso_axis,
    iso_title,
    marker_of,
    picture,
    stepped,
)

_GRAYS: Final = shades("#000000", "#ffffff", count=21)
"""Few greys: noise compresses badly, and the eye tells no more of them apart."""

_REGION_COLORS = ("#c2410c", "#1d4ed8", "#047857", "#7e22ce")


def _with_errors(axes: Axes, channel: str, points: Table, *, x: str, y: str) -> None:
    """Draw the points of a channel with their standard errors."""
    axes.errorbar(
        points.numbers(x),
        points.numbers(y),
        yerr=points.numbers("std_error"),
        linestyle="none",
        marker=marker_of(channel),
        color=color_of(channel),
        elinewidth=0.9,
        capsize=1.5,
    )


def dark_signal(table: Table) -> Picture:
    """Draw the mean dark signal against exposure time with the fitted line, one panel per ISO."""
    groups = list(table.split("iso"))
    figure, panels = grid_of(len(groups), panel_height_in=2.35)
    for axes, (iso, part) in zip(panels, groups, strict=True):
        for channel, points in part.split("channel"):
            exposure, color = points.numbers("exposure_s"), color_of(str(channel))
            _with_errors(axes, str(channel), points, x="exposure_s", y="mean")
            order = np.argsort(exposure)
            axes.plot(exposure[order], points.numbers("fitted")[order], color=color, linewidth=1.1)
        axes.set_title(iso_title(iso))
        axes.set(xlabel="Exposure time [s]", ylabel="Mean dark signal [DN]")
        axes.margins(x=0.06, y=0.12)
        axes.locator_params(axis="both", nbins=5)
    channel_legend(figure, [str(channel) for channel, _ in table.split("channel")], [key("fit")])
    return picture(
        figure,
        alt="Mean dark signal against exposure time with straight-line fits, one panel per ISO",
        caption=(
            "Mean of the dark frames against exposure time. The slope of the line is the dark current, its value at no "
            "exposure the black level. Bars: one standard error from the scatter of the frames of a burst."
        ),
    )


def dark_current_over_temperature(table: Table) -> Picture:
    """Draw dark current against temperature with the fitted rise, one panel per ISO."""
    groups = list(table.split("iso"))
    figure, panels = grid_of(len(groups), panel_height_in=2.35)
    for axes, (iso, part) in zip(panels, groups, strict=True):
        for channel, points in part.split("channel"):
            color, temperature = color_of(str(channel)), points.numbers("temperature_c")
            _with_errors(axes, str(channel), points, x="temperature_c", y="dark_current")
            fitted = points.numbers("fitted")
            if np.isfinite(fitted).all():
                course = np.linspace(temperature[0], temperature[-1], 50)
                axes.plot(course, np.exp2(np.interp(course, temperature, np.log2(fitted))), color=color, linewidth=1.1)
        axes.set_title(iso_title(iso))
        axes.set(xlabel="Temperature [°C]", ylabel="Dark current [DN/s]")
        axes.margins(x=0.06, y=0.12)
        axes.set_yscale("log")
    channel_legend(figure, [str(channel) for channel, _ in table.split("channel")], [key("fit")])
    return picture(
        figure,
        alt="Dark current against temperature with fitted exponential rise, one panel per ISO",
        caption=(
            "Dark current against the temperature of the sensor, on a logarithmic scale; a straight line doubles at "
            "equal steps. Bars: one standard error. Not part of EMVA 1288, which gives the points alone."
        ),
    )


def dark_histogram(table: Table, black_levels: Mapping[tuple[float | None, str], float]) -> Picture:
    """Draw how often each code occurs in dark frames, with the black level marked, one panel per ISO."""
    groups = list(table.split("iso"))
    figure, panels = grid_of(len(groups), panel_height_in=2.35)
    for axes, (iso, part) in zip(panels, groups, strict=True):
        for channel, points in part.split("channel"):
            axes.plot(
                *stepped(points.numbers("code"), points.numbers("count")),
                drawstyle="steps-mid",
                color=color_of(str(channel)),
                linewidth=1.1,
            )
            known = iso if isinstance(iso, (int, float)) else None
            if (black := black_levels.get((known, str(channel)))) is not None:
                axes.axvline(black, color=color_of(str(channel)), linestyle="--", linewidth=1.0)
        _around_bulk(axes, part)
        axes.set_yscale("log")
        axes.set_title(iso_title(iso))
        axes.set(xlabel="Raw value [DN]", ylabel="Pixel values")
        axes.locator_params(axis="x", nbins=6)
    extra = [key("black level", linestyle="--")]
    channel_legend(figure, [str(channel) for channel, _ in table.split("channel")], extra)
    return picture(
        figure,
        alt="Histogram of raw values in dark frames on a logarithmic scale, black level marked, one panel per ISO",
        caption=(
            "How often each raw value occurs in the dark frames, on a logarithmic scale. Dashed: the black level. A "
            "parabola is Gaussian noise; a wall at the left is a clip at black, a tail at the right hot pixels. The "
            "panel ends where all but one in 100 000 values are shown."
        ),
    )


def _around_bulk(axes: Axes, part: Table) -> None:
    """Limit the abscissa to where all but a few in 100 000 values lie."""
    code, count = part.numbers("code"), part.numbers("count")
    order = np.argsort(code)
    share = np.cumsum(count[order]) / count.sum()
    low = float(code[order][np.searchsorted(share, 1e-5)])
    high = float(code[order][min(int(np.searchsorted(share, 1.0 - 1e-5)), len(order) - 1)])
    axes.set_xlim(low - 1.5, high + 1.5)


def read_noise_against_iso(table: Table) -> Picture:
    """Draw read noise against ISO in DN with the amplifier model, and in electrons."""
    electrons = bool(np.isfinite(table.numbers("read_noise_e")).any())
    figure, panels = canvas(1, 2 if electrons else 1, height_in=3.5)
    groups = list(table.split("channel"))
    for index, (channel, points) in enumerate(groups):
        iso, color, marker = points.numbers("iso"), color_of(str(channel)), marker_of(str(channel))
        aside = beside(iso, index, len(groups))
        panels[0].errorbar(
            aside,
            points.numbers("read_noise"),
            yerr=points.numbers("std_error"),
            linestyle="none",
            marker=marker,
            color=color,
            elinewidth=0.9,
        )
        panels[0].plot(iso, points.numbers("fitted"), color=color, linewidth=1.2)
        if electrons:
            panels[1].plot(
                aside, points.numbers("read_noise_e"), linestyle="--", linewidth=0.8, marker=marker, color=color
            )
    panels[0].set(ylabel="Read noise [DN]", title="In raw values, with the amplifier model")
    if electrons:
        panels[1].set(ylabel="Read noise [e⁻]", title="In electrons")
    for axes in panels:
        iso_axis(axes, table.numbers("iso"), label_share=0.07)
        axes.set_ylim(0.0, 1.05 * axes.get_ylim()[1])
    extra = [key("fit")] if np.isfinite(table.numbers("fitted")).any() else []
    channel_legend(figure, [str(channel) for channel, _ in table.split("channel")], extra)
    return picture(
        figure,
        alt="Read noise against ISO in raw values and in electrons",
        caption=(
            "Read noise against ISO. In raw values the part before the amplifier grows with the amplification and the "
            "part after it stays: their squares add (line). In electrons read noise falls as the amplification rises "
            "until only the part before the amplifier is left."
        ),
    )


def difference(pair: DifferencePicture) -> Picture:
    """Draw the difference of two frames with its regions marked, and their histograms."""
    figure, (left, right) = canvas(1, 2, height_in=4.3)
    image = np.asarray(pair.image, float)
    spread = 3.5 * float(np.nanstd(np.clip(image, *np.nanpercentile(image, (0.1, 99.9))))) or 1.0
    shown = left.imshow(image, cmap=_GRAYS, vmin=-spread, vmax=spread)
    left.anchor = "bottom"
    left.set_title(f"Difference of two frames, {iso_title(pair.iso)}")
    left.colorbar(shown, label="Difference [DN]")
    for region, color in zip(pair.regions, _REGION_COLORS, strict=False):
        left.rectangle(region.x - 0.5, region.y - 0.5, region.width, region.height, edgecolor=color, linewidth=1.8)
        share = region.counts / max(int(region.counts.sum()), 1)
        right.plot(
            *stepped(np.asarray(region.codes, float), share),
            drawstyle="steps-mid",
            color=color,
            linewidth=1.3,
            label=f"{region.name}: σ = {region.std_dn:.3g} DN",
        )
    if pair.regions:
        right.set_yscale("log")
        figure.legend(right.keys, loc="lower right", columns=2)
    right.set(xlabel="Difference [DN]", ylabel="Share of pixels")
    right.set_title("Histogram by region")
    first, second = pair.frames
    return picture(
        figure,
        alt=f"Difference image of {first} and {second} with histograms of marked regions",
        caption=(
            f"Difference of {first} and {second}. Everything fixed drops out; what stays is temporal noise, √2 times "
            "that of one frame. Stripes would be row or column noise; regions with histograms of one width show "
            "noise that is the same everywhere."
        ),
    )


def zooms(pictures: tuple[DarkZoom, ...]) -> Picture:
    """Draw magnified pieces of dark frames."""
    figure, panels = grid_of(len(pictures), panel_height_in=2.9, columns=3)
    for axes, zoom in zip(panels, pictures, strict=True):
        image = np.asarray(zoom.image, float)
        limits = finite_range(image) or (0.0, 1.0)
        low, high = np.percentile(image[np.isfinite(image)], (0.5, 99.5)) if np.isfinite(image).any() else limits
        shown = axes.imshow(image, cmap=_GRAYS, vmin=low, vmax=max(high, low + 1e-9))
        axes.set_title(iso_title(zoom.iso))
        axes.colorbar(shown, label="Raw value above black [DN]")
    return picture(
        figure,
        alt="Magnified pieces of dark frames, one per ISO",
        caption=(
            "Magnified: single bright points are hot pixels, lines fixed row or column patterns. "
            + "; ".join(f"{iso_title(zoom.iso)}: {zoom.title}" for zoom in pictures)
            + "."
        ),
    )


def frame_means(table: Table) -> Picture:
    """Draw how the mean of each frame moves over its series, one panel per kind of frame."""
    groups = list(table.split("kind"))
    figure, panels = grid_of(len(groups), panel_height_in=2.8)
    for axes, (kind, part) in zip(panels, groups, strict=True):
        relative = kind == "flat"
        for _, at_iso in part.split("iso"):
            for _, series in at_iso.split("exposure_s"):
                for channel, points in series.split("channel"):
                    mean = points.numbers("mean")
                    change = mean - np.nanmean(mean)
                    shown = 100.0 * change / np.nanmean(mean) if relative else change
                    axes.plot(
                        points.numbers("frame") + 1.0, shown, color=color_of(str(channel)), linewidth=0.7, alpha=0.6
                    )
        axes.axhline(0.0, color=INK, linewidth=0.6)
        axes.set_title(f"{kind} frames")
        unit = "%" if relative else "DN"
        axes.set(xlabel="Frame of the series", ylabel=f"Deviation from series mean [{unit}]")
        axes.locator_params(axis="x", nbins=8, integer=True)
    channel_legend(figure, [str(channel) for channel, _ in table.split("channel")])
    return picture(
        figure,
        alt="Mean of each frame relative to the mean of its series, one panel per kind of frame",
        caption=(
            "How the mean of each frame moves over its series, one line per series and channel. A common slope is "
            "warming or a drifting lamp, a common jump flicker; lines that cross at random are steady."
        ),
    )
