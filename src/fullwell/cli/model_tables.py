"""What people read after ``fullwell model``: conventions, a table a dialect, findings."""

from collections.abc import Sequence
from itertools import groupby
from typing import Final

from rich.console import Console
from rich.markup import escape

from fullwell.cli.tables import plain_table, print_findings
from fullwell.figures.noise_model import Conventions
from fullwell.figures.noise_translation import Translation
from fullwell.figures.results import Row
from fullwell.report.numbers import show, show_unit
from fullwell.workflow.model import Conversion, ConvertedModel

_BY_METHOD: Final = {
    "emva1288-4.0-linear": "EMVA 1288 R4.0",
    "emva1288-py-1.0": "emva1288 package",
    "noise-model": "all noise",
    "shot-only": "photon noise",
}


def print_conversion(console: Console, conversion: Conversion) -> None:
    """Print the models of all channels together, or of every channel where there is none, ISO after ISO."""
    models = [one for one in conversion.models if one.model.channel == "all"] or list(conversion.models)
    for one in models:
        _print_model(console, one)
    left_out = len(conversion.models) - len(models)
    if left_out:
        console.print(f"{left_out} models of single channels are in the document: --json.", soft_wrap=True)
    print_findings(console, conversion.findings)


def _print_model(console: Console, one: ConvertedModel) -> None:
    iso = "" if one.model.iso is None else f", ISO {one.model.iso:g}"
    if one.model.channel != "all" or iso:
        console.print(f"Channel {escape(one.model.channel)}{iso}", style="bold", highlight=False)
    console.print(_conventions(one.model.conventions), highlight=False, soft_wrap=True)
    for dialect, figures in groupby(one.figures, key=lambda figure: figure.dialect):
        _print_dialect(console, dialect, list(figures))


def _conventions(conventions: Conventions) -> str:
    black = "unknown" if conventions.black_level is None else f"{conventions.black_level:g} DN"
    white = "unknown" if conventions.white_level is None else f"{conventions.white_level:g} DN"
    said = (
        "sigma^2 = k_dark^2 + k_shot^2 V + k_fpn^2 V^2 of one frame, V = (value - black) / D; "
        f"D = {conventions.digital_maximum:g} DN ({conventions.digital_maximum_is}), black {black}, white {white}"
    )
    if conventions.step != 1.0:
        said += f", codes {conventions.step:g} DN apart"
    if conventions.exposure_s:
        said += f", exposed for {conventions.exposure_s:g} s"
    return said + "."


def _print_dialect(console: Console, dialect: str, figures: Sequence[Translation]) -> None:
    table = plain_table("figure", ">value", "unit", "how", "flags", title=dialect)
    for figure in figures:
        row = figure.row
        if not row.quantity.endswith("_variance"):
            how = f"= {figure.equation}" if row.method in {"conversion", *_BY_METHOD} else row.method
            if row.method in _BY_METHOD:
                how += f" ({_BY_METHOD[row.method]})"
            flags = ", ".join(flag for flag in row.flags if flag != "recommended")
            table.add_row(figure.symbol, _shown(row), show_unit(row.measured.unit), how, flags)
    console.print(table, highlight=False)


def _shown(row: Row) -> str:
    """Return a figure to the digits of its error; one without an error as it can be typed in again."""
    exact = row.measured.std_error is None and "upper-limit" not in row.flags
    return f"{row.measured.value:.6g}" if exact else show(row.measured, row.flags)
