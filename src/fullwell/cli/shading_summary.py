"""What people read after ``fullwell shading``: findings, a short table, and where the files are."""

from collections.abc import Mapping, Sequence
from pathlib import PurePath
from typing import Final, cast

from rich.console import Console
from rich.markup import escape

from fullwell.cli.tables import plain_table, print_findings
from fullwell.report.numbers import show_exposure
from fullwell.workflow.shading.folder import ShadingOutcome

_Said = Mapping[str, object]
_PERCENT: Final = 100.0


def print_shading(console: Console, outcome: ShadingOutcome) -> None:
    """Print findings, what the command found, and the folder."""
    print_findings(console, outcome.findings)
    said = outcome.document
    {"fit": _print_fit, "compare": _print_comparison, "apply": _print_scenes}[str(said["command"])](console, said)
    console.print(f"Results: {escape(str(outcome.out))}", highlight=False, soft_wrap=True)


def _print_fit(console: Console, said: _Said) -> None:
    title = "Light that reaches corners and edges, relative to the maximum"
    table = plain_table(">ISO", ">exposure", "channel", "model", ">corner", ">edge x", ">edge y", title=title)
    for burst in _list(said["bursts"]):
        for channel in _list(burst["channels"]):
            chosen = next(model for model in _list(channel["models"]) if model["model"] == channel["chosen"])
            extent = (_share(chosen[name]) for name in ("corner", "edge_x", "edge_y"))
            table.add_row(*_burst(burst), str(channel["channel"]), str(channel["chosen"]), *extent)
    console.print(table)


def _print_comparison(console: Console, said: _Said) -> None:
    base = cast("_Said", said["base"])
    columns = (">ISO", ">exposure", "channel", ">rms %", ">largest / error", ">chi-square", ">dof", ">p")
    table = plain_table(*columns, title=f"Against {base['name']}")
    for one in _list(said["comparisons"]):
        for channel in _list(one["channels"]):
            table.add_row(
                *_burst(cast("_Said", one["map"])),
                str(channel["channel"]),
                f"{_PERCENT * _number(channel['rms']):.3f}",
                f"{_number(channel['largest_over_error']):.1f}",
                f"{_number(channel['chi_square']):.1f}",
                f"{_number(channel['dof']):.0f}",
                f"{_number(channel['p_value']):.3g}",
            )
    console.print(table)


def _print_scenes(console: Console, said: _Said) -> None:
    table = plain_table("scene", "CFA", "map", ">turned", ">shifted", ">scale")
    for scene in _list(said["scenes"]):
        rows, columns = cast("Sequence[int]", scene["colours_shifted"])
        table.add_row(
            escape(PurePath(str(scene["scene"])).name),
            str(scene["cfa"]),
            str(cast("_Said", scene["map"])["name"]),
            f"{scene['turned_right_degrees']}°",
            f"{rows}, {columns}",
            f"{_number(cast('_Said', scene['corrected'])['scale']):.4g}",
        )
    console.print(table)


def _burst(said: _Said) -> tuple[str, str]:
    iso = said["iso"]
    return ("unknown" if iso is None else f"{_number(iso):g}", show_exposure(_number(said["exposure_s"])))


def _share(said: object) -> str:
    """Return a fraction with its standard error, to the digits that hold."""
    measured = cast("_Said", said)
    value, error = _number(measured["value"]), measured["std_error"]
    return f"{value:.4f}" if error is None else f"{value:.4f} ± {_number(error):.1g}"


def _number(value: object) -> float:
    return float(cast("float", value))


def _list(said: object) -> Sequence[_Said]:
    return cast("Sequence[_Said]", said)
