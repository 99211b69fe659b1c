"""The report: one self-contained page, findings first, every figure explained."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import jinja2
from markupsafe import Markup

from fullwell import glossary
from fullwell.figures.results import Results, Row
from fullwell.findings import Finding, Severity
from fullwell.raw.cfa import channel_rank
from fullwell.report.chosen_models import chosen_models
from fullwell.report.comparison import published_beside
from fullwell.report.datasheet.contents import Datasheet
from fullwell.report.document import citations
from fullwell.report.emva_section import emva_section
from fullwell.report.inventory import run_date, run_facts, take_inventory
from fullwell.report.material import isos_of
from fullwell.report.numbers import MISSING, show, show_exposure, show_interval, show_plain, show_unit
from fullwell.report.pictures import Pictures
from fullwell.report.pivots import describe_flag, recommended, title_of
from fullwell.report.sections import build_sections
from fullwell.report.summary import summarize

MOST_ROWS: Final = 4000


def report_html(results: Results, pictures: Pictures | None, *, datasheet: Datasheet | None = None) -> str:
    """Return the report as one page that needs nothing from the network.

    Parameters
    ----------
    results
        Everything the run found.
    pictures
        Arrays shown as pictures; None for a report without them.
    datasheet
        The EMVA 1288 datasheet, which becomes the first chapter; None where there is none.

    """
    environment = jinja2.Environment(
        loader=jinja2.PackageLoader("fullwell.report"),
        autoescape=True,
        trim_blocks=True,
        lstrip_blocks=True,
        undefined=jinja2.StrictUndefined,
    )
    environment.filters["unit"] = show_unit
    environment.filters["flag"] = describe_flag
    shown = _shown(results.rows)
    quotable = recommended(results.rows)
    sections = build_sections(results, pictures)
    return environment.get_template("report.html").render(
        css=_verbatim(environment, "report.css"),
        script=_verbatim(environment, "report.js"),
        inventory=take_inventory(results),
        date=run_date(results),
        run=run_facts(results),
        isos=[f"{iso:g}" for iso in isos_of(results.rows)],
        channels=sorted({row.channel for row in quotable} - {"all"}, key=channel_rank),
        topics=_topics(results.findings),
        counts=[(severity.value, _count(results.findings, severity)) for severity in Severity],
        summary=summarize(quotable),
        sections=(*(() if datasheet is None else (emva_section(datasheet),)), *sections),
        published=published_beside(results.rows, chosen_models(results.curves, pictures.shading if pictures else ())),
        rows=[_row(row) for row in shown],
        rows_omitted=len(results.rows) - len(shown),
        quantities=_quantities(results.rows),
        methods=[entry for entry in glossary.METHODS if any(row.method == entry.name for row in results.rows)],
        flags=[entry for entry in glossary.FLAGS if any(entry.name in row.flags for row in results.rows)],
        citations=citations(results),
    )


def _verbatim(environment: jinja2.Environment, name: str) -> Markup:
    """Return a style sheet or script as it stands: it is ours, nothing in it comes from the data."""
    return Markup(environment.get_template(name).render())  # noqa: S704 - a constant of the package


@dataclass(frozen=True, slots=True, kw_only=True)
class Topic:
    """Findings of one code: mostly the same thing at several ISOs."""

    code: str
    severity: str
    findings: tuple[Finding, ...]


def _topics(findings: Sequence[Finding]) -> list[Topic]:
    """Return the findings, the worst first, those of one code together."""
    groups: dict[tuple[Severity, str], list[Finding]] = {}
    for finding in sorted(findings, key=lambda finding: finding.severity.rank):
        groups.setdefault((finding.severity, finding.code), []).append(finding)
    return [
        Topic(code=code, severity=severity.value, findings=tuple(mine)) for (severity, code), mine in groups.items()
    ]


def _count(findings: Sequence[Finding], severity: Severity) -> int:
    return sum(finding.severity is severity for finding in findings)


def _quantities(rows: Sequence[Row]) -> list[glossary.Quantity]:
    """Return the definitions of what the rows hold, in the order of the glossary, variances left to their roots."""
    present = {row.quantity.removesuffix("_variance") for row in rows} | {row.quantity for row in rows}
    return [entry for entry in glossary.QUANTITIES if entry.name in present]


def _shown(rows: Sequence[Row]) -> Sequence[Row]:
    """Return the rows the page has room for: those of the whole plane before those of tiles and patches."""
    if len(rows) <= MOST_ROWS:
        return rows
    whole = [row for row in rows if row.region is None]
    return whole[:MOST_ROWS]


def _sortable(value: float | None) -> float | str:
    return "" if value is None or not math.isfinite(value) else value


def _row(row: Row) -> dict[str, object]:
    return {
        "quantity": row.quantity,
        "title": title_of(row.quantity),
        "root": row.quantity.removesuffix("_variance"),
        "channel": row.channel,
        "method": row.method,
        "value": show(row.measured, row.flags),
        "sort": {
            "value": _sortable(row.measured.value),
            "interval": _sortable(None if row.measured.ci95 is None else row.measured.ci95[0]),
            "exposure": _sortable(row.exposure_s),
            "n": _sortable(row.n),
        },
        "unit": show_unit(row.measured.unit) or "1",
        "interval": show_interval(row.measured),
        "iso": MISSING if row.iso is None else f"{row.iso:g}",
        "exposure": "" if row.exposure_s is None else show_exposure(row.exposure_s),
        "region": row.region or "",
        "threshold": "" if row.snr_threshold is None else f"{row.snr_threshold:g}",
        "n": show_plain(None if row.n is None else float(row.n)),
        "flags": row.flags,
        "source": row.source,
    }
