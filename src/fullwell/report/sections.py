"""The measurements of a report in their order: what each shows, and which capture is missing where it shows nothing."""

from collections.abc import Callable
from typing import Final

from fullwell.figures.results import Results
from fullwell.report import plots_dark, plots_response, plots_transfer
from fullwell.report.chart_sections import chart_sections, charts_alone
from fullwell.report.curves import Table, Value
from fullwell.report.lens_section import lens_shading
from fullwell.report.loop_section import loop_chapter
from fullwell.report.material import (
    Material,
    Section,
    Tab,
    course,
    drawn,
    iso_label,
    iso_tabs,
    material_of,
    over_isos,
)
from fullwell.report.noise_sections import dark_signal, lines, read_noise
from fullwell.report.numbers import show_iso
from fullwell.report.pattern_section import fixed_pattern
from fullwell.report.pictures import Pictures
from fullwell.units import DECIBEL


def build_sections(results: Results, pictures: Pictures | None) -> tuple[Section, ...]:
    """Return every section of the report, pictures drawn."""
    material = material_of(results, pictures)
    made = [] if charts_alone(material) else [maker(material) for maker in _MAKERS]
    return (*loop_chapter(material), *(section for section in made if section.shown), *chart_sections(material))


def _against_iso(material: Material) -> Section:
    several = over_isos(material)
    in_decibel = {quantity for quantity, unit in several if unit == DECIBEL}
    wanted = [
        (quantity, unit)
        for quantity, unit in several
        if (unit == DECIBEL or quantity not in in_decibel) and not _is_part(quantity)
    ]
    caption = (
        "Every figure against ISO, channels drawn side by side. Bars: 95 % interval; where none is seen it is smaller "
        "than the marker."
    )
    return Section(
        anchor="against-iso",
        title="Every figure against ISO",
        lead="All recommended figures of the study on one page, ratios in dB.",
        pictures=course(material, caption, *wanted),
        missing="" if several else "One ISO only: nothing to compare. Capture the same series at further ISOs.",
    )


def _is_part(quantity: str) -> bool:
    """Tell whether a quantity is only a part of DSNU or PRNU, shown in their own chapter."""
    return quantity.startswith(("dsnu_", "prnu_"))


def _photon_transfer(material: Material) -> Section:
    table = material.table("photon_transfer")
    return Section(
        anchor="photon-transfer",
        title="Photon transfer",
        lead=(
            "Light arrives as single electrons, so its noise tells how many there are: the variance of a lit pixel "
            "grows in proportion to its signal, and the factor is the system gain."
        ),
        tabs=iso_tabs(table, plots_transfer.photon_transfer),
        pivots=material.pivots(("system_gain", "DN/e-"), ("conversion_factor", "e-/DN")),
        missing="" if table else "No photon transfer: it needs bursts of two or more flat frames at several exposures.",
    )


def _signal_to_noise(material: Material) -> Section:
    table = material.table("snr")
    return Section(
        anchor="snr",
        title="Signal-to-noise ratio",
        lead="How clean a signal of a given size is in one frame.",
        pictures=drawn(table, plots_transfer.signal_to_noise),
        pivots=material.pivots(("snr_max", "dB"), ("snr_max", "1")),
        missing="" if table else "No SNR curve: it follows from photon transfer, which needs bursts of flat frames.",
    )


def _range(material: Material) -> Section:
    pivots = material.pivots(
        ("white_level", "DN"),
        ("digital_maximum", "DN"),
        ("saturation_capacity", "e-"),
        ("saturation_capacity", "DN"),
        ("dynamic_range", "dB"),
        ("dynamic_range", "EV"),
    )
    return Section(
        anchor="saturation",
        title="Saturation and dynamic range",
        lead="How much a pixel holds, and how many stops lie between that and the signal that equals its noise.",
        pictures=course(
            material,
            "Saturation capacity and dynamic range against ISO: amplification buys lower read noise with a lower "
            "ceiling.",
            ("saturation_capacity", "e-"),
            ("dynamic_range", "dB"),
            ("snr_max", "dB"),
        ),
        pivots=pivots,
        missing="" if pivots else "No saturation: capture flat bursts up to and beyond saturation.",
    )


def _black_level(material: Material) -> Section:
    table = material.table("dark_histogram")
    levels = {(row.iso, row.channel): row.measured.value for row in material.rows if row.quantity == "black_level"}
    return Section(
        anchor="black-level",
        title="Black level and the histogram around it",
        lead="Where zero light lies on the scale of raw values, and how the dark frames scatter around it.",
        pictures=drawn(table, lambda points: plots_dark.dark_histogram(points, levels)),
        pivots=material.pivots(("black_level", "DN")),
        missing="" if table else "No dark histogram: capture bias or dark frames.",
    )


def _differences(material: Material) -> Section:
    zooms = material.pictures.dark_zooms
    tabs = tuple(
        Tab(label=show_iso(picture.iso), pictures=(plots_dark.difference(picture),))
        for picture in material.pictures.differences
    )
    return Section(
        anchor="differences",
        title="Difference of two frames",
        lead="Subtracting one dark frame from the next leaves temporal noise alone: it should look like nothing.",
        tabs=tabs,
        pictures=(plots_dark.zooms(zooms),) if zooms else (),
    )


def _exposure_series(material: Material) -> Section:
    response, histograms = material.table("exposure_response"), material.table("flat_histogram")
    isos: dict[Value, None] = {}
    for table in (response, histograms):
        isos |= dict.fromkeys(iso for iso, _ in table.split("iso")) if table else {}
    tabs = tuple(
        Tab(
            label=iso_label(iso),
            pictures=(plots_response.exposure_series(_at(response, iso), _at(histograms, iso), iso),),
        )
        for iso in sorted(isos, key=lambda iso: float(iso) if isinstance(iso, (int, float)) else -1.0)
    )
    return Section(
        anchor="exposure-series",
        title="Exposure series",
        lead="Does twice the exposure give twice the signal, and where does the scale end?",
        tabs=tabs,
        missing="" if tabs else "No exposure series: capture flat frames at several exposures.",
    )


def _at(table: Table | None, iso: Value) -> Table | None:
    if table is None:
        return None
    part = table.chosen(value == iso for value in table.values("iso"))
    return part if len(part) else None


def _drift(material: Material) -> Section:
    table = material.table("frame_means")
    return Section(
        anchor="drift",
        title="Steadiness over a series",
        lead="Whether camera and light kept still while a burst was taken.",
        pictures=drawn(table, plots_dark.frame_means),
        pivots=material.pivots(("drift", "DN"), ("drift", "%")),
    )


_MAKERS: Final[tuple[Callable[[Material], Section], ...]] = (
    _against_iso,
    _photon_transfer,
    _signal_to_noise,
    _range,
    read_noise,
    lines,
    dark_signal,
    _black_level,
    lens_shading,
    fixed_pattern,
    _differences,
    _exposure_series,
    _drift,
)
