"""The measurements of a report in their order: what each shows, and which capture is missing where it shows nothing."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Final

from fullwell import glossary
from fullwell.figures.results import Results, Row
from fullwell.report import plots_dark, plots_iso, plots_response, plots_transfer
from fullwell.report.curves import Table, Value, table_named
from fullwell.report.numbers import show_iso
from fullwell.report.pictures import Pictures
from fullwell.report.pivots import Pivot, pivot, recommended, title_of
from fullwell.report.plots import Picture, style
from fullwell.units import DECIBEL

_POSITION: Final = {entry.name: position for position, entry in enumerate(glossary.QUANTITIES)}


@dataclass(frozen=True, slots=True, kw_only=True)
class Tab:
    """The pictures of one ISO."""

    label: str
    pictures: tuple[Picture, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class Section:
    """One measurement: pictures, pictures per ISO, tables, or what is missing for it."""

    anchor: str
    title: str
    lead: str
    pictures: tuple[Picture, ...] = ()
    tabs: tuple[Tab, ...] = ()
    pivots: tuple[Pivot, ...] = ()
    missing: str = ""


@dataclass(frozen=True, slots=True, kw_only=True)
class Material:
    """What the sections are made from."""

    results: Results
    rows: tuple[Row, ...]
    pictures: Pictures

    def table(self, name: str) -> Table | None:
        """Return a curve as a table, None where it is missing or empty."""
        return table_named(self.results.curves, name)

    def pivots(self, *wanted: tuple[str, str]) -> tuple[Pivot, ...]:
        """Return the tables of some (quantity, unit) that have rows."""
        made = (pivot(self.rows, quantity, unit) for quantity, unit in wanted)
        return tuple(one for one in made if one)


def build_sections(results: Results, pictures: Pictures | None) -> tuple[Section, ...]:
    """Return every section of the report, pictures drawn."""
    material = Material(results=results, rows=recommended(results.rows), pictures=pictures or Pictures())
    makers: tuple[Callable[[Material], Section], ...] = (
        _against_iso,
        _photon_transfer,
        _signal_to_noise,
        _range,
        _read_noise,
        _lines,
        _dark_signal,
        _black_level,
        _nonuniformity,
        _differences,
        _exposure_series,
        _drift,
    )
    with style():
        made = [maker(material) for maker in makers]
    return tuple(one for one in made if one.pictures or one.tabs or one.pivots or one.missing)


def _drawn(table: Table | None, draw: Callable[[Table], Picture]) -> tuple[Picture, ...]:
    return (draw(table),) if table is not None else ()


def _over_isos(material: Material) -> dict[tuple[str, str], dict[float, list[Row]]]:
    """Return the figures measured at more than one ISO by quantity and unit, and within them by SNR threshold."""
    panels: dict[tuple[str, str], dict[float, list[Row]]] = {}
    for row in sorted(material.rows, key=_glossary_order):
        if row.iso is not None and row.exposure_s is None and not row.quantity.endswith("_variance"):
            thresholds = panels.setdefault((row.quantity, row.measured.unit), {})
            thresholds.setdefault(row.snr_threshold or 0.0, []).append(row)
    return {
        what: dict(sorted(thresholds.items()))
        for what, thresholds in panels.items()
        if len({row.iso for rows in thresholds.values() for row in rows}) > 1
    }


def _glossary_order(row: Row) -> tuple[int, str, int]:
    """Order rows by quantity as the glossary does, then by unit."""
    entry = glossary.quantity(row.quantity)
    if entry is None:
        return (len(glossary.QUANTITIES), row.quantity, 0)
    unit = row.measured.unit
    return (_POSITION.get(row.quantity, 0), row.quantity, entry.units.index(unit) if unit in entry.units else 9)


def _course(material: Material, caption: str, *wanted: tuple[str, str]) -> tuple[Picture, ...]:
    """Return one picture of some figures against ISO, nothing where none was measured at several."""
    several = _over_isos(material)
    panels: dict[tuple[str, str], list[Row]] = {}
    for quantity, unit in wanted:
        for threshold, rows in several.get((quantity, unit), {}).items():
            name = title_of(quantity)
            panels[(f"{name}, SNR {threshold:g}" if threshold else name, unit)] = rows
    titles = ", ".join(dict.fromkeys(title for title, _ in panels))
    return (plots_iso.against_iso(panels, alt=f"{titles} against ISO", caption=caption),) if panels else ()


def _against_iso(material: Material) -> Section:
    several = _over_isos(material)
    in_decibel = {quantity for quantity, unit in several if unit == DECIBEL}
    wanted = [(quantity, unit) for quantity, unit in several if unit == DECIBEL or quantity not in in_decibel]
    caption = (
        "Every figure against ISO, channels drawn side by side. Bars: 95 % interval; where none is seen it is smaller "
        "than the marker."
    )
    return Section(
        anchor="against-iso",
        title="Every figure against ISO",
        lead="All recommended figures of the study on one page, ratios in dB.",
        pictures=_course(material, caption, *wanted),
        missing="" if several else "One ISO only: nothing to compare. Capture the same series at further ISOs.",
    )


def _photon_transfer(material: Material) -> Section:
    table = material.table("photon_transfer")
    tabs = (
        tuple(
            Tab(label=_iso(iso), pictures=(plots_transfer.photon_transfer(part, iso),))
            for iso, part in table.split("iso")
        )
        if table
        else ()
    )
    return Section(
        anchor="photon-transfer",
        title="Photon transfer",
        lead=(
            "Light arrives as single electrons, so its noise tells how many there are: the variance of a lit pixel "
            "grows in proportion to its signal, and the factor is the system gain."
        ),
        tabs=tabs,
        pivots=material.pivots(("system_gain", "DN/e-"), ("conversion_factor", "e-/DN")),
        missing="" if table else "No photon transfer: it needs bursts of two or more flat frames at several exposures.",
    )


def _signal_to_noise(material: Material) -> Section:
    table = material.table("snr")
    return Section(
        anchor="snr",
        title="Signal-to-noise ratio",
        lead="How clean a signal of a given size is in one frame.",
        pictures=_drawn(table, plots_transfer.signal_to_noise),
        pivots=material.pivots(("snr_max", "dB"), ("snr_max", "1")),
        missing="" if table else "No SNR curve: it follows from photon transfer, which needs bursts of flat frames.",
    )


def _range(material: Material) -> Section:
    pivots = material.pivots(
        ("white_level", "DN"),
        ("saturation_capacity", "e-"),
        ("saturation_capacity", "DN"),
        ("dynamic_range", "dB"),
        ("dynamic_range", "EV"),
    )
    return Section(
        anchor="saturation",
        title="Saturation and dynamic range",
        lead="How much a pixel holds, and how many stops lie between that and the signal that equals its noise.",
        pictures=_course(
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


def _read_noise(material: Material) -> Section:
    table = material.table("read_noise_iso")
    pivots = material.pivots(
        ("read_noise", "DN"),
        ("read_noise", "e-"),
        ("read_noise", "V"),
        ("read_noise_pre", "DN"),
        ("read_noise_post", "DN"),
    )
    return Section(
        anchor="read-noise",
        title="Read noise",
        lead="Temporal noise of a pixel that sees no light, the rounding of the converter removed.",
        pictures=_drawn(table, plots_dark.read_noise_against_iso),
        pivots=pivots,
        missing="" if pivots or table else "No read noise: capture a burst of bias or short dark frames at each ISO.",
    )


def _lines(material: Material) -> Section:
    wanted = (
        ("read_noise_row", "DN"),
        ("read_noise_column", "DN"),
        ("read_noise_row", "e-"),
        ("read_noise_column", "e-"),
    )
    return Section(
        anchor="row-column-noise",
        title="Row and column noise",
        lead=(
            "The part of the temporal noise that a whole row or column shares. The eye finds it long before it "
            "reaches the noise of the pixels."
        ),
        pictures=_course(
            material,
            "Noise that a whole row or column shares, against ISO. Bars: 95 % interval; a marker at zero with a bar "
            "above it is an upper limit.",
            ("read_noise_row", "DN"),
            ("read_noise_column", "DN"),
        ),
        pivots=material.pivots(*wanted),
    )


def _dark_signal(material: Material) -> Section:
    table = material.table("dark_signal")
    return Section(
        anchor="dark-current",
        title="Dark signal and dark current",
        lead="What collects without light: the mean of the dark frames against exposure time, and its slope.",
        pictures=_drawn(table, plots_dark.dark_signal),
        pivots=material.pivots(("dark_current", "DN/s"), ("dark_current", "e-/s"), ("dark_current", "V/s")),
        missing=(
            "" if table else "No dark current: capture dark bursts at three or more exposures, the longest possible."
        ),
    )


def _black_level(material: Material) -> Section:
    table = material.table("dark_histogram")
    levels = {(row.iso, row.channel): row.measured.value for row in material.rows if row.quantity == "black_level"}
    return Section(
        anchor="black-level",
        title="Black level and the histogram around it",
        lead="Where zero light lies on the scale of raw values, and how the dark frames scatter around it.",
        pictures=_drawn(table, lambda points: plots_dark.dark_histogram(points, levels)),
        pivots=material.pivots(("black_level", "DN")),
        missing="" if table else "No dark histogram: capture bias or dark frames.",
    )


def _nonuniformity(material: Material) -> Section:
    wanted = (("dsnu", "DN"), ("dsnu", "e-"), ("prnu", "%"))
    return Section(
        anchor="nonuniformity",
        title="Fixed pattern",
        lead="What differs from pixel to pixel and stays from frame to frame, in the dark and under light.",
        pivots=material.pivots(*wanted),
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
        Tab(label=_iso(iso), pictures=(plots_response.exposure_series(_at(response, iso), _at(histograms, iso), iso),))
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
        pictures=_drawn(table, plots_dark.frame_means),
        pivots=material.pivots(("drift", "DN"), ("drift", "%")),
    )


def _iso(iso: Value) -> str:
    return show_iso(iso if isinstance(iso, (int, float)) else None)


def isos_of(rows: Sequence[Row]) -> tuple[float, ...]:
    """Return the ISOs that have figures, ascending."""
    return tuple(sorted({row.iso for row in rows if row.iso is not None}))
