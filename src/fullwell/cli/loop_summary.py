"""A loop as it is printed: truth beside measurement for one camera, coverage and bias for several."""

import math
from collections.abc import Sequence
from pathlib import Path

from rich.console import Console
from rich.markup import escape

from fullwell.cli.comparison import print_comparison, print_spread
from fullwell.cli.tables import plain_table, print_findings
from fullwell.report.curves import table_named
from fullwell.report.loop_figures import Together, loop_figures, native, put_together
from fullwell.report.numbers import MISSING, show_unit
from fullwell.workflow.loop.loop import LoopOutcome


def print_loop(console: Console, outcome: LoopOutcome, *, out: Path) -> None:
    """Print findings, then what the loop came to."""
    print_findings(console, outcome.results.findings)
    if outcome.cameras == 1:
        print_comparison(console, outcome.compared)
        print_spread(console, outcome.pulls)
    else:
        _print_coverage(console, outcome)
    console.print(
        f"Every figure beside its truth: {escape(str(out / 'loop.json'))}\nReport: {escape(str(out / 'report.html'))}",
        highlight=False,
        soft_wrap=True,
    )


def _print_coverage(console: Console, outcome: LoopOutcome) -> None:
    table = table_named(outcome.results.curves, "loop_figures")
    if table is None:
        return
    shown = plain_table(
        "figure",
        ">bias",
        ">± MC",
        ">sd",
        ">sd/error",
        ">coverage",
        ">pull",
        ">sd",
        title=f"{outcome.cameras} cameras: recommended figures, channels and ISOs together",
    )
    lines = put_together(native(figure for figure in loop_figures(table) if figure.judged))
    for one in lines:
        if one.intervals:
            shown.add_row(*_cells(one))
    console.print(shown)
    console.print(
        "Bias with its Monte Carlo error, and sd of a figure from camera to camera, in % of the truth where no unit "
        "stands; sd over reported error; coverage of 95 % intervals in %; mean and sd of the pulls. Honest: sd/error "
        "1, coverage 95, pulls 0 and 1.",
        highlight=False,
        soft_wrap=True,
    )
    _print_bounds(console, lines)


def _print_bounds(console: Console, lines: Sequence[Together]) -> None:
    bounds = [f"{_name(one)} {one.bounds} of {one.cameras}" for one in lines if one.bounds]
    if bounds:
        console.print(
            f"Lower bounds, by cameras and rows, which count in none of these: {', '.join(bounds)}.",
            highlight=False,
            soft_wrap=True,
        )


def _name(one: Together) -> str:
    threshold = "" if one.snr_threshold in {None, 1.0} else f" (SNR {one.snr_threshold:g})"
    return f"{one.quantity.replace('_', ' ')}{threshold}"


def _cells(one: Together) -> tuple[str, ...]:
    unit = "" if one.relative else f", {show_unit(one.unit)}".removesuffix(", ")
    scale = 100.0 if one.relative else 1.0
    covered = one.coverage
    return (
        f"{_name(one)}{unit}",
        _number(one.bias * scale, "+.2g"),
        _number(one.bias_std_error * scale, ".1g"),
        _number(one.sd * scale, ".2g"),
        _number(one.scatter_ratio, ".2f"),
        MISSING if covered is None else f"{100.0 * covered[0]:.1f}",
        _number(one.pull_mean, "+.2f"),
        _number(one.pull_sd, ".2f"),
    )


def _number(value: float, form: str) -> str:
    return format(value, form) if math.isfinite(value) else MISSING
