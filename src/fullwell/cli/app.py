"""The commands put together."""

import sys
from typing import Annotated

import typer

from fullwell.cli.characterize import characterize
from fullwell.cli.chart import chart
from fullwell.cli.compare import compare
from fullwell.cli.convert import convert
from fullwell.cli.demo import demo
from fullwell.cli.fleet import fleet
from fullwell.cli.index import index
from fullwell.cli.inspect import inspect
from fullwell.cli.loop import loop
from fullwell.cli.model import model
from fullwell.cli.options import Version
from fullwell.cli.overview import overview, summary_of
from fullwell.cli.presets import presets
from fullwell.cli.shading import shading
from fullwell.cli.simulate import simulate

_CONTEXT = {"help_option_names": ["-h", "--help"]}

app = typer.Typer(rich_markup_mode=None, add_completion=False, pretty_exceptions_enable=False, add_help_option=False)
app.command(help=summary_of("characterize"), context_settings=_CONTEXT)(characterize)
app.command(help=summary_of("chart"), context_settings=_CONTEXT)(chart)
app.command(help=summary_of("compare"), context_settings=_CONTEXT)(compare)
app.command(help=summary_of("convert"), context_settings=_CONTEXT)(convert)
app.command(help=summary_of("demo"), context_settings=_CONTEXT)(demo)
app.command(help=summary_of("fleet"), context_settings=_CONTEXT)(fleet)
app.command(help=summary_of("index"), context_settings=_CONTEXT)(index)
app.command(help=summary_of("inspect"), context_settings=_CONTEXT)(inspect)
app.command(help=summary_of("loop"), context_settings=_CONTEXT)(loop)
app.command(help=summary_of("model"), context_settings=_CONTEXT)(model)
app.add_typer(presets, name="presets", help=summary_of("presets"), context_settings=_CONTEXT)
app.add_typer(shading, name="shading", help=summary_of("shading"), context_settings=_CONTEXT)
app.command(help=summary_of("simulate"), context_settings=_CONTEXT)(simulate)


def _show_overview(value: bool) -> None:  # noqa: FBT001 - Typer hands an option's value to its callback by position
    if value:
        sys.stdout.write(overview())
        raise typer.Exit


@app.callback(invoke_without_command=True)
def everything(
    context: typer.Context,
    *,
    _help: Annotated[
        bool, typer.Option("--help", "-h", callback=_show_overview, is_eager=True, help="Show this page and exit.")
    ] = False,
    _version: Version = False,
) -> None:
    """Measure image sensors from raw files."""
    if context.invoked_subcommand is None:
        sys.stderr.write(overview())
        raise typer.Exit(2)
