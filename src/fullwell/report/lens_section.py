"""The chapter on lens shading: how much light the lens brings to each place of the sensor."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Final

import numpy as np

from fullwell.figures.results import Row
from fullwell.raw.cfa import channel_rank
from fullwell.report import plots_lens
from fullwell.report.chosen_models import chosen_models
from fullwell.report.comparison import LEGACY
from fullwell.report.material import Material, Part, Section, Tab, drawn, parts_shown
from fullwell.report.numbers import MISSING, show, show_exposure, show_iso
from fullwell.report.pictures import ShadingPicture
from fullwell.report.pivots import Cell, Line, Note, Pivot, title_of, tooltip
from fullwell.units import PERCENT

_FIGURES: Final = ("shading_corner", "shading_edge_x", "shading_edge_y", "shading_residual_rms")
_MODELS: Final = "cos4-fixed cos4 radial poly22 poly44 poly66 poly88 p-spline"
"""In the order of the table."""

_RESIDUAL: Final = "shading_residual_rms"
_MARK: Final = "✓"
_ENOUGH: Final = 0.75
"""Share of the points that must be measured for a burst to stand for its ISO."""

Burst = tuple[float | None, float]


def lens_shading(material: Material) -> Section:
    """Return the chapter on lens shading."""
    bursts = _bursts(material.pictures.shading)
    shown = _one_per_iso(bursts)
    lowest = shown[:1]
    parts = parts_shown(
        Part(
            title="The map of each plane",
            lead="One burst per ISO: the longest exposure at which most planes are unsaturated.",
            tabs=tuple(
                Tab(label=_label(planes[0]), pictures=(plots_lens.shading_surfaces(planes),)) for planes in shown
            ),
        ),
        Part(title="The stacked map", pictures=(plots_lens.stacked_maps(_ends(shown)),) if shown else ()),
        _models(material, shown),
        _differences(material),
        Part(
            title="The cosine-fourth law",
            pictures=tuple(one for planes in lowest if (one := plots_lens.cosine_fourth(planes))),
        ),
        Part(
            title="The published polynomial",
            pictures=tuple(one for planes in lowest if (one := plots_lens.published_map(planes))),
        ),
        Part(
            title="Profiles before and after correction",
            pictures=drawn(material.table("shading_profile"), plots_lens.intensity_profiles),
        ),
    )
    return Section(
        anchor="lens-shading",
        title="Lens shading",
        lead=(
            "How much light the lens brings to each place of the sensor: fitted to every burst of flats and every CFA "
            "plane, black subtracted first, saturated and defective pixels left out."
        ),
        parts=parts,
        missing="" if parts else "No lens shading: capture bursts of evenly lit flat frames below saturation.",
    )


def _bursts(planes: Sequence[ShadingPicture]) -> dict[Burst, list[ShadingPicture]]:
    bursts: dict[Burst, list[ShadingPicture]] = {}
    for plane in planes:
        bursts.setdefault((plane.iso, plane.exposure_s), []).append(plane)
    return bursts


def _one_per_iso(bursts: dict[Burst, list[ShadingPicture]]) -> list[list[ShadingPicture]]:
    """Return the planes of one burst per ISO: the longest exposure that is (nearly) whole, ISOs ascending."""

    def whole(planes: Sequence[ShadingPicture]) -> tuple[bool, float]:
        share = min(float(np.isfinite(plane.measured).mean()) for plane in planes)
        return share >= _ENOUGH, planes[0].exposure_s

    isos = sorted({iso for iso, _ in bursts}, key=lambda iso: -1.0 if iso is None else iso)
    return [max((planes for (at, _), planes in bursts.items() if at == iso), key=whole) for iso in isos]


def _ends(bursts: Sequence[list[ShadingPicture]]) -> list[list[ShadingPicture]]:
    """Return the first and the last, of the lowest and the highest ISO."""
    return [bursts[0], bursts[-1]] if len(bursts) > 1 else list(bursts)


def _label(plane: ShadingPicture) -> str:
    return f"{show_iso(plane.iso)}, {show_exposure(plane.exposure_s)}"


def _models(material: Material, shown: Sequence[Sequence[ShadingPicture]]) -> Part:
    """Return the figures of every model: those of the bursts shown, else of the longest exposure of each ISO."""
    rows = [row for row in material.results.rows if row.quantity in _FIGURES and row.region is None]
    chosen = chosen_models(material.results.curves, material.pictures.shading)
    longest: dict[float | None, float] = {}
    for row in rows:
        longest[row.iso] = max(longest.get(row.iso, 0.0), row.exposure_s or 0.0)
    longest |= {planes[0].iso: planes[0].exposure_s for planes in shown}
    tabs: list[Tab] = []
    for iso in sorted(longest, key=lambda iso: -1.0 if iso is None else iso):
        mine = [row for row in rows if row.iso == iso and (row.exposure_s or 0.0) == longest[iso]]
        best = {row.channel: chosen.get((row.iso, row.exposure_s or 0.0, row.channel), "") for row in mine}
        made = tuple(table for quantity in _FIGURES if (table := _model_table(mine, quantity, best)))
        if made:
            tabs.append(Tab(label=f"{show_iso(iso)}, {show_exposure(longest[iso])}", pivots=made))
    return Part(
        title="What every model says",
        lead=(
            "Response relative to the maximum of the smooth surface, and the root mean square that the model leaves. "
            "Every other exposure stands under “Every row”."
            if tabs
            else ""
        ),
        tabs=tuple(tabs),
    )


def _model_table(rows: Sequence[Row], quantity: str, chosen: Mapping[str, str]) -> Pivot | None:
    """Return one figure of every model and channel, the chosen model of each channel marked."""
    percent = quantity == _RESIDUAL
    mine = [_in_percent(row) if percent else row for row in rows if row.quantity == quantity]
    if not mine:
        return None
    channels = tuple(sorted({row.channel for row in mine}, key=channel_rank))
    models = sorted({row.method for row in mine}, key=lambda name: (name.startswith(LEGACY), _MODELS.find(name), name))
    cells = {(row.method, row.channel): _cell(row, best=chosen[row.channel] == row.method) for row in mine}
    any_chosen = any(cell.marks for cell in cells.values())
    note = Note(mark=_MARK, text="the model chosen for this plane: the smallest within one standard error of the best")
    return Pivot(
        quantity=quantity,
        title=title_of(quantity),
        unit=PERCENT if percent else "",
        channels=channels,
        lines=tuple(
            Line(label=model, cells=tuple(cells.get((model, channel), Cell(text=MISSING)) for channel in channels))
            for model in models
        ),
        notes=(note,) if any_chosen else (),
    )


def _in_percent(row: Row) -> Row:
    return replace(row, measured=row.measured.scaled(100.0, PERCENT))


def _cell(row: Row, *, best: bool) -> Cell:
    return Cell(text=show(row.measured, row.flags), title=tooltip(row), marks=_MARK if best else "")


def _differences(material: Material) -> Part:
    pictures = material.pictures.shading_differences
    if not pictures:
        return Part(title="Does exposure or ISO change the map?")
    return Part(
        title="Does exposure or ISO change the map?",
        lead="Each map over that of the base burst, scale removed: per cent say how large, standard errors how sure.",
        tabs=(
            Tab(label="Difference [%]", pictures=(plots_lens.difference_grid(pictures, "difference"),)),
            Tab(label="Difference / standard error", pictures=(plots_lens.difference_grid(pictures, "over_error"),)),
        ),
    )
