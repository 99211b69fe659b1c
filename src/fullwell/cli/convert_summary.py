"""What was converted, one line per file for people."""

import sys
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import cast

from rich.console import Console
from rich.markup import escape

from fullwell.cli.tables import print_findings, spelled_values
from fullwell.workflow.convert.convert import ConvertOutcome


def print_converted(outcome: ConvertOutcome) -> None:
    """Print what became of each file, then what could not be kept."""
    console = Console(file=sys.stdout, soft_wrap=True, highlight=False)
    files = cast("Sequence[Mapping[str, object]]", outcome.document["files"])
    for one in files:
        console.print(escape(f"{one['path']} -> {one['out']}"))
        console.print(f"  {_scale(one)}", style="dim")
    alone = len(files) == 1 and all(len(one.files) == 1 for one in outcome.findings)
    print_findings(console, [replace(one, files=()) for one in outcome.findings] if alone else outcome.findings)
    console.print(f"{len(files)} converted. Dates, lens, maker notes and previews are not carried over.")


def _scale(one: Mapping[str, object]) -> str:
    black = cast("Sequence[float] | None", one["black_level"])
    kind = "picture" if one["picture"] else one["cfa"]
    level = "not written" if black is None else f"{spelled_values(black)} DN"
    return (
        f"{one['raw_width']} x {one['raw_height']}, {kind}, {one['bit_depth']} bit, black level {level}, "
        f"white level {one['white_level']:g} DN"
    )
