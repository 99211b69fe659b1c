"""The chapter on the loop: whether this tool would have measured this camera right.

Drawn from the curves ``loop_figures``, ``loop_pulls`` and ``loop_transfer``; it stands where the first of them is.
"""

import math
from collections.abc import Sequence
from typing import Final

from fullwell import glossary
from fullwell.raw.cfa import leading_channel
from fullwell.report import plots_loop
from fullwell.report.loop_figures import LoopFigure, Together, loop_figures, native, put_together
from fullwell.report.material import Material, Part, Section, Tab, WordTable, drawn, iso_label, parts_shown
from fullwell.report.numbers import MISSING, show, show_iso, show_signed, show_unit
from fullwell.report.pivots import title_of
from fullwell.report.plots import Picture
from fullwell.units import Measured

FIGURES: Final = "loop_figures"
_SUMMARY: Final = (
    ("system_gain", "DN/e-"),
    ("k_dark", "1"),
    ("k_shot", "1"),
    ("k_fpn", "1"),
    ("read_noise", "e-"),
    ("dark_noise", "e-"),
    ("dsnu", "e-"),
    ("dark_current", "e-/s"),
    ("prnu", "%"),
    ("saturation_capacity", "e-"),
    ("snr_max", "dB"),
    ("dynamic_range", "dB"),
    ("black_level", "DN"),
    ("flare", "1"),
)
"""Figures of the table that lays original and simulation side by side."""
_FURTHEST: Final = 10
_SAME: Final = 1e-9
"""Errors below this share of a value are those of arithmetic."""


def loop_chapter(material: Material) -> tuple[Section, ...]:
    """Return the chapter on the loop; none where the camera was not simulated."""
    table = material.table(FIGURES)
    if table is None:
        return ()
    figures = loop_figures(table)
    cameras = int(max(one.cameras for one in figures))
    lines = put_together(native(one for one in figures if one.judged))
    parts = parts_shown(
        Part(
            title="Original beside simulated",
            lead="The figures that a noise model is made of, as they went in and as they came out.",
            tables=(_summary(figures), _definitions(figures)),
        ),
        Part(title="Photon transfer", pictures=_transfer(material), tabs=_transfer_tabs(material)),
        Part(
            title="Errors in standard errors",
            pictures=drawn(material.table("loop_pulls"), plots_loop.pulls),
            tables=_furthest(figures) if cameras == 1 else (),
        ),
        *([] if cameras == 1 else [_coverage(lines), _published(figures)]),
    )
    many = f"{cameras} cameras of the same make, each with a sensor and noise of its own, were" if cameras > 1 else ""
    section = Section(
        anchor="loop",
        title="The loop closed",
        lead=(
            f"Would this tool have measured this camera right? {many or 'The camera was'} simulated as raw files and "
            "measured like any other; the truth of every figure is known."
        ),
        parts=parts,
    )
    return (section,)


def _summary(figures: Sequence[LoopFigure]) -> WordTable:
    iso = min((one.iso for one in figures if one.iso is not None), default=None)
    several = len({one.iso for one in figures if one.iso is not None}) > 1
    measured = any(math.isfinite(one.original) for one in figures)
    lines: list[tuple[str, ...]] = []
    for quantity, unit in _SUMMARY:
        mine = [one for one in figures if (one.quantity, one.unit, one.iso) == (quantity, unit, iso)]
        mine = [one for one in mine if one.snr_threshold in {None, 1.0} and one.exposure_s is None]
        mine = [one for one in mine if one.temperature_c == mine[0].temperature_c]
        lead = leading_channel({one.channel for one in mine}) if mine else ""
        own = sorted((one for one in mine if one.channel == lead), key=lambda one: not one.recommended)
        lines += [_summary_line(one, measured=measured) for one in own]
    cameras = int(max(one.cameras for one in figures))
    again = f"mean of {cameras} ± its Monte Carlo error" if cameras > 1 else "value ± standard error"
    return WordTable(
        title=f"Original and simulation{f' at {show_iso(iso)}' if several else ''}",
        head=(
            "Figure",
            "Method",
            *(("Original",) if measured else ()),
            "Simulated with",
            "Measured again",
            "Difference",
        ),
        lines=tuple(lines),
        note=(
            f"Of all channels together where they share a figure. Measured again: {again}. Difference: to what it was "
            "simulated with. The recommended method stands first; legacy methods are the published ones, with their "
            f"bias.{' The other ISOs stand in loop.json.' if several else ''}"
        ),
    )


def _definitions(figures: Sequence[LoopFigure]) -> WordTable:
    shown = {one.quantity for one in figures}
    entries = [entry for name, _ in _SUMMARY if name in shown and (entry := glossary.quantity(name)) is not None]
    return WordTable(
        title="Definitions",
        head=("Figure", "Is", "Equation"),
        lines=tuple((entry.symbol, entry.title, entry.equation) for entry in entries),
    )


def _named(one: LoopFigure) -> str:
    """Return the symbol of a figure with its unit: titles would leave no room for what is to be compared."""
    unit, entry = show_unit(one.unit), glossary.quantity(one.quantity)
    return (entry.symbol if entry else title_of(one.quantity)) + (f" [{unit}]" if unit else "")


def _summary_line(one: LoopFigure, *, measured: bool) -> tuple[str, ...]:
    original = _measured(one.original, one.original_std_error, one.unit) if math.isfinite(one.original) else MISSING
    error = one.bias_std_error if one.cameras > 1 else one.std_error
    return (
        _named(one),
        one.method,
        *((original,) if measured else ()),
        show(Measured.exact(one.truth, one.unit)),
        f"{'≥ ' if one.bound else ''}{_measured(one.mean, error, one.unit)}{_bound_in(one)}",
        MISSING if one.bound else _difference(one, error),
    )


def _bound_in(one: LoopFigure) -> str:
    some = 0.0 < one.bounds < one.cameras
    return f" (a bound in {one.bounds:g} of {one.cameras:g})" if some else ""


def _measured(value: float, error: float, unit: str) -> str:
    known = math.isfinite(error) and error > _SAME * abs(value)
    return show(Measured.normal(value, error, unit) if known else Measured.exact(value, unit))


def _difference(one: LoopFigure, error: float) -> str:
    scale, unit = (100.0 / one.truth, "%") if one.relative else (1.0, show_unit(one.unit))
    return f"{_signed(one.bias * scale, error * abs(scale))} {unit}"


def _signed(value: float, error: float) -> str:
    text = _measured(value, error, "1") if math.isfinite(error) else f"{value:.2g}".replace("-", "−")
    return text if text.startswith(("−", "(−", "0 ")) else f"+{text}"


def _transfer(material: Material) -> tuple[Picture, ...]:
    found = _transfer_pictures(material)
    return tuple(picture for _, picture in found) if len(found) == 1 else ()


def _transfer_tabs(material: Material) -> tuple[Tab, ...]:
    found = _transfer_pictures(material)
    return tuple(Tab(label=label, pictures=(picture,)) for label, picture in found) if len(found) > 1 else ()


def _transfer_pictures(material: Material) -> list[tuple[str, Picture]]:
    table = material.table("loop_transfer")
    if table is None:
        return []
    found: list[tuple[str, Picture]] = []
    kinds = list(table.split("measurement"))
    for kind, own in kinds:
        name = {"chart_points": "chart, "}.get(str(kind), "") if len(kinds) > 1 else ""
        found += [
            (f"{name}{iso_label(iso)}", plots_loop.transfer_beside(part, iso))
            for iso, part in own.split("iso")
            if "simulated" in part.values("whose")
        ]
    return found


def _furthest(figures: Sequence[LoopFigure]) -> tuple[WordTable, ...]:
    judged = [one for one in native(one for one in figures if one.recommended) if math.isfinite(one.pull)]
    worst = sorted(judged, key=lambda one: -abs(one.pull))[:_FURTHEST]
    lines = tuple(
        (
            f"{title_of(one.quantity)} [{show_unit(one.unit) or '1'}]",
            MISSING if one.iso is None else f"{one.iso:g}",
            one.channel,
            show(Measured.exact(one.truth, one.unit)),
            _measured(one.value, one.std_error, one.unit),
            show_signed(one.pull),
        )
        for one in worst
    )
    if not lines:
        return ()
    return (
        WordTable(
            title=f"The {len(lines)} furthest from their truth, of {len(judged)}",
            head=("Figure", "ISO", "Channel", "Truth", "Measured", "Pull"),
            lines=lines,
            note="With --repeat N the same camera is made N times: bias and coverage of every interval are told then.",
        ),
    )


def _coverage(lines: Sequence[Together]) -> Part:
    picture = plots_loop.coverage(lines)
    return Part(
        title="Coverage and bias",
        lead="A parametric bootstrap of the recommended figures, over channels and ISOs together.",
        pictures=() if picture is None else (picture,),
        tables=(
            WordTable(
                title="What the intervals, errors and means come to",
                head=("Figure", "Rows", "Bound", "Bias", "sd", "sd / error", "Coverage [%]", "Pulls"),
                lines=tuple(_coverage_line(one) for one in lines),
                note=(
                    "Bound: in how many cameras, summed over the rows, saturation was not reached, so that a figure is "
                    "only a lower bound; a row that is one in any camera has no part in what follows. Bias with its "
                    "Monte Carlo error, and the standard deviation of a figure from camera to camera, in % of the "
                    "truth where no unit is named. sd over reported error: 1 is honest. Coverage of 95 % intervals "
                    "with what so many trials can tell. Pulls: mean and standard deviation. Rows of one camera share "
                    "frames, so neighbouring lines are not independent. Every row by itself stands in loop.json."
                ),
            ),
        ),
    )


def _coverage_line(one: Together) -> tuple[str, ...]:
    found = one.coverage
    threshold = "" if one.snr_threshold in {None, 1.0} else f" (SNR {one.snr_threshold:g})"
    return (
        f"{title_of(one.quantity)}{threshold}",
        str(one.figures),
        f"{one.bounds} of {one.cameras}" if one.bounds else MISSING,
        _share(one, one.bias, one.bias_std_error),
        _share(one, one.sd, math.nan).lstrip("+"),
        _plain(one.scatter_ratio, "{:.2f}"),
        MISSING if found is None else f"{100 * found[0]:.1f} ({100 * found[1]:.1f} to {100 * found[2]:.1f})",
        f"{_plain(one.pull_mean, '{:+.2f}')}, {_plain(one.pull_sd, '{:.2f}')}",
    )


def _share(one: Together, value: float, error: float) -> str:
    if not math.isfinite(value):
        return MISSING
    if one.relative:
        return f"{_signed(100.0 * value, 100.0 * error)} %"
    return f"{_signed(value, error)} {show_unit(one.unit)}"


def _plain(value: float, form: str) -> str:
    return form.format(value).replace("-", "−") if math.isfinite(value) else MISSING


def _published(figures: Sequence[LoopFigure]) -> Part:
    """Return how far the published estimators are off on the same frames; they claim no errors."""
    legacy = put_together(native(one for one in figures if one.legacy and not one.bound))
    lines = tuple(
        (
            title_of(one.quantity),
            one.method,
            _share(one, one.bias, one.bias_std_error),
            _share(one, one.sd, math.nan).lstrip("+"),
            _method(one.method),
        )
        for one in legacy
    )
    tables = (
        WordTable(
            title="Bias of the published estimators on the same frames",
            head=("Figure", "Method", "Bias", "sd", "Why"),
            lines=lines,
        ),
    )
    return Part(title="What the published methods would have said", tables=tables if lines else ())


def _method(name: str) -> str:
    entry = glossary.method(name)
    return "" if entry is None else entry.bias or entry.definition
