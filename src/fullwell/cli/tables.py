"""What people see: tables of a study, of raw files, of results; findings coloured by how much they matter."""

from collections.abc import Iterable, Sequence
from typing import Final

from rich import box
from rich.console import Console
from rich.markup import escape
from rich.table import Table

from fullwell.findings import Finding, Severity, listed
from fullwell.frames.series import Study
from fullwell.raw.image import Levels
from fullwell.report.numbers import show_exposure

_STYLES: Final = {Severity.ERROR: "bold red", Severity.WARNING: "yellow", Severity.INFO: "cyan"}


def plain_table(*columns: str, title: str | None = None) -> Table:
    """Return an empty table in the house's style; a column whose name starts with ``>`` is aligned to the right."""
    table = Table(box=box.SIMPLE, title=title, title_justify="left", title_style="bold", pad_edge=False)
    for column in columns:
        justify = "right" if column.startswith(">") else "left"
        table.add_column(column.removeprefix(">"), justify=justify, overflow="fold")
    return table


def print_findings(console: Console, findings: Iterable[Finding]) -> None:
    """Print findings, the most severe first, each with the files it is about."""
    for finding in sorted(findings, key=lambda finding: finding.severity.rank):
        style = _STYLES[finding.severity]
        console.print(
            f"[{style}]{finding.severity.value}[/{style}] {escape(finding.message)}", highlight=False, soft_wrap=True
        )
        _print_files(console, finding)


def _print_files(console: Console, finding: Finding) -> None:
    unsaid = [name for name in finding.files if name not in finding.message]
    if unsaid:
        console.print(f"  [dim]{escape(listed(unsaid))}[/dim]", highlight=False, soft_wrap=True)


def print_study(console: Console, study: Study) -> None:
    """Print what of a study would be read and measured."""
    name = f"{study.camera.name}, " if study.camera.name else ""
    console.print(
        f"{escape(name)}{study.width} x {study.height}, {study.cfa}, {study.bit_depth} bit, "
        f"black level {spelled_levels(study.black_level)}, white level {spelled_levels(study.white_level)}",
        highlight=False,
        soft_wrap=True,
    )
    table = plain_table("kind", "ISO", ">exposure", ">frames", ">MB", ">temperature")
    for series in study.series:
        table.add_row(
            series.kind.value,
            "unknown" if series.iso is None else f"{series.iso:g}",
            show_exposure(series.exposure_s),
            str(len(series.frames)),
            f"{sum(frame.size for frame in series.frames) / 1e6:.1f}",
            "" if series.temperature_c is None else f"{series.temperature_c:.1f} °C",
        )
    console.print(table)
    frames = [frame for series in study.series for frame in series.frames]
    size_mb = sum(frame.size for frame in frames) / 1e6
    console.print(
        f"{len(frames)} frames in {len(study.series)} series, {size_mb:.1f} MB; {len(study.excluded)} left out.",
        highlight=False,
        soft_wrap=True,
    )
    print_findings(console, study.findings)


def spelled_levels(levels: Levels | None) -> str:
    """Return levels with their source, one number where all sites share it."""
    if levels is None:
        return "unknown"
    return f"{spelled_values(levels.values)} DN ({levels.source})"


def spelled_values(values: Sequence[float]) -> str:
    """Return numbers, one where all are alike."""
    shown = values[:1] if len(set(values)) == 1 else values
    return " ".join(f"{value:g}" for value in shown)
