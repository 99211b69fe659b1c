"""A datasheet from results: one operation point per ISO and temperature of the profile's rows."""

from collections.abc import Callable, Sequence
from functools import partial
from typing import Final

from fullwell import glossary
from fullwell.figures.results import Results, Row
from fullwell.raw.cfa import channel_rank
from fullwell.report.datasheet.contents import ChannelSummary, Datasheet, FigureLine, OperationPoint
from fullwell.report.datasheet.facts import basic_facts, equipment_facts, point_facts, record, text_of
from fullwell.report.datasheet.graphs import Curves, graphs_of, small_graphs
from fullwell.report.datasheet.items import (
    PACKAGE_LINEARITY,
    SPATIAL,
    TEMPLATE,
    Entry,
    Group,
    error_text,
    item_groups,
    row_of,
)
from fullwell.report.datasheet.missing import missing_items, reason_of
from fullwell.report.datasheet.tables import THINNING
from fullwell.report.numbers import MISSING, show, show_interval, show_iso, show_plain, show_unit, show_value
from fullwell.report.pivots import title_of
from fullwell.report.plots_emva import Legend
from fullwell.units import Measured

LINEAR: Final = "emva1288-4.0-linear"
CORRECTED: Final = "emva1288-4.0-linear-hp-corrected"
PACKAGE: Final = "emva1288-py-1.0"

RELEASES: Final = {
    LINEAR: "EMVA 1288 Release 4.0 Linear, text RC 2021-03-15 (release candidate)",
    PACKAGE: "as the emva1288 package 1.0.2 computes (Release 3.1 rules); no uncertainties",
}
"""Profiles that have a datasheet, the one to prefer first."""

_MARKS: Final = "abcdefghijklmnopqrstuvwxyz"


def profile_of(results: Results) -> str | None:
    """Return the profile whose datasheet is to be made, None where no row follows one."""
    methods = {row.method for row in results.rows}
    return next((profile for profile in RELEASES if profile in methods), None)


def build_datasheet(results: Results) -> Datasheet | None:
    """Return the datasheet of results, None where they follow no profile of EMVA 1288."""
    profile = profile_of(results)
    if profile is None:
        return None
    rows = [row for row in results.rows if row.method in {profile, CORRECTED} and row.region is None]
    conditions = _conditions([row for row in rows if row.method == profile])
    points = [
        (_title(*condition), Curves(curves=results.curves, profile=profile, iso=iso, temperature_c=temperature_c))
        for condition in conditions
        for iso, temperature_c in (condition,)
    ]
    emva = record(results, "emva")
    made = [
        _point(results, title, curves, _at(rows, condition), profile)
        for (title, curves), condition in zip(points, conditions, strict=True)
    ]
    model = " ".join(part for part in (text_of(emva.get("vendor")), text_of(emva.get("model"))) if part)
    return Datasheet(
        camera=model or text_of(record(results, "camera").get("name")) or "Unnamed camera",
        profile=profile,
        release=RELEASES[profile],
        date=text_of(emva.get("date")),
        company=text_of(emva.get("company")),
        equipment=equipment_facts(results, release=RELEASES[profile]),
        basic=basic_facts(results),
        missing=missing_items(results, [row for row in rows if row.method == profile], points),
        findings=tuple(
            f"{finding.severity.value}: {finding.message}"
            for finding in results.findings
            if finding.severity.value != "info" or "emva" in finding.code
        ),
        points=tuple(made),
        thinning=THINNING,
    )


Condition = tuple[float | None, float | None]
"""ISO and temperature [degree Celsius]."""


def _conditions(rows: Sequence[Row]) -> list[Condition]:
    known = {(row.iso, row.temperature_c) for row in rows}
    return sorted(known, key=lambda one: tuple(-300.0 if value is None else float(value) for value in one))


def _title(iso: float | None, temperature_c: float | None) -> str:
    temperature = "" if temperature_c is None else f", {temperature_c:.0f} °C"
    return f"{show_iso(iso)}{temperature}"


def _at(rows: Sequence[Row], condition: Condition) -> list[Row]:
    return [row for row in rows if (row.iso, row.temperature_c) == condition]


def _point(results: Results, title: str, curves: Curves, rows: Sequence[Row], profile: str) -> OperationPoint:
    channels = sorted({row.channel for row in rows if row.method == profile}, key=channel_rank)
    legend_of = partial(_legend, curves, [row for row in rows if row.method == profile], channels)
    return OperationPoint(
        title=title,
        facts=point_facts(results, rows, curves.iso),
        channels=tuple(_channel(name, [row for row in rows if row.channel == name], profile) for name in channels),
        small=small_graphs(curves, legend_of),
        graphs=graphs_of(curves, legend_of),
    )


def _channel(channel: str, rows: Sequence[Row], profile: str) -> ChannelSummary:
    own = [row for row in rows if row.method == profile]
    beside = [row for row in rows if row.method == CORRECTED]
    template = _template(profile)
    marks, notes = _notes(template, own)
    return ChannelSummary(
        channel=channel,
        groups=item_groups(template, own, marks),
        beside=item_groups(SPATIAL, beside, {}) if beside else (),
        notes=notes,
        reasons=tuple(
            dict.fromkeys(text for group in template for entry in group.entries for text in _said(entry, own))
        ),
        figures=tuple(_figure(row) for row in sorted(rows, key=_order)),
    )


def _template(profile: str) -> tuple[Group, ...]:
    if profile != PACKAGE:
        return TEMPLATE
    return tuple(PACKAGE_LINEARITY if group.title == PACKAGE_LINEARITY.title else group for group in TEMPLATE)


def _notes(template: Sequence[Group], rows: Sequence[Row]) -> tuple[dict[str, str], tuple[tuple[str, str], ...]]:
    """Return a mark per quantity and the text of every mark: why a figure is missing, what its flags say."""
    texts: dict[str, str] = {}
    marks: dict[str, str] = {}
    for group in template:
        for entry in group.entries:
            said = " ".join(_said(entry, rows))
            if said:
                mark = texts.setdefault(said, _MARKS[len(texts) % len(_MARKS)])
                marks[entry.quantity] = mark
    return marks, tuple((mark, text) for text, mark in texts.items())


def _said(entry: Entry, rows: Sequence[Row]) -> tuple[str, ...]:
    """Return why a figure is missing, or what its flags say."""
    row = row_of(entry, rows)
    texts = (reason_of(entry.quantity),) if row is None else map(_flag, row.flags)
    return tuple(filter(None, texts))


def _flag(name: str) -> str:
    if name == glossary.RECOMMENDED:
        return ""
    entry = glossary.flag(name)
    return f"{name}: {entry.definition}" if entry else name


def _order(row: Row) -> tuple[int, str, str]:
    """Order rows as the template does, what it does not have after that as the glossary does."""
    names = [entry.quantity for group in TEMPLATE for entry in group.entries]
    names += [entry.name for entry in glossary.QUANTITIES]
    root = row.quantity.removesuffix("_variance") if row.quantity not in names else row.quantity
    return (names.index(root) if root in names else len(names), row.quantity, row.method)


def _figure(row: Row) -> FigureLine:
    measured = row.measured
    at = "" if row.snr_threshold in {None, 1.0} else f", SNR {row.snr_threshold:g}"
    return FigureLine(
        title=f"{title_of(row.quantity)}{at}",
        method="high-pass corrected" if row.method == CORRECTED else "",
        value=show(measured, row.flags) if measured.std_error is None else show_value(measured),
        error=error_text(measured) or MISSING,
        interval=show_interval(measured),
        dof=_dof(measured),
        unit=show_unit(measured.unit) or "1",
        flags=", ".join(flag for flag in row.flags if flag != glossary.RECOMMENDED),
    )


def _dof(measured: Measured) -> str:
    if measured.std_error is None:
        return MISSING
    return "∞" if measured.dof is None else f"{measured.dof:.3g}"


def _legend(curves: Curves, rows: Sequence[Row], channels: Sequence[str], graph: str) -> Legend:
    """Return what stands in a graph's legend: the figures that the standard wants there."""
    words = _WORDS.get(graph)
    texts = tuple((name, words([row for row in rows if row.channel == name])) for name in channels) if words else ()
    return Legend(texts=texts, marks=_marks(curves, rows, channels) if graph == "snr" else ())


def _marks(curves: Curves, rows: Sequence[Row], channels: Sequence[str]) -> tuple[tuple[str, str, float], ...]:
    """Return threshold and saturation in photons, where these are known."""
    marks: list[tuple[str, str, float]] = []
    for quantity, words in (("sensitivity_threshold", "SNR = 1"), ("saturation_capacity", "saturation")):
        for name in channels:
            row = _find([one for one in rows if one.channel == name], quantity, "p")
            if row is not None:
                marks.append((name, words, row.measured.value))
    return tuple(marks) if curves.table("emva_snr") is not None else ()


def _find(rows: Sequence[Row], quantity: str, unit: str) -> Row | None:
    wanted = (quantity, unit)
    return next(
        (row for row in rows if (row.quantity, row.measured.unit) == wanted and row.snr_threshold in {None, 1.0}), None
    )


def _of_transfer(rows: Sequence[Row]) -> str:
    gain, dark = _find(rows, "system_gain", "DN/e-"), _find(rows, "dark_noise", "DN")
    parts = [] if dark is None else [f"σ²(dark) = {dark.measured.value**2:.3g} DN²"]
    if gain is not None:
        error = _find(rows, "system_gain_regression_error", "%")
        percent = "" if error is None else f" ± {error.measured.value:.2g} % (1σ of the regression)"
        parts.append(f"K = {gain.measured.value:.4g}{percent}")
    return ", ".join(parts)


def _of_response(rows: Sequence[Row]) -> str:
    dark, efficiency = _find(rows, "dark_signal", "DN"), _find(rows, "quantum_efficiency", "%")
    parts = [] if dark is None else [f"μ(dark) = {show_plain(round(dark.measured.value, 2))} DN"]
    parts += [] if efficiency is None else [f"η = {efficiency.measured.value:.1f} %"]
    return ", ".join(parts)


def _of_rate(unit: str, quantity: str) -> Callable[[Sequence[Row]], str]:
    def words(rows: Sequence[Row]) -> str:
        row = _find(rows, quantity, unit)
        if row is None:
            return ""
        error = row.measured.std_error
        return f"{row.measured.value:.3g}" + (f" ± {error:.2g} {show_unit(unit)}" if error else f" {show_unit(unit)}")

    return words


_WORDS: Final[dict[str, Callable[[Sequence[Row]], str]]] = {
    "photon-transfer": _of_transfer,
    "characteristic": _of_response,
    "dark-current-mean": _of_rate("e-/s", "dark_current"),
    "dark-current-variance": _of_rate("e-/s", "dark_current_from_variance"),
}
