"""Truth beside measurement, as the demo prints it."""

from pathlib import Path

from rich.console import Console
from rich.markup import escape

from fullwell.cli.comparison import print_comparison, print_spread
from fullwell.cli.tables import print_findings
from fullwell.workflow.demo import DemoOutcome


def print_outcome(console: Console, outcome: DemoOutcome, *, out: Path) -> None:
    """Print findings, truth beside measurement, and how the pulls spread."""
    print_findings(console, outcome.findings)
    print_comparison(console, outcome.rows)
    print_spread(console, outcome.pulls)
    console.print(
        f"{outcome.frames} frames simulated in {outcome.simulated_s:.1f} s, "
        f"measured in {outcome.characterized_s:.1f} s.\n"
        f"Every figure beside its truth: {escape(str(out / 'demo.json'))}\n"
        f"Report: {escape(str(out / 'report.html'))}",
        highlight=False,
        soft_wrap=True,
    )
