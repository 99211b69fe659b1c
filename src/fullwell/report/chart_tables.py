"""The tables of the chapters on charts: black-level evidence, coefficients beside published fits, dynamic range."""

import math
from collections.abc import Sequence
from typing import Final

from fullwell import glossary
from fullwell.figures.results import Row
from fullwell.raw.cfa import channel_rank, leading_channel
from fullwell.report.material import WordTable
from fullwell.report.numbers import MISSING, show, show_interval, show_iso, show_plain
from fullwell.report.pivots import describe_flag
from fullwell.units import DECIBEL, DN, ELECTRON, STOP, Measured

CHART_REGION: Final = "chart"
"""Region of a chart's rows in a study whose other frames tell the same figures."""

_COEFFICIENTS: Final = ("k_dark", "k_shot", "k_fpn")
_FITS: Final = ("gamma-likelihood", "legacy-imatest-variance", "legacy-imatest-sigma")
_EVIDENCE: Final = (
    "fused",
    "exposure-bracket",
    "dark-frames",
    "optical-black",
    "metadata",
    "user",
    "legacy-offset-ratio",
)
_CAPACITIES: Final = ("temporal-variance-peak", "plateau", "last-consistent-level", "legacy-max-noise-patch")
_RANGES: Final = (
    ("Sensor [dB]", ("dynamic_range", "noise-model", DECIBEL)),
    ("Sensor [EV]", ("dynamic_range", "noise-model", STOP)),
    ("Camera [dB]", ("camera_dynamic_range", "scene-referenced", DECIBEL)),
    ("Camera [EV]", ("camera_dynamic_range", "scene-referenced", STOP)),
    ("Read off patches, as published [dB]", ("dynamic_range", "legacy-patch", DECIBEL)),
)
_SENSOR: Final = "Sensor: from saturation down to where the signal-to-noise ratio reaches the level."
_CAMERA: Final = "Camera: the same for the light of the scene, with the stray light of the lens on top."
_PATCH: Final = "patch:"


def rows_of_charts(rows: Sequence[Row]) -> tuple[Row, ...]:
    """Return the rows that a chart can have written: its own where other frames of the study have told the same."""
    own = {_figure(row) for row in rows if row.region == CHART_REGION}
    return tuple(
        row
        for row in rows
        if row.region == CHART_REGION
        or (row.region is None and _figure(row) not in own)
        or (row.region or "").startswith(_PATCH)
    )


def _figure(row: Row) -> tuple[object, ...]:
    return (row.quantity, row.channel, row.method, row.measured.unit, row.iso, row.snr_threshold)


def show_figure(row: Row) -> str:
    """Return value and standard error of a row; the interval where no one value can be quoted."""
    unknown = "offset-not-identified" in row.flags and row.quantity != "black_level"
    if unknown and not row.method.startswith("legacy-") and row.measured.ci95 is not None:
        return show_interval(row.measured)
    return show(row.measured, row.flags)


def black_level_table(rows: Sequence[Row]) -> tuple[WordTable, ...]:
    """Return what every piece of evidence says of the black level, channel by channel; empty without rows."""
    mine = [row for row in rows if row.quantity == "black_level" and row.measured.unit == DN]
    if not mine:
        return ()
    channels = _channels(mine)
    isos = _isos(mine)
    lines: list[tuple[str, ...]] = []
    for iso in isos:
        for method in _methods(mine, iso, _EVIDENCE):
            cells = (_cell(mine, iso, method, channel) for channel in channels)
            lines.append((*_iso_cell(isos, iso), method, *cells, _flags([row for row in mine if row.method == method])))
    return (
        WordTable(
            title="Evidence for the black level [DN]",
            head=(*_iso_head(isos), "Evidence", *channels, "Flags"),
            lines=tuple(lines),
            note=" ".join([*_explanations(mine, _EVIDENCE), _flag_note(mine)]),
        ),
    )


def coefficients_table(rows: Sequence[Row]) -> tuple[WordTable, ...]:
    """Return the noise coefficients beside those of the published fits; empty without rows."""
    mine = [row for row in rows if row.quantity in _COEFFICIENTS and row.method in _FITS]
    if not mine:
        return ()
    isos = _isos(mine)
    lines: list[tuple[str, ...]] = []
    for iso in isos:
        for channel in _channels([row for row in mine if row.iso == iso]):
            for method in _methods([row for row in mine if row.channel == channel], iso, _FITS):
                of_one = {row.quantity: row for row in mine if _is(row, iso, method, channel)}
                cells = (show_figure(of_one[name]) if name in of_one else MISSING for name in _COEFFICIENTS)
                lines.append((*_iso_cell(isos, iso), channel, method, *cells, _flags(list(of_one.values()))))
    return (
        WordTable(
            title="Noise coefficients, beside the published fits",
            head=(*_iso_head(isos), "Channel", "Fit", *_COEFFICIENTS, "Flags"),
            lines=tuple(lines),
            note="Over the digital maximum D. " + _flag_note(mine),
        ),
    )


def range_table(rows: Sequence[Row]) -> tuple[WordTable, ...]:
    """Return the dynamic range of sensor and camera at each quality level, for all channels together."""
    names = ("dynamic_range", "camera_dynamic_range")
    mine = [row for row in rows if row.quantity in names and row.region in (None, CHART_REGION)]
    mine = _of_leading([row for row in mine if row.snr_threshold is not None])
    if not mine:
        return ()
    isos = _isos(mine)
    present = {_kind(row) for row in mine}
    columns = [(title, kind) for title, kind in _RANGES if kind in present]
    camera = any(quantity == "camera_dynamic_range" for quantity, _, _ in present)
    lines: list[tuple[str, ...]] = []
    for iso in isos:
        for threshold in sorted({row.snr_threshold or 1.0 for row in mine if row.iso == iso}):
            found = {_kind(row): row for row in mine if row.iso == iso and row.snr_threshold == threshold}
            cells = (show_figure(found[kind]) if kind in found else MISSING for _, kind in columns)
            lines.append((*_iso_cell(isos, iso), f"{20.0 * math.log10(threshold):.3g} dB", f"{threshold:.3g}", *cells))
    return (
        WordTable(
            title=f"Dynamic range at each quality level{_whose(mine)}",
            head=(*_iso_head(isos), "Quality level", "SNR", *(title for title, _ in columns)),
            lines=tuple(lines),
            note=" ".join([_SENSOR, *([_CAMERA] if camera else []), _flag_note(mine)]),
        ),
    )


def black_patch_table(rows: Sequence[Row]) -> tuple[WordTable, ...]:
    """Return the clipping level over the noise of a dark patch, the figure that resembles that of ISO 15739."""
    mine = _of_leading([row for row in rows if row.method == "iso15739-like"])
    if not mine:
        return ()
    isos = _isos(mine)
    lines: list[tuple[str, ...]] = []
    for iso in isos:
        regions = dict.fromkeys(row.region for row in mine if row.iso == iso)
        for region in regions:
            found = {row.measured.unit: row for row in mine if (row.iso, row.region) == (iso, region)}
            cells = (show_figure(found[unit]) if unit in found else MISSING for unit in (DECIBEL, STOP))
            lines.append((*_iso_cell(isos, iso), *cells, _black_patch(region)))
    return (
        WordTable(
            title=f"Clipping level over the noise of a dark patch{_whose(mine)}",
            head=(*_iso_head(isos), "[dB]", "[EV]", "Dark patch"),
            lines=tuple(lines),
            note="In the manner of ISO 15739, not by it: the patch decides the figure. " + _flag_note(mine),
        ),
    )


def _black_patch(region: str | None) -> str:
    name = (region or "").removeprefix(_PATCH)
    return f"patch {name}, the nearest to density 2" if (region or "").startswith(_PATCH) else "the darkest"


def capacity_table(rows: Sequence[Row]) -> tuple[WordTable, ...]:
    """Return saturation capacity by each way to read it, with the levels that bracket it."""
    mine = _of_leading([row for row in rows if row.quantity == "saturation_capacity" and row.method in _CAPACITIES])
    if not mine:
        return ()
    isos = _isos(mine)
    lines: list[tuple[str, ...]] = []
    for iso in isos:
        for method in _methods(mine, iso, _CAPACITIES):
            found = {row.measured.unit: row for row in mine if row.iso == iso and row.method == method}
            shown = [show_figure(found[unit]) if unit in found else MISSING for unit in (DN, ELECTRON)]
            interval = show_interval(found[DN].measured) if DN in found else MISSING
            lines.append((*_iso_cell(isos, iso), method, *shown, interval, _explained(method)))
    return (
        WordTable(
            title=f"Saturation{_whose(mine)}",
            head=(*_iso_head(isos), "Read at", "[DN]", "[e⁻]", "Between [DN]", "What it is"),
            lines=tuple(lines),
            note="The patches of a chart lie far apart: the true level may lie anywhere between two. "
            + _flag_note(mine),
        ),
    )


def coefficient_facts(rows: Sequence[Row], iso: float | None) -> tuple[tuple[str, str], ...]:
    """Return the figures to write beside the noise curve of one ISO."""
    wanted = (
        ("k_dark", "1", "gamma-likelihood", "k_{dark}"),
        ("k_shot", "1", "gamma-likelihood", "k_{shot}"),
        ("k_fpn", "1", "gamma-likelihood", "k_{fpn}"),
        ("system_gain", "DN/e-", "photon-transfer", "system gain"),
        ("read_noise", ELECTRON, "noise-model", "read noise"),
        ("black_level", DN, "fused", "black level"),
    )
    return _facts(rows, iso, wanted)


def ratio_facts(rows: Sequence[Row], iso: float | None) -> tuple[tuple[str, str], ...]:
    """Return the figures to write beside the SNR curve of one ISO."""
    wanted = (
        ("saturation_capacity", ELECTRON, "temporal-variance-peak", "saturation"),
        ("snr_max", DECIBEL, "noise-model", "maximum SNR"),
        ("snr_max", DECIBEL, "shot-only", "of shot noise only"),
    )
    return _facts(rows, iso, wanted)


_UNITS: Final = {"1": "", "DN/e-": " DN/e⁻", ELECTRON: " e⁻", DN: " DN", DECIBEL: " dB"}


def _facts(
    rows: Sequence[Row], iso: float | None, wanted: Sequence[tuple[str, str, str, str]]
) -> tuple[tuple[str, str], ...]:
    facts: list[tuple[str, str]] = []
    for quantity, unit, method, name in wanted:
        mine = [row for row in rows if (row.quantity, row.measured.unit, row.method) == (quantity, unit, method)]
        row = next(iter(_of_leading([row for row in mine if row.iso == iso])), None)
        if row is not None:
            facts.append((name, show_figure(row) + _UNITS[unit]))
    return tuple(facts)


def one_curve(rows: Sequence[Row], iso: float | None) -> bool:
    """Tell whether the channels of one ISO share one noise model."""
    shared = [row for row in rows if row.quantity in _COEFFICIENTS and row.channel == "all" and row.iso == iso]
    return bool(shared) and not any("channels-differ" in row.flags for row in shared)


def range_words(rows: Sequence[Row], iso: float | None) -> str:
    """Return the dynamic range at SNR 1 in words for the SNR curve of one ISO; empty where it is not known."""
    found = {
        row.measured.unit: row
        for row in _of_leading([row for row in rows if row.quantity == "dynamic_range" and row.iso == iso])
        if row.method == "noise-model" and row.snr_threshold == 1.0
    }
    if DECIBEL not in found:
        return ""
    stops = f" = {found[STOP].measured.value:.2f} EV" if STOP in found else ""
    bound = "≥ " if "lower-bound" in found[DECIBEL].flags else ""
    return f"dynamic range {bound}{found[DECIBEL].measured.value:.2f} dB{stops}"


def saturation_of(rows: Sequence[Row], iso: float | None) -> float | None:
    """Return the recommended saturation of all channels above black [DN]; None where it is not known."""
    mine = [
        row
        for row in rows
        if (row.quantity, row.measured.unit, row.method) == ("saturation_capacity", DN, "temporal-variance-peak")
        and row.iso == iso
    ]
    return next((row.measured.value for row in _of_leading(mine)), None)


def black_levels(rows: Sequence[Row], iso: float | None) -> dict[str, float]:
    """Return the black level of each channel at one ISO [DN]."""
    return {
        row.channel: row.measured.value
        for row in rows
        if (row.quantity, row.method, row.iso) == ("black_level", "fused", iso)
    }


def _of_leading(rows: Sequence[Row]) -> list[Row]:
    """Return the rows of all channels together, of the leading channel where there are none."""
    names = {row.channel for row in rows}
    if not names:
        return []
    leading = "all" if "all" in names else leading_channel(names)
    return [row for row in rows if row.channel == leading]


def _whose(rows: Sequence[Row]) -> str:
    name = rows[0].channel
    return {"all": ", all channels", "mono": ""}.get(name, f", {name}")


def _channels(rows: Sequence[Row]) -> tuple[str, ...]:
    return tuple(sorted({row.channel for row in rows}, key=channel_rank))


def _isos(rows: Sequence[Row]) -> tuple[float | None, ...]:
    return tuple(sorted({row.iso for row in rows}, key=lambda iso: -1.0 if iso is None else iso))


def _iso_head(isos: Sequence[float | None]) -> tuple[str, ...]:
    return ("ISO",) if len(isos) > 1 else ()


def _iso_cell(isos: Sequence[float | None], iso: float | None) -> tuple[str, ...]:
    return (show_iso(iso).removeprefix("ISO "),) if len(isos) > 1 else ()


def _methods(rows: Sequence[Row], iso: float | None, order: Sequence[str]) -> list[str]:
    """Return the methods that rows of an ISO have, in a fixed order, others at the end."""
    present = dict.fromkeys(row.method for row in rows if row.iso == iso)
    return [method for method in order if method in present] + [method for method in present if method not in order]


def _kind(row: Row) -> tuple[str, str, str]:
    return (row.quantity, row.method, row.measured.unit)


def _is(row: Row, iso: float | None, method: str, channel: str) -> bool:
    return (row.iso, row.method, row.channel) == (iso, method, channel)


def _cell(rows: Sequence[Row], iso: float | None, method: str, channel: str) -> str:
    row = next((row for row in rows if _is(row, iso, method, channel)), None)
    return MISSING if row is None else _short_level(row.measured)


def _short_level(measured: Measured) -> str:
    return show(measured) if measured.std_error else show_plain(round(measured.value, 3))


def _explained(method: str) -> str:
    entry = glossary.method(method)
    return "" if entry is None else " ".join(part for part in (entry.definition, entry.bias) if part)


def _explanations(rows: Sequence[Row], order: Sequence[str]) -> list[str]:
    """Return what each method is, with the setting that its source names behind the section of the method."""
    found: list[str] = []
    for method in (method for method in order if any(row.method == method for row in rows)):
        setting = next((row.source.partition(", ")[2] for row in rows if row.method == method), "")
        found.append(f"{method}{f' ({setting})' if setting else ''}: {_explained(method)}")
    return found


def _flags(rows: Sequence[Row]) -> str:
    return ", ".join(sorted({flag for row in rows for flag in row.flags} - {glossary.RECOMMENDED}))


def _flag_note(rows: Sequence[Row]) -> str:
    names = sorted({flag for row in rows for flag in row.flags} - {glossary.RECOMMENDED})
    return " ".join(_sentence(describe_flag(name)) for name in names)


def _sentence(text: str) -> str:
    return text if text.endswith(".") else f"{text}."
