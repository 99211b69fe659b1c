"""Fixed pattern: PRNU per channel, tile and ISO beside the published figures, pixel responses, standard deviations."""

import textwrap
from collections.abc import Mapping, Sequence
from typing import Final

import numpy as np
from numpy.typing import NDArray

from fullwell.figures.results import Row
from fullwell.raw.cfa import channel_rank
from fullwell.report.curves import Table, Value
from fullwell.report.drawing import Axes, key
from fullwell.report.drawing.style import INK, QUIET, Marker
from fullwell.report.numbers import show_iso, show_unit
from fullwell.report.pictures import ResponsePicture
from fullwell.report.plots import (
    Picture,
    beside,
    channel_legend,
    color_of,
    grid_of,
    iso_axis,
    iso_title,
    marker_of,
    picture,
)
from fullwell.report.plots_surface import Surface, draw_surfaces, space

_FEW_DECADES: Final = 8.0
_TILE_FACETS: Final = 64
_TITLE_WIDTH: Final = 46
"""Letters of a line of a title over half the page."""


def by_channel(best: Sequence[Row], whole: Sequence[Row], tiles: Sequence[Row]) -> Picture:
    """Draw PRNU per channel: recommended with its interval, published without and with tiles; one panel per ISO.

    Parameters
    ----------
    best
        Recommended figures.
    whole, tiles
        Published ones of the crop and of its tiles.

    """
    isos = sorted({row.iso for row in (*best, *whole, *tiles)}, key=lambda iso: -1.0 if iso is None else iso)
    channels = sorted({row.channel for row in (*best, *whole, *tiles)}, key=channel_rank)
    figure, panels = grid_of(len(isos), panel_height_in=2.4)
    places = {channel: float(index) for index, channel in enumerate(channels)}
    kinds: tuple[tuple[Sequence[Row], Marker, float], ...] = (
        (best, "o", -0.2),
        (whole, "s", 0.05),
        (tiles, "D", 0.25),
    )
    for axes, iso in zip(panels, isos, strict=True):
        for rows, marker, aside in kinds:
            mine = [row for row in rows if row.iso == iso]
            place = [places[row.channel] + aside for row in mine]
            _points(axes, place, mine, marker=marker, filled=rows is best)
        axes.set_xticks(list(places.values()), list(places))
        axes.set_xlim(-0.5, len(channels) - 0.5)
        axes.grid(visible=False, axis="x")
        axes.set_title(iso_title(iso))
        axes.set_ylabel("PRNU [%]")
        _positive_axis(axes, [row.measured.value for row in (*best, *whole, *tiles) if row.iso == iso])
    extra = [
        key("recommended, 95 %", linestyle="none", marker="o"),
        key("published, whole crop", linestyle="none", marker="s"),
        key("published, tiles", linestyle="none", marker="D"),
    ]
    figure.legend(extra)
    return picture(
        figure,
        alt="PRNU per channel: recommended, and published with and without tiles, one panel per ISO",
        caption=(
            "PRNU of each channel: recommended with its 95 % interval (filled), and the spread of the slopes as "
            "published, of the whole crop (square) and of its tiles (diamond). Tiles take the shading out of the "
            "spread but leave the temporal noise in; G is the study's mean of both greens, all mixes the colours."
        ),
    )


def against_iso(best: Mapping[tuple[str, str], Sequence[Row]], published: Sequence[Row]) -> Picture:
    """Draw DSNU and PRNU against ISO, the published figures beside them, one panel per quantity and unit.

    Parameters
    ----------
    best
        Title and unit of each panel with its recommended rows.
    published
        Published rows; each goes into the panel of its quantity and unit.

    """
    figure, panels = grid_of(len(best), panel_height_in=2.6)
    channels: set[str] = set()
    for axes, ((title, unit), rows) in zip(panels, best.items(), strict=True):
        old = [row for row in published if (row.quantity, row.measured.unit) == (rows[0].quantity, unit)]
        names = sorted({row.channel for row in (*rows, *old)}, key=channel_rank)
        for index, channel in enumerate(names):
            _course(axes, [row for row in rows if row.channel == channel], index, len(names))
            mine = sorted((row for row in old if row.channel == channel), key=lambda row: row.iso or 0.0)
            axes.plot(
                beside(np.array([row.iso or np.nan for row in mine], float), index, len(names)),
                [row.measured.value for row in mine],
                color=color_of(channel),
                marker=marker_of(channel),
                markerfacecolor="none",
                linestyle=":",
                linewidth=0.9,
            )
        channels |= set(names)
        iso_axis(axes, [row.iso for row in (*rows, *old) if row.iso is not None], label_share=0.11)
        axes.set_title(title)
        axes.set_ylabel(f"[{show_unit(unit) or '1'}]")
        _positive_axis(axes, [row.measured.value for row in (*rows, *old)])
    extra = [key("recommended", marker="o"), key("published", linestyle=":", marker="o")] if published else []
    channel_legend(figure, channels, extra)
    return picture(
        figure,
        alt="PRNU and DSNU against ISO, recommended and as published",
        caption=(
            "PRNU and DSNU against ISO: recommended (lines, 95 % intervals) and as published (dotted, hollow). A PRNU "
            "that rises with ISO only as published is temporal noise, which the amplifier brings up; the pixels "
            "themselves do not know the amplifier."
        ),
    )


def per_tile(table: Table, published: Table | None, pooled: Mapping[str, Row], iso: Value) -> Picture:
    """Draw PRNU of every tile with its error and the pooled figure as a line, a panel per channel, for one ISO.

    Parameters
    ----------
    table
        Curve `prnu_tiles` of the ISO.
    published
        The study's figures of its own tiles, None where it has none.
    pooled
        The recommended row of each channel.
    iso
        Of the table.

    """
    groups = list(table.split("channel"))
    old = dict(published.split("channel")) if published is not None else {}
    figure, panels = grid_of(len(groups), panel_height_in=2.35, columns=max(len(groups), 2))
    for axes, (name, points) in zip(panels, groups, strict=True):
        channel = str(name)
        tile = np.arange(1, len(points) + 1)
        if (row := pooled.get(channel)) is not None:
            _level(axes, row)
        axes.errorbar(
            tile,
            points.numbers("prnu"),
            yerr=np.nan_to_num(points.numbers("std_error")),
            linestyle="none",
            marker=marker_of(channel),
            color=color_of(channel),
            elinewidth=1.0,
        )
        legacy = _published_tiles(old, channel)
        axes.plot(
            np.arange(1, len(legacy) + 1) + 0.25,
            legacy,
            linestyle="none",
            marker="D",
            color=QUIET,
            markerfacecolor="none",
        )
        axes.set_title(channel, color=color_of(channel))
        axes.set_xlabel("Tile")
        axes.locator_params(axis="y", nbins=5)
        axes.set_xticks([1, 4, 8, 12, 16] if len(tile) == 16 else tile.tolist())
    top = 1.08 * max(axes.get_ylim()[1] for axes in panels)
    for axes in panels:
        axes.set_ylim(0.0, top)
    panels[0].set_ylabel("PRNU [%]")
    extra = [
        key("tile", linestyle="none", marker="o"),
        key("whole plane"),
        key("published", color=QUIET, linestyle="none", marker="D"),
    ]
    figure.legend(extra)
    return picture(
        figure,
        alt=f"PRNU of every tile at {iso_title(_known(iso))}, a panel per channel, the whole plane as a line",
        caption=(
            f"PRNU of each tile of the central crop at {iso_title(_known(iso))} with one standard error, line by line; "
            "line and band: the recommended figure of the whole plane with its 95 % interval. Grey: the published "
            "figure of the study's own tile of that number (both greens averaged in G1 and G2)."
        ),
    )


def responses(pictures: Sequence[ResponsePicture]) -> Picture:
    """Draw the slopes of pixels as surfaces: the megapixel crop, and a tile of it."""
    figure, panels = grid_of(len(pictures), panel_height_in=3.1, columns=min(len(pictures), 2))
    for axes, one in zip(panels, pictures, strict=True):
        image = np.asarray(one.image, float)
        rows, across = (np.arange(size, dtype=float) for size in image.shape)
        space(axes)
        draw_surfaces(axes, [Surface(rows=rows, columns=across, values=image)], most=_TILE_FACETS)
        title = f"{one.title[:1].upper()}{one.title[1:]} [{show_unit(one.unit)}]"
        axes.set_title(textwrap.fill(title, _TITLE_WIDTH), loc="center")
    return picture(
        figure,
        alt="Slope of every pixel over exposure, as surfaces over the central megapixel and over one tile",
        caption=(
            f"Response of the pixels at {show_iso(pictures[0].iso)}: the slope of each over exposure. Over the crop "
            "the lens bends the surface; over one tile it is flat, and what is rough is PRNU and temporal noise "
            "together: the eye cannot tell them apart, only the noise of the frames can."
        ),
    )


def std_against_exposure(table: Table) -> Picture:
    """Draw the standard deviation of whole frames against exposure with its line, as published; a panel per ISO."""
    groups = list(table.split("iso"))
    figure, panels = grid_of(len(groups), panel_height_in=2.7, columns=max(2, min(3, len(groups))))
    for axes, (iso, points) in zip(panels, groups, strict=True):
        exposure = points.numbers("exposure_s")
        order = np.argsort(exposure)
        axes.plot(exposure, points.numbers("std"), linestyle="none", marker="o", color=INK, markerfacecolor="none")
        axes.plot(exposure[order], points.numbers("fitted")[order], color=INK, linewidth=1.1)
        axes.set_title(iso_title(_known(iso)))
        axes.set(xlabel="Exposure time [s]", ylabel="Standard deviation [DN]")
        axes.set(xlim=(0.0, 1.05 * float(np.nanmax(exposure))), ylim=(0.0, None))
        axes.locator_params(axis="both", nbins=5)
    return picture(
        figure,
        alt="Standard deviation of each lit frame against exposure with a straight line, as published",
        caption=(
            "As published: the standard deviation of each frame over its shading map against exposure; where the line "
            "meets no exposure was taken for DSNU. It holds the differences of the colours, shading that the map "
            "misses, and shot noise, none of which is a straight line: this intercept says nothing about the dark."
        ),
    )


def _level(axes: Axes, row: Row) -> None:
    """Draw a figure as a line and its 95 % interval as a band."""
    axes.axhline(row.measured.value, color=color_of(row.channel), linewidth=1.2)
    if row.measured.ci95:
        axes.axhspan(*row.measured.ci95, color=color_of(row.channel), alpha=0.15)


def _published_tiles(published: Mapping[Value, Table], channel: str) -> NDArray[np.float64]:
    """Return the study's figures of its own tiles: of the channel, else of the mean of both greens [%]."""
    theirs = published.get(channel, published.get("G") if channel in ("G1", "G2") else None)
    return np.empty(0) if theirs is None else theirs.numbers("prnu")


def _points(axes: Axes, place: Sequence[float], rows: Sequence[Row], *, marker: Marker, filled: bool) -> None:
    """Draw figures at places along the abscissa in the colours of their channels, with their intervals."""
    colors = [color_of(row.channel) for row in rows]
    values = [row.measured.value for row in rows]
    ends = [row.measured.ci95 or (row.measured.value, row.measured.value) for row in rows]
    axes.vlines(place, [low for low, _ in ends], [high for _, high in ends], colors=colors, linewidth=1.2)
    for x, y, color in zip(place, values, colors, strict=True):
        face = color if filled else "none"
        axes.plot(x, y, linestyle="none", marker=marker, color=color, markerfacecolor=face, markersize=4.7, zorder=2.5)


def _course(axes: Axes, rows: Sequence[Row], index: int, count: int) -> None:
    """Draw the recommended figures of one channel against ISO."""
    rows = sorted(rows, key=lambda row: row.iso or 0.0)
    if not rows:
        return
    iso = np.array([row.iso or np.nan for row in rows], float)
    value = np.array([row.measured.value for row in rows])
    ends = np.array([row.measured.ci95 or (row.measured.value, row.measured.value) for row in rows])
    axes.errorbar(
        beside(iso, index, count),
        value,
        yerr=(np.maximum(value - ends[:, 0], 0.0), np.maximum(ends[:, 1] - value, 0.0)),
        color=color_of(rows[0].channel),
        marker=marker_of(rows[0].channel),
        linewidth=1.0,
        elinewidth=0.9,
    )


def _positive_axis(axes: Axes, values: Sequence[float]) -> None:
    """Start the ordinate at zero, or make it logarithmic where the values lie many times apart."""
    shown: NDArray[np.float64] = np.array([value for value in values if value > 0.0])
    if shown.size and len(shown) == len(values) and shown.max() > _FEW_DECADES * shown.min():
        axes.margins(y=0.15)
        axes.set_yscale("log")
    else:
        axes.set_ylim(0.0, 1.08 * axes.get_ylim()[1])
        axes.locator_params(axis="y", nbins=5)


def _known(iso: Value) -> float | None:
    return iso if isinstance(iso, (int, float)) else None
