"""Lens shading: surfaces of every plane, what the model leaves, the cosine-fourth law, differences between bursts."""

from collections.abc import Sequence
from dataclasses import replace
from typing import Final, Literal

import numpy as np

from fullwell.raw.cfa import channel_rank, leading_channel
from fullwell.report.curves import Table
from fullwell.report.drawing import Figure, key
from fullwell.report.drawing.images import Shown
from fullwell.report.drawing.style import INK, QUIET
from fullwell.report.numbers import show_change, show_exposure, show_iso
from fullwell.report.pictures import ShadingDifferencePicture, ShadingPicture
from fullwell.report.plots import WIDTH_IN, Picture, canvas, channel_legend, color_of, grid_of, iso_title, picture
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
_SURFACES: Final = ("Measured [DN]", "Fitted [DN]", "Normalized", "Left over [%]")
_SMALL_PT: Final = 7.5


def shading_surfaces(planes: Sequence[ShadingPicture]) -> Picture:
    """Draw raw, fitted and normalized surface and the residual of every plane of one burst, a plane per line."""
    planes = _ordered(planes)
    figure, panels = canvas(len(planes), 4, height_in=1.85 * len(planes) + 0.55)
    limit = symmetric_limit(*(_PERCENT * plane.residual for plane in planes), least=0.01)
    for line, plane in enumerate(planes):
        *spaces, flat = panels[4 * line : 4 * line + 4]
        for axes, values in zip(spaces, (plane.measured, plane.fitted, plane.normalized), strict=True):
            space(axes)
            draw_surfaces(axes, [_surface(plane, values)], most=_SMALL_FACETS)
        spaces[0].set_ylabel(plane.channel, color=color_of(plane.channel), bold=True, size=11.0, turned=False)
        spaces[1].text(0.92, 0.94, plane.model, x_share=True, y_share=True, ha="center", size=7.0, color=QUIET)
        shown = draw_map(flat, _PERCENT * plane.residual, limit=limit)
        if line == 0:
            for axes, title in zip((*spaces, flat), _SURFACES, strict=True):
                axes.set_title(title, loc="center")
        if line == len(planes) - 1:
            flat.colorbar(shown, label="measured / fitted − 1 [%]", size=8.5)
    burst = _burst(planes[0].iso, planes[0].exposure_s)
    return picture(
        figure,
        alt=f"Lens shading at {burst}: measured, fitted and normalized surface and residual map of each plane",
        caption=(
            f"Lens shading at {burst}, a CFA plane per line: mean of the burst above black, the chosen model, that "
            "over its value at the centre, and what it leaves. Axes: column and row of the plane. In a residual map "
            "noise looks like sand; rings or lobes would be shading that the model misses, spots are dust."
        ),
    )


def stacked_maps(bursts: Sequence[Sequence[ShadingPicture]]) -> Picture:
    """Draw the normalized surfaces of all planes together in one space, and over their mean; a line per burst."""
    figure, panels = canvas(len(bursts), 2, height_in=3.1 * len(bursts) + 0.35)
    for line, planes in enumerate(bursts):
        ordered = _ordered(planes)
        middle = np.mean([plane.normalized for plane in ordered], axis=0)
        together, apart = panels[2 * line : 2 * line + 2]
        space(together)
        space(apart)
        draw_surfaces(together, [_surface(plane, plane.normalized, by_channel=True) for plane in ordered])
        over = [_surface(plane, _PERCENT * (plane.normalized / middle - 1.0), by_channel=True) for plane in ordered]
        draw_surfaces(apart, over)
        together.set_title(_burst(planes[0].iso, planes[0].exposure_s), loc="center")
        apart.set_title("Over the mean of the planes [%]", loc="center")
    channel_legend(figure, [plane.channel for planes in bursts for plane in planes])
    return picture(
        figure,
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
    apart = [_PERCENT * (plane.normalized / _cos4(plane) - 1.0) for plane in planes]
    limit = symmetric_limit(*apart, share=100.0, least=0.01)
    titles = (f"Map of {leading}", "Cosine-fourth law", "Map / law − 1 [%]")
    flat = (lead.normalized, _cos4(lead), apart[planes.index(lead)])
    lowest = min(float(np.nanmin(plane.normalized)) for plane in planes)
    ends = (min(lowest, *(float(np.nanmin(_cos4(plane))) for plane in planes)), 1.0)
    figure = Figure((WIDTH_IN, 5.3))
    above, spaces = figure.grid(2, 3, heights=(1.0, 1.25)).lines()
    for axes, title, values, about_zero in zip(above, titles, flat, (False, False, True), strict=True):
        shown = draw_map(axes, values, limit=limit if about_zero else None, ends=None if about_zero else ends)
        axes.set_title(title, loc="center")
        axes.colorbar(shown, location="right", share=0.9, size=_SMALL_PT + 1.0)
    for axes in spaces:
        space(axes)
    draw_surfaces(spaces[0], [_surface(plane, plane.normalized, by_channel=True) for plane in planes], limits=ends)
    draw_surfaces(spaces[1], [_surface(lead, _cos4(lead))], limits=ends)
    draw_surfaces(
        spaces[2],
        [_surface(plane, one, by_channel=True) for plane, one in zip(planes, apart, strict=True)],
    )
    channel_legend(figure, [plane.channel for plane in planes])
    return picture(
        figure,
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
    figure, panels = grid_of(len(planes), panel_height_in=2.4, columns=max(len(planes), 3))
    limit = symmetric_limit(*apart, share=99.5, least=0.01)
    shown = [draw_map(axes, one, limit=limit) for axes, one in zip(panels, apart, strict=True)]
    figure.colorbar(shown[0], label="published map / chosen map − 1 [%]")
    for axes, plane, one in zip(panels, planes, apart, strict=True):
        axes.set_title(f"{plane.channel}: corners {_percent(_corners(one))}", color=color_of(plane.channel))
    return picture(
        figure,
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
    figure, panels = canvas(len(isos), max(columns, 3), height_in=1.27 * len(isos) + 0.75)
    shown: list[Shown] = []
    for axes in panels:
        axes.visible = False
    for line, iso in enumerate(isos):
        ordered = exposures[iso]
        row = panels[line * max(columns, 3) :]
        row[0].set_ylabel(show_iso(None if iso < 0.0 else iso), bold=True, color=INK)
        for axes, one in zip(row, ordered, strict=False):
            axes.visible = True
            shown.append(draw_map(axes, values[id(one)], limit=limit))
            told = "base" if _is_base(one) else f"p {_probability(one.p_value)}"
            axes.set_title(f"{show_exposure(one.exposure_s)}, {told}", size=_SMALL_PT, bold=False)
    label = "difference to the base map [%]" if relative else "difference / standard error"
    figure.colorbar(shown[0], label=label, extend=True)
    base = _burst(pictures[0].base_iso, pictures[0].base_exposure_s)
    return picture(
        figure,
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
    return picture(
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
    return f"{show_change(value)} %"


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
