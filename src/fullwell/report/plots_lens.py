"""Lens shading: surfaces of every plane, what the model leaves, the cosine-fourth law, differences between bursts."""

from collections.abc import Sequence
from dataclasses import replace
from typing import Final, Literal

import numpy as np
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.figure import Figure

from fullwell.raw.cfa import channel_rank, leading_channel
from fullwell.report.curves import Table
from fullwell.report.numbers import show_exposure, show_iso
from fullwell.report.pictures import ShadingDifferencePicture, ShadingPicture
from fullwell.report.plots import (
    INK,
    QUIET,
    Picture,
    channel_legend,
    color_of,
    grid_of,
    iso_title,
    key,
    pixel_picture,
    sheet,
    vector_picture,
)
from fullwell.report.plots_surface import (
    Surface,
    channel_colors,
    draw_map,
    draw_surfaces,
    space,
    symmetric_limit,
)

_PERCENT: Final = 100.0
_SMALL_FACETS: Final = 32
_SMALL_PT: Final = 7.5


def shading_surfaces(planes: Sequence[ShadingPicture]) -> Picture:
    """Draw raw, fitted and normalized surface and the residual of every plane of one burst, a plane per line."""
    planes = _ordered(planes)
    count = len(planes)
    height = 1.85 * count + 0.85
    figure = sheet(height)
    grid = figure.add_gridspec(
        count, 4, left=0.035, right=0.985, top=1.0 - 0.3 / height, bottom=0.55 / height, wspace=0.12, hspace=0.04
    )
    limit = symmetric_limit(*(_PERCENT * plane.residual for plane in planes), least=0.01)
    flat: list[Axes] = []
    shown: ScalarMappable | None = None
    for line, plane in enumerate(planes):
        for column, values in enumerate((plane.measured, plane.fitted, plane.normalized)):
            axes = space(figure, grid[line, column])
            draw_surfaces(axes, [_surface(plane, values)], most=_SMALL_FACETS)
            if line == 0:
                axes.set_title(("Measured [DN]", "Fitted [DN]", "Normalized")[column], loc="center", y=1.0)
            if column == 1:
                axes.text(0.92, 0.94, plane.model, transform=axes.transAxes, ha="center", size=7, color=QUIET)
        flat.append(figure.add_subplot(grid[line, 3]))
        shown = draw_map(flat[-1], _PERCENT * plane.residual, limit=limit)
        place = flat[-1].get_subplotspec()
        if line == 0:
            flat[-1].set_title("Left over [%]", loc="center")
        middle = 0.5 if place is None else float(np.mean(place.get_position(figure).intervaly))
        figure.text(
            0.012,
            middle,
            plane.channel,
            color=color_of(plane.channel),
            weight="bold",
            size=11,
            va="center",
            ha="center",
        )
    if shown is not None:
        _bar(figure, shown, flat, label="measured / fitted − 1 [%]")
    burst = _burst(planes[0].iso, planes[0].exposure_s)
    return pixel_picture(
        figure,
        colors=256,
        alt=f"Lens shading at {burst}: measured, fitted and normalized surface and residual map of each plane",
        caption=(
            f"Lens shading at {burst}, a CFA plane per line: mean of the burst above black, the chosen model, that "
            "over its value at the centre, and what it leaves. Axes: column and row of the plane. In a residual map "
            "noise looks like sand; rings or lobes would be shading that the model misses, spots are dust."
        ),
    )


def stacked_maps(bursts: Sequence[Sequence[ShadingPicture]]) -> Picture:
    """Draw the normalized surfaces of all planes together in one space, and over their mean; a line per burst."""
    height = 3.1 * len(bursts) + 0.35
    figure = sheet(height)
    grid = figure.add_gridspec(
        len(bursts), 2, left=0.06, right=0.94, top=1.0 - 0.5 / height, bottom=0.1 / height, wspace=0.1, hspace=0.16
    )
    for line, planes in enumerate(bursts):
        ordered = _ordered(planes)
        middle = np.mean([plane.normalized for plane in ordered], axis=0)
        together, apart = (space(figure, grid[line, column]) for column in range(2))
        draw_surfaces(together, [_surface(plane, plane.normalized, by_channel=True) for plane in ordered])
        over = [_surface(plane, _PERCENT * (plane.normalized / middle - 1.0), by_channel=True) for plane in ordered]
        draw_surfaces(apart, over)
        together.set_title(_burst(planes[0].iso, planes[0].exposure_s), loc="center", y=1.0)
        apart.set_title("Over the mean of the planes [%]", loc="center", y=1.0)
    channel_legend(figure, [plane.channel for planes in bursts for plane in planes])
    return pixel_picture(
        figure,
        colors=256,
        alt="Normalized lens-shading maps of all planes stacked in space, and each over the mean of the planes",
        caption=(
            "The stacked map: the normalized surfaces of all planes in one space (left), and each over the mean of all "
            "(right). Layers that part are colour shading: one map for all channels would tint the corners."
        ),
    )


def cosine_fourth(planes: Sequence[ShadingPicture]) -> Picture | None:
    """Draw map, cosine-fourth law and relative difference, flat and in space; None where no focal length is known."""
    planes = [plane for plane in _ordered(planes) if plane.cos4 is not None]
    if not planes:
        return None
    leading = leading_channel(plane.channel for plane in planes)
    lead = next(plane for plane in planes if plane.channel == leading)
    figure = sheet(5.3)
    grid = figure.add_gridspec(
        2, 3, left=0.03, right=0.96, top=0.9, bottom=0.03, wspace=0.14, hspace=0.06, height_ratios=(1.0, 1.25)
    )
    apart = [_PERCENT * (plane.normalized / _cos4(plane) - 1.0) for plane in planes]
    limit = symmetric_limit(*apart, share=100.0, least=0.01)
    titles = (f"Map of {leading}", "Cosine-fourth law", "Map / law − 1 [%]")
    flat = (lead.normalized, _cos4(lead), apart[planes.index(lead)])
    lowest = min(float(np.nanmin(plane.normalized)) for plane in planes)
    ends = (min(lowest, *(float(np.nanmin(_cos4(plane))) for plane in planes)), 1.0)
    for column, (title, values) in enumerate(zip(titles, flat, strict=True)):
        axes = figure.add_subplot(grid[0, column])
        shown = draw_map(axes, values, limit=limit if column == 2 else None)
        if column < 2:
            shown.set_clim(*ends)
        axes.set_title(title, loc="center")
        figure.colorbar(shown, ax=axes, shrink=0.9, aspect=18, pad=0.03).ax.tick_params(labelsize=_SMALL_PT)
    spaces = [space(figure, grid[1, column]) for column in range(3)]
    draw_surfaces(spaces[0], [_surface(plane, plane.normalized, by_channel=True) for plane in planes], limits=ends)
    draw_surfaces(spaces[1], [_surface(lead, _cos4(lead))], limits=ends)
    draw_surfaces(
        spaces[2],
        [_surface(plane, one, by_channel=True) for plane, one in zip(planes, apart, strict=True)],
    )
    channel_legend(figure, [plane.channel for plane in planes])
    return pixel_picture(
        figure,
        colors=256,
        alt="Lens-shading map, cosine-fourth law of the stated focal length, and their relative difference",
        caption=(
            f"The map at {_burst(lead.iso, lead.exposure_s)} beside the cosine-fourth law of the stated focal length: "
            f"above flat for {leading}, below in space with every plane. What parts them is vignetting in the lens, "
            "pixels that take slanted light less well, and decentring; a law of one number knows none of them."
        ),
    )


def published_map(planes: Sequence[ShadingPicture]) -> Picture | None:
    """Draw the study's own map over the chosen one, plane by plane; None where it is not known."""
    planes = [plane for plane in _ordered(planes) if plane.legacy is not None]
    if not planes:
        return None
    apart = [_PERCENT * (np.asarray(plane.legacy) / plane.normalized - 1.0) for plane in planes]
    figure = sheet(2.75)
    panels = [figure.add_subplot(1, max(len(planes), 3), index + 1) for index in range(len(planes))]
    figure.subplots_adjust(left=0.01, right=0.99, top=0.88, bottom=0.3, wspace=0.06)
    limit = symmetric_limit(*apart, share=99.5, least=0.01)
    shown: ScalarMappable | None = None
    for axes, plane, one in zip(panels, planes, apart, strict=True):
        shown = draw_map(axes, one, limit=limit)
        axes.set_title(f"{plane.channel}: corners {_percent(_corners(one))}")
        axes.title.set_color(color_of(plane.channel))
    if shown is not None:
        bar = figure.add_axes((0.3, 0.22, 0.4, 0.035))
        figure.colorbar(shown, cax=bar, orientation="horizontal", label="published map / chosen map − 1 [%]")
    return pixel_picture(
        figure,
        colors=256,
        alt="Relative difference of the published polynomial map to the chosen map, plane by plane",
        caption=(
            f"The published map over the chosen one at {_burst(planes[0].iso, planes[0].exposure_s)}. A polynomial of "
            "degree two is too stiff for a lens, and the pedestal left in makes the shading look weaker: scenes "
            "corrected with it come out wrong by as much."
        ),
    )


def difference_grid(
    pictures: Sequence[ShadingDifferencePicture], which: Literal["difference", "over_error"]
) -> Picture:
    """Draw the difference of every burst's map to the base map: exposures side by side, ISOs one below the other."""
    pictures = _with_base(pictures)
    exposures = _exposures(pictures)
    isos = sorted(exposures)
    columns = max(len(line) for line in exposures.values())
    relative = which == "difference"
    values = {id(one): _PERCENT * one.difference if relative else one.over_error for one in pictures}
    limit = symmetric_limit(*values.values(), least=0.01) if relative else max(3.0, symmetric_limit(*values.values()))
    height = 1.27 * len(isos) + 0.85
    figure = sheet(height)
    across = max(columns, 3)
    panels = figure.subplots(len(isos), across, squeeze=False)
    figure.subplots_adjust(
        left=0.075, right=0.99, top=1.0 - 0.3 / height, bottom=0.62 / height, wspace=0.06, hspace=0.28
    )
    shown: ScalarMappable | None = None
    for line, iso in zip(panels, isos, strict=True):
        ordered = exposures[iso]
        line[0].set_ylabel(show_iso(None if iso < 0.0 else iso), weight="bold", color=INK)
        for axes, one in zip(line, ordered, strict=False):
            shown = draw_map(axes, values[id(one)], limit=limit)
            told = "base" if _is_base(one) else f"p {_probability(one.p_value)}"
            axes.set_title(f"{show_exposure(one.exposure_s)}, {told}", size=_SMALL_PT, weight="normal", pad=3.0)
        for spare in line[len(ordered) :]:
            spare.set_visible(False)
    if shown is not None:
        bar = figure.add_axes((0.3, 0.4 / height, 0.45, 0.1 / height))
        label = "difference to the base map [%]" if relative else "difference / standard error"
        figure.colorbar(shown, cax=bar, orientation="horizontal", label=label, extend="both")
    base = _burst(pictures[0].base_iso, pictures[0].base_exposure_s)
    return pixel_picture(
        figure,
        colors=256,
        alt=f"Grid of differences of lens-shading maps to that of {base}, exposures across and ISOs down",
        caption=_grid_caption(base, relative=relative),
    )


def intensity_profiles(table: Table) -> Picture:
    """Draw the middle row before and after correction, one panel per ISO."""
    groups = list(table.split("iso"))
    figure, panels = grid_of(len(groups), panel_height_in=2.35)
    for axes, (iso, part) in zip(panels, groups, strict=True):
        for channel, points in part.split("channel"):
            column, color = points.numbers("column"), color_of(str(channel))
            order = np.argsort(column)
            axes.plot(column[order], points.numbers("before")[order], color=color, linewidth=0.9, linestyle="--")
            axes.plot(column[order], points.numbers("after")[order], color=color, linewidth=1.2)
        axes.set_title(iso_title(iso))
        axes.set(xlabel="Column [pixel]", ylabel="Signal above black [DN]")
        axes.set_ylim(0.0, 1.06 * axes.get_ylim()[1])
        axes.locator_params(axis="both", nbins=5)
    extra = [key("before", linestyle="--"), key("after")]
    channel_legend(figure, [str(channel) for channel, _ in table.split("channel")], extra)
    return vector_picture(
        figure,
        alt="Signal along the middle row before and after the correction of lens shading, one panel per ISO",
        caption=(
            "Signal along the middle row of the mean flat before (dashed) and after (line) the correction of lens "
            "shading. Flat lines are what the correction is for; ends that bend up would be a map that falls too fast."
        ),
    )


def _grid_caption(base: str, *, relative: bool) -> str:
    if relative:
        return (
            f"Difference of each burst's lens-shading map to that of {base}, mean over the CFA planes, on one scale. "
            "p: probability of so large a chi-square if the two maps were the same. Many small p say that exposure or "
            "ISO changes the map."
        )
    return (
        f"The same differences to {base} over their standard error. Within ±3 there is nothing but noise, however the "
        "per cent beside it look; structure beyond is real."
    )


def _ordered(planes: Sequence[ShadingPicture]) -> list[ShadingPicture]:
    return sorted(planes, key=lambda plane: channel_rank(plane.channel))


def _surface(plane: ShadingPicture, values: np.ndarray, *, by_channel: bool = False) -> Surface:
    if by_channel:
        return Surface(rows=plane.rows, columns=plane.columns, values=values, colors=channel_colors(plane.channel))
    return Surface(rows=plane.rows, columns=plane.columns, values=values)


def _cos4(plane: ShadingPicture) -> np.ndarray:
    return np.full_like(plane.normalized, np.nan) if plane.cos4 is None else plane.cos4


def _corners(values: np.ndarray) -> float:
    return float(np.mean([values[0, 0], values[0, -1], values[-1, 0], values[-1, -1]]))


def _percent(value: float) -> str:
    return f"{value:+.2g} %".replace("-", "\N{MINUS SIGN}")


def _probability(value: float) -> str:
    return "< 0.001" if value < 1e-3 else f"= {value:.2g}"


def _burst(iso: float | None, exposure_s: float) -> str:
    return f"{show_iso(iso)}, {show_exposure(exposure_s)}"


def _is_base(one: ShadingDifferencePicture) -> bool:
    return (one.iso, one.exposure_s) == (one.base_iso, one.base_exposure_s)


def _with_base(pictures: Sequence[ShadingDifferencePicture]) -> list[ShadingDifferencePicture]:
    """Return the pictures with the base burst among them, which differs from itself by nothing."""
    if any(_is_base(one) for one in pictures):
        return list(pictures)
    first = pictures[0]
    nothing = np.zeros_like(first.difference)
    base = replace(
        first,
        iso=first.base_iso,
        exposure_s=first.base_exposure_s,
        difference=nothing,
        over_error=nothing,
        p_value=1.0,
    )
    return [base, *pictures]


def _exposures(pictures: Sequence[ShadingDifferencePicture]) -> dict[float, list[ShadingDifferencePicture]]:
    """Return the bursts of each ISO (-1: unknown), exposures ascending."""
    groups: dict[float, list[ShadingDifferencePicture]] = {}
    for one in sorted(pictures, key=lambda one: one.exposure_s):
        groups.setdefault(-1.0 if one.iso is None else one.iso, []).append(one)
    return groups


def _bar(figure: Figure, shown: ScalarMappable, below: Sequence[Axes], *, label: str) -> None:
    """Draw the colour bar of a column of maps right below it."""
    box = below[-1].get_position()
    height = figure.get_figheight()
    bar = figure.add_axes((box.x0 + 0.02, box.y0 - 0.14 / height, box.width - 0.04, 0.08 / height))
    figure.colorbar(shown, cax=bar, orientation="horizontal", label=label).ax.tick_params(labelsize=_SMALL_PT)
