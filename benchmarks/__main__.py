"""Run benchmarks, all or those named, print the table, keep it as JSON: ``python -m benchmarks [NAME...]``."""

import json
import platform
import sys
import tempfile
from collections.abc import Sequence
from dataclasses import asdict
from datetime import UTC, datetime
from pathlib import Path

from benchmarks.registry import BENCHMARKS
from benchmarks.timing import Comparison

RESULTS = Path("bench-results")


def line(one: Comparison) -> str:
    """Return a line of the table."""
    value = "-" if one.value is None else f"{one.value:.2f}"
    relation = ">=" if one.at_least else "<="
    return f"{one.name:72} {value:>7} {one.unit:2} {relation} {one.target:<6g} {one.verdict:8} {one.detail}"


def table(found: Sequence[Comparison]) -> str:
    """Return the lines as a table for docs/benchmarks.md."""
    rows = [
        f"| {one.name} | {'-' if one.value is None else f'{one.value:.2f}'} {one.unit} "
        f"| {'at least' if one.at_least else 'at most'} {one.target:g} | {one.detail} |"
        for one in found
    ]
    return "\n".join(["| what | measured | target | behind it |", "|---|---|---|---|", *rows, ""])


def main() -> int:
    """Return 1 if a target was missed, 2 if there is no such benchmark."""
    names = sys.argv[1:] or list(BENCHMARKS)
    if unknown := [name for name in names if name not in BENCHMARKS]:
        print(f"no benchmark {', '.join(unknown)}; there are {', '.join(BENCHMARKS)}")
        return 2
    found: list[Comparison] = []
    for name in names:
        with tempfile.TemporaryDirectory(prefix="fullwell-bench-") as folder:
            for one in BENCHMARKS[name](Path(folder)):
                print(line(one), flush=True)
                found.append(one)
    RESULTS.mkdir(exist_ok=True)
    now = datetime.now(UTC)
    kept = {
        "time": now.isoformat(timespec="seconds"),
        "machine": {"platform": platform.platform(), "processor": platform.processor(), "python": sys.version},
        "comparisons": [{**asdict(one), "verdict": one.verdict} for one in found],
    }
    path = RESULTS / f"{now:%Y%m%dT%H%M%SZ}.json"
    path.write_text(json.dumps(kept, indent=2) + "\n", encoding="utf-8")
    path.with_suffix(".md").write_text(table(found), encoding="utf-8")
    print(f"kept in {path} and {path.with_suffix('.md').name}")
    return 1 if any(one.verdict == "MISSED" for one in found) else 0


if __name__ == "__main__":
    sys.exit(main())
