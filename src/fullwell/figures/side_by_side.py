"""Several results side by side: what each of them is, what they have in common, and how far their figures differ."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from itertools import product
from string import ascii_uppercase
from typing import Final, cast

from fullwell.figures.emva_against_chart import Line, Sides, ten_lines
from fullwell.figures.matching import Crossing, Match, crossed, matched
from fullwell.figures.measured_model import models_of_rows
from fullwell.figures.noise_translation import translated
from fullwell.figures.results import Results, Row
from fullwell.findings import Finding, Severity
from fullwell.glossary.comparable import TRUTH

EMVA_METHODS: Final = ("emva1288-4.0-linear", "emva1288-py-1.0")
"""Profiles, the one to set beside a chart first."""
SIMULATOR: Final = "Fullwell"
"""Make of the cameras that we simulate."""

_Record = Mapping[str, object]


@dataclass(frozen=True, slots=True, kw_only=True)
class Side:
    """One of the results that are compared.

    Parameters
    ----------
    label
        A, B, C ...
    name
        What it was read from.
    results
        What it holds.
    source
        ``results``, ``truth`` of a simulation, or ``emva1288`` for the reference package's file.

    """

    label: str
    name: str
    results: Results
    source: str = "results"

    @property
    def bodies(self) -> tuple[str, ...]:
        """Return make, model, serial number and firmware of every body that the files name."""
        records = cast("Sequence[_Record]", self.results.study.get("bodies") or ())
        return tuple(_body(record) for record in records)

    @property
    def camera(self) -> str:
        """Return the camera's name, empty where nobody gave it."""
        return str(_camera(self.results).get("name") or "")

    @property
    def simulated(self) -> bool:
        """Tell whether the frames are simulated, or these are the simulation's own values."""
        bodies = cast("Sequence[_Record]", self.results.study.get("bodies") or ())
        return self.source == TRUTH or any(record.get("make") == SIMULATOR for record in bodies)

    @property
    def emva(self) -> str | None:
        """Return the EMVA profile whose rows it holds, None where it holds none."""
        methods = {row.method for row in self.results.rows if row.quantity == "system_gain"}
        return next((method for method in EMVA_METHODS if method in methods), None)

    @property
    def chart(self) -> bool:
        """Tell whether shots of a chart are among its frames."""
        series = cast("Sequence[_Record]", self.results.study.get("series") or ())
        return any(record.get("kind") == "chart" for record in series)

    @property
    def isos(self) -> tuple[float | None, ...]:
        """Return the ISOs that have figures, unknown first."""
        known = {row.iso for row in self.results.rows}
        return tuple(sorted(known, key=lambda iso: -1.0 if iso is None else iso))

    @property
    def hashes(self) -> frozenset[str]:
        """Return the content hashes of its frames."""
        files = cast("Sequence[_Record]", self.results.study.get("files") or ())
        return frozenset(str(record["xxh3_128"]) for record in files if record.get("xxh3_128"))


@dataclass(frozen=True, slots=True, kw_only=True)
class TenFigures:
    """The published table of ten figures, EMVA 1288 against a chart, of one channel at one ISO."""

    emva: str
    chart: str
    profile: str
    channel: str
    iso: float | None
    lines: tuple[Line, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class Comparison:
    """Results side by side.

    Parameters
    ----------
    sides
        What is compared; differences are told from the first.
    matches
        Figures that several have by the same method.
    crossings
        Figures that two have by different methods, with whether these mean the same.
    tens
        EMVA 1288 against charts.
    findings
        What limits the comparison.

    """

    sides: tuple[Side, ...]
    matches: tuple[Match, ...]
    crossings: tuple[Crossing, ...]
    tens: tuple[TenFigures, ...]
    findings: tuple[Finding, ...]


def compare(sides: Sequence[Side]) -> Comparison:
    """Return results side by side."""
    rows, assumed = _at_one_iso([side.results.rows for side in sides])
    shared = partial(_share_frames, sides)
    matches = matched(rows, shared)
    crossings = crossed(rows, shared)
    tens = tuple(
        ten
        for emva, chart in product(sides, sides)
        if emva.emva is not None and chart.chart and (chart.emva is None or emva is chart)
        for ten in _ten_figures(emva, chart)
    )
    return Comparison(
        sides=tuple(sides),
        matches=matches,
        crossings=crossings,
        tens=tens,
        findings=(*assumed, *_findings(sides, bool(matches or crossings or tens))),
    )


def _at_one_iso(sides: Sequence[Sequence[Row]]) -> tuple[list[Sequence[Row]], tuple[Finding, ...]]:
    """Return the rows with results that know no ISO put at the only one of the others, where there is but one."""
    isos = {row.iso for rows in sides for row in rows} - {None}
    unknown = [at for at, rows in enumerate(sides) if all(row.iso is None for row in rows)]
    if len(isos) != 1 or not unknown:
        return list(sides), ()
    iso = isos.pop()
    labels = ", ".join(ascii_uppercase[at] for at in unknown)
    finding = _info("iso-assumed", f"{labels} does not tell its ISO: its figures stand beside those of ISO {iso:g}.")
    return [[replace(row, iso=iso) for row in rows] if at in unknown else rows for at, rows in enumerate(sides)], (
        finding,
    )


def _share_frames(sides: Sequence[Side], first: int, second: int) -> bool:
    return not sides[first].hashes.isdisjoint(sides[second].hashes)


def _ten_figures(emva: Side, chart: Side) -> list[TenFigures]:
    """Return a table per channel and ISO that EMVA 1288 and the chart have in common, or that one cannot tell."""
    profile = emva.emva or ""
    ours = [row for row in emva.results.rows if row.method == profile and row.region is None]
    figures = _chart_figures(chart.results.rows)
    places = dict.fromkeys((row.channel, row.iso) for row in ours if row.quantity == "system_gain")
    return [
        TenFigures(
            emva=emva.label,
            chart=chart.label,
            profile=profile,
            channel=channel,
            iso=iso,
            lines=ten_lines(
                Sides(
                    emva=[row for row in ours if (row.channel, row.iso) == (channel, iso)],
                    chart=figures[place],
                    exposure_s=_chart_exposure(chart.results, place[1]),
                    bits=(emva.results.code_bits, chart.results.code_bits),
                    shared=not emva.hashes.isdisjoint(chart.hashes),
                )
            ),
        )
        for channel, iso in places
        if (place := _place(figures, channel, iso)) is not None
    ]


_Place = tuple[str, float | None]


def _chart_figures(rows: Sequence[Row]) -> Mapping[_Place, list[Row]]:
    """Return what was measured and, after it, what follows from the noise model, by channel and ISO."""
    return {
        (model.channel, model.iso): [
            *(row for row in rows if (row.channel, row.iso, row.region) == (model.channel, model.iso, None)),
            *(one.row for one in translated(model)),
        ]
        for model in models_of_rows([row for row in rows if row.region is None and row.exposure_s is None])
    }


def _place(figures: Mapping[_Place, object], channel: str, iso: float | None) -> _Place | None:
    """Return the chart's channel and ISO that stand beside those of EMVA 1288."""
    isos = {at for _, at in figures}
    known = iso if iso in isos else next(iter(isos)) if len(isos) == 1 and (iso is None or None in isos) else iso
    return next(((name, known) for name in (channel, "all") if (name, known) in figures), None)


def _chart_exposure(results: Results, iso: float | None) -> float:
    """Return the longest exposure of the chart at one ISO, 0 where unknown [s]."""
    series = cast("Sequence[_Record]", results.study.get("series") or ())
    times = [
        record.get("exposure_s") for record in series if record.get("kind") == "chart" and record.get("iso") == iso
    ]
    return max((float(time) for time in times if isinstance(time, (int, float))), default=0.0)


def _camera(results: Results) -> _Record:
    camera = results.study.get("camera")
    return cast("_Record", camera) if isinstance(camera, Mapping) else {}


def _body(record: _Record) -> str:
    name = " ".join(str(record[key]) for key in ("make", "model") if record.get(key))
    serial = f"serial {record['serial']}" if record.get("serial") else ""
    firmware = f"firmware {record['firmware']}" if record.get("firmware") else ""
    return ", ".join(part for part in (name, serial, firmware) if part)


def _findings(sides: Sequence[Side], anything: bool) -> tuple[Finding, ...]:  # noqa: FBT001 - a fact, not a mode
    found: list[Finding] = []
    for first in range(len(sides)):
        for second in range(first + 1, len(sides)):
            one, other = sides[first], sides[second]
            if common := len(one.hashes & other.hashes):
                found.append(
                    _info(
                        "frames-shared",
                        f"{one.label} and {other.label} have {common} frames in common: their errors are not "
                        "independent, so that differences stand without an error.",
                    )
                )
    if not anything:
        found.append(
            Finding(
                code="nothing-in-common",
                severity=Severity.WARNING,
                message=(
                    "No figure stands in two of these results: channels, units and ISO must agree. "
                    f"ISOs: {'; '.join(_isos(side) for side in sides)}."
                ),
            )
        )
    return tuple(found)


def _isos(side: Side) -> str:
    return f"{side.label} {', '.join('unknown' if iso is None else f'{iso:g}' for iso in side.isos)}"


def _info(code: str, message: str) -> Finding:
    return Finding(code=code, severity=Severity.INFO, message=message)
