"""What was converted, as a table for people."""

import sys
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import cast

from rich.console import Console
from rich.markup import escape

from fullwell.cli.tables import plain_table, print_findings, spelled_values
from fullwell.report.numbers import show_exposure
from fullwell.workflow.convert.convert import ConvertOutcome


def print_converted(outcome: ConvertOutcome) -> None:
    """Print one line per file, then what could not be kept."""
    console = Console(file=sys.stdout)
    table = plain_table("file", "written", ">size", "CFA", ">bits", ">black", ">white", ">ISO", ">exposure")
    files = cast("Sequence[Mapping[str, object]]", outcome.document["files"])
    for one in files:
        iso, exposure_s = one["iso"], one["exposure_s"]
        black = cast("Sequence[float] | None", one["black_level"])
        table.add_row(
            escape(Path(str(one["path"])).name),
            escape(str(one["out"])),
            f"{one['raw_width']} x {one['raw_height']}",
            "picture" if one["picture"] else str(one["cfa"]),
            str(one["bit_depth"]),
            "?" if black is None else spelled_values(black),
            f"{one['white_level']:g}",
            "?" if iso is None else f"{iso:g}",
            "?" if not isinstance(exposure_s, float) else show_exposure(exposure_s),
        )
    console.print(table)
    alone = len(files) == 1 and not any(str(files[0]["path"]) not in one.files for one in outcome.findings)
    print_findings(console, [replace(one, files=()) for one in outcome.findings] if alone else outcome.findings)
    console.print(
        f"{len(files)} converted. Dates, lens, maker notes and previews are not carried over.",
        highlight=False,
        soft_wrap=True,
    )
