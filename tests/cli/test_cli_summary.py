"""What people read at the end: figures to the digits their uncertainty allows, findings, where the report is."""

import io
from pathlib import Path

import pytest
from rich.console import Console

from fullwell.cli.demo_summary import print_outcome
from fullwell.cli.summary import print_summary
from fullwell.figures.results import Results, Row
from fullwell.findings import Finding, Severity
from fullwell.units import Measured
from fullwell.workflow.demo import DemoOutcome
from fullwell.workflow.loop.comparison import Comparison


def results(*rows: Row) -> Results:
    findings = (
        Finding(code="b", severity=Severity.INFO, message="Said last [sic].", files=("a/b.dng",)),
        Finding(code="a", severity=Severity.ERROR, message="Left out x.dng: no.", files=("x.dng",)),
    )
    return Results(study={}, rows=rows, findings=findings, curves=())


def row(
    quantity: str,
    channel: str,
    measured: Measured,
    *flags: str,
    iso: float | None = 100.0,
    region: str | None = None,
) -> Row:
    return Row(quantity=quantity, channel=channel, method="m", measured=measured, flags=flags, iso=iso, region=region)


def shown(found: Results) -> str:
    console = Console(file=io.StringIO(), width=120)
    print_summary(console, found, out=Path("results"))
    assert isinstance(console.file, io.StringIO)
    return console.file.getvalue()


def test_recommended_figures_per_iso_and_channel() -> None:
    text = shown(
        results(
            row("read_noise", "G1", Measured.normal(5.43210, 0.0123, "DN"), "recommended"),
            row("read_noise", "G1", Measured.normal(31.98765, 0.0721, "e-"), "recommended"),
            row("read_noise", "B", Measured.normal(30.11111, 0.0721, "e-"), "recommended"),
            row("read_noise", "B", Measured.normal(99.0, 0.1, "e-")),
            row("read_noise", "B", Measured.normal(77.0, 0.1, "e-"), "recommended", region="tile:0,0"),
            row("system_gain", "all", Measured.normal(0.17054, 0.00021, "DN/e-"), "recommended", iso=200.0),
        )
    )
    assert "31.988 ± 0.072" in text
    assert "30.111 ± 0.072" in text
    assert "0.17054 ± 0.00021" in text
    for absent in ("5.432", "99", "77"):
        assert absent not in text
    assert text.index("ISO 100") < text.index("31.988") < text.index("ISO 200") < text.index("0.17054")
    assert text.index("Left out x.dng") < text.index("Said last [sic].") < text.index("a/b.dng")
    assert text.rstrip().endswith(str(Path("results") / "report.html"))


def test_a_limit_is_shown_as_a_limit() -> None:
    limit = Measured(value=0.0, unit="e-/s", ci95=(0.0, 0.1234))
    assert "≤ 0.12" in shown(results(row("dark_current", "R", limit, "recommended", "upper-limit", iso=None)))


@pytest.mark.parametrize(("pulls", "words"), [((0.5, -4.0), "50.0 % within 1.96"), ((), "No figure has a pull")])
def test_truth_beside_measurement(pulls: tuple[float, ...], words: str) -> None:
    rows = tuple(
        Comparison(
            row=row("read_noise", channel, Measured.normal(1.2504, 0.0012, unit), "recommended", iso=55.0),
            truth=1.25,
            pull=pull,
        )
        for unit in ("DN", "e-")
        for channel, pull in zip(("R", "G1"), pulls, strict=False)
    )
    outcome = DemoOutcome(
        out=Path("out"), frames=336, rows=rows, results=results(), simulated_s=30.0, characterized_s=20.0
    )
    console = Console(file=io.StringIO(), width=140)
    print_outcome(console, outcome, out=Path("out"))
    assert isinstance(console.file, io.StringIO)
    text = console.file.getvalue()
    assert words in text
    assert "336 frames simulated in 30.0 s, measured in 20.0 s" in text
    if pulls:
        assert "read noise, e⁻" in text
        assert "read noise, DN" not in text
        (line,) = (line for line in text.splitlines() if line.lstrip().startswith("55"))
        assert line.split() == ["55", "1.25", "1.2504", "±", "0.0012", "+0.5", "\N{MINUS SIGN}4.0"]
