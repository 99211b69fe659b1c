"""The chapters on shots of a chart, drawn from these curves; each chapter appears only where its curve exists.

``chart_points``
    iso, scene, exposure, exposure_s [s], frames, patch, channel, density, mean [DN], signal [DN], variance [DN^2],
    variance_std_error [DN^2], dof, temporal_variance [DN^2], clipped, fitted [DN^2], residual, used (yes, no).
    Every patch of every channel at every exposure, 0 the brightest; ``signal`` is counted from the black level of the
    channel, ``variance`` is that of a single frame.
``chart_noise_model``
    iso, channel, dark [DN^2], shot [DN/e-], fixed_pattern, black_level [DN], digital_maximum [DN], convention,
    deviance, deviance_dof. The variance is dark + shot S + fixed_pattern S^2; channel ``all`` is the model that all
    share.
``chart_tonal_response``
    iso, channel, patch, log_exposure, log_pixel, log_signal, slope. Logarithms to base 10, black level left in and
    taken off.
``chart_bracket``
    iso, scene, channel, patch, exposure, ratio, mean [DN], signal [DN], residual, used (yes, no).

Pictures come as `ChartPicture` and `RenderedPoints`; tables from the rows.
"""

from collections.abc import Callable, Sequence
from typing import Final, TypeAlias

from fullwell.figures.results import Row
from fullwell.report import plots_chart, plots_chart_levels, plots_chart_scene
from fullwell.report.chart_tables import (
    black_level_table,
    black_levels,
    black_patch_table,
    capacity_table,
    coefficient_facts,
    coefficients_table,
    one_curve,
    range_table,
    range_words,
    ratio_facts,
    rows_of_charts,
    saturation_of,
)
from fullwell.report.curves import Table, Value
from fullwell.report.material import Material, Part, Section, Tab, iso_label, parts_shown
from fullwell.report.plots import Picture
from fullwell.report.plots_chart_model import leading_curve, noise_curves

POINTS: Final = "chart_points"
MODELS: Final = "chart_noise_model"
_CHART: Final = "chart_"
_LOOP: Final = "loop_"

Drawn: TypeAlias = list[tuple[Value, tuple[Picture | None, ...]]]


def charts_alone(material: Material) -> bool:
    """Tell whether nothing but shots of charts was measured: then no other chapter has anything to ask for."""
    names = [curve.name for curve in material.results.curves if not curve.name.startswith(_LOOP)]
    return bool(names) and all(name.startswith(_CHART) for name in names)


def chart_sections(material: Material) -> tuple[Section, ...]:
    """Return the chapters on charts; none where no chart was measured."""
    if material.table(POINTS) is None and not material.pictures.charts:
        return ()
    rows = rows_of_charts(material.results.rows)
    made = (maker(material, rows) for maker in _MAKERS)
    return tuple(section for section in made if section.shown)


def _chart(material: Material, _rows: Sequence[Row]) -> Section:
    shown = material.pictures.charts
    tabs = tuple(
        Tab(label=picture.title, pictures=(plots_chart_scene.annotated_chart(picture),)) for picture in shown[:8]
    )
    return Section(
        anchor="chart",
        title="The chart",
        lead="Where the patches lie. Every figure of this report is read inside these outlines.",
        pictures=tabs[0].pictures if len(tabs) == 1 else (),
        tabs=tabs if len(tabs) > 1 else (),
    )


def _noise_model(material: Material, rows: Sequence[Row]) -> Section:
    def draw(points: Table, models: Table, iso: Value) -> tuple[Picture | None, ...]:
        at = _known(iso)
        leading = leading_curve(noise_curves(models))
        level = saturation_of(rows, at)
        saturation = level / leading.digital_maximum if level is not None and leading is not None else None
        return (
            plots_chart.noise_curve(
                points, models, iso, facts=coefficient_facts(rows, at), one_curve=one_curve(rows, at)
            ),
            plots_chart.snr_curve(
                points,
                models,
                iso,
                facts=ratio_facts(rows, at),
                saturation=saturation,
                range_text=range_words(rows, at),
            ),
        )

    def beside(points: Table, models: Table, iso: Value) -> tuple[Picture | None, ...]:
        of_iso = [one for one in material.pictures.rendered if one.iso == _known(iso)]
        return tuple(plots_chart.jumbled(points, models, iso, one) for one in of_iso)

    curves, developed = _per_iso(material, draw), _per_iso(material, beside)
    return Section(
        anchor="noise-model",
        title="Noise model from the chart",
        lead=(
            "Three numbers tell the noise of the sensor at any signal: dark noise, shot noise, fixed pattern. "
            "Every patch of the chart is one measurement of their sum."
        ),
        pictures=_pictures(curves),
        tabs=_tabs(curves),
        tables=coefficients_table(rows),
        parts=parts_shown(
            Part(
                title="The same scene, developed",
                lead="Why noise is measured in raw files.",
                pictures=_pictures(developed),
                tabs=_tabs(developed),
            )
        ),
    )


def _black_level(material: Material, rows: Sequence[Row]) -> Section:
    bracket = material.table("chart_bracket")
    exposures: Drawn = []
    if bracket is not None:
        exposures = [(iso, (plots_chart_levels.proportional_exposures(one, iso),)) for iso, one in bracket.split("iso")]
    clusters = _per_iso(material, lambda points, models, iso: (plots_chart_levels.clustering(points, models, iso),))
    return Section(
        anchor="chart-black-level",
        title="Black level from the chart",
        lead=(
            "Every signal is counted from the raw value of no light. No noise measurement of one exposure can tell "
            "it: stray light looks the same. What else is known is weighed here."
        ),
        pictures=_pictures(clusters),
        tabs=_tabs(clusters),
        tables=black_level_table(rows),
        parts=parts_shown(
            Part(title="Exposures of one scene", pictures=_pictures(exposures), tabs=_tabs(exposures)),
        ),
    )


def _tonal_response(material: Material, rows: Sequence[Row]) -> Section:
    table = material.table("chart_tonal_response")
    found: Drawn = []
    if table is not None:
        found = [
            (iso, (plots_chart_levels.tonal_response(part, black_levels(rows, _known(iso)), iso),))
            for iso, part in table.split("iso")
        ]
    return Section(
        anchor="tonal-response",
        title="Tonal response",
        lead="Does the raw value follow the light of the patch, and what lifts the dark ones?",
        pictures=_pictures(found),
        tabs=_tabs(found),
        pivots=material.pivots(("flare", "1"), ("channel_ratio", "1")),
    )


def _against_exposure(material: Material, _rows: Sequence[Row]) -> Section:
    found = _per_iso(material, lambda points, _, iso: (plots_chart_scene.against_density(points, iso),))
    return Section(
        anchor="noise-against-exposure",
        title="Noise and SNR against exposure",
        lead="How the camera as a whole sees the patches: by the light they send, not by the raw value they make.",
        pictures=_pictures(found),
        tabs=_tabs(found),
    )


def _ranges(_material: Material, rows: Sequence[Row]) -> Section:
    return Section(
        anchor="chart-range",
        title="Dynamic range of sensor and camera",
        lead=(
            "The sensor's range ends where noise drowns the signal; the camera's ends earlier, where stray light "
            "and its noise lie over the dark parts of the scene."
        ),
        tables=(*range_table(rows), *black_patch_table(rows), *capacity_table(rows)),
    )


_MAKERS: Final[tuple[Callable[[Material, Sequence[Row]], Section], ...]] = (
    _chart,
    _noise_model,
    _tonal_response,
    _against_exposure,
    _black_level,
    _ranges,
)


def _per_iso(material: Material, draw: Callable[[Table, Table, Value], tuple[Picture | None, ...]]) -> Drawn:
    """Return pictures of every ISO that has points and models."""
    points, models = material.table(POINTS), material.table(MODELS)
    if points is None:
        return []
    by_iso = dict(models.split("iso")) if models is not None else {}
    empty = Table(columns=())
    return [(iso, draw(part, by_iso.get(iso, empty), iso)) for iso, part in points.split("iso")]


def _kept(found: Drawn) -> list[tuple[Value, tuple[Picture, ...]]]:
    kept = [(iso, tuple(picture for picture in pictures if picture is not None)) for iso, pictures in found]
    return [(iso, pictures) for iso, pictures in kept if pictures]


def _pictures(found: Drawn) -> tuple[Picture, ...]:
    """Return the pictures where there is one ISO; those of several go into tabs."""
    kept = _kept(found)
    return kept[0][1] if len(kept) == 1 else ()


def _tabs(found: Drawn) -> tuple[Tab, ...]:
    kept = _kept(found)
    return tuple(Tab(label=iso_label(iso), pictures=pictures) for iso, pictures in kept) if len(kept) > 1 else ()


def _known(iso: Value) -> float | None:
    return iso if isinstance(iso, (int, float)) else None
