"""Run every benchmark, print the table, keep it as JSON: ``python -m benchmarks``."""

import json
import platform
import sys
import tempfile
from dataclasses import asdict
from datetime import UTC, datetime
from pathlib import Path

from benchmarks.bursts import against_ccdproc
from benchmarks.emva import against_package
from benchmarks.lossless_jpeg import against_libraw
from benchmarks.reduction import BURSTS, FRAMES, ONE_SERIES, compressed, uncompressed
from benchmarks.responses import against_octave, against_reading
from benchmarks.simulation import against_numpy as simulated_against_numpy
from benchmarks.timing import Comparison
from benchmarks.unpacking import against_numpy

RESULTS = Path("bench-results")


def line(one: Comparison) -> str:
    """Return a line of the table."""
    value = "-" if one.value is None else f"{one.value:.2f}"
    relation = ">=" if one.at_least else "<="
    return f"{one.name:72} {value:>7} {one.unit:2} {relation} {one.target:<6g} {one.verdict:8} {one.detail}"


def main() -> int:
    """Return 1 if a target was missed."""
    found: list[Comparison] = []
    with tempfile.TemporaryDirectory(prefix="fullwell-bench-") as name:
        folder = Path(name)
        for benchmark in (
            lambda: uncompressed(folder / "one", name=f"{FRAMES} flats in one series", series=ONE_SERIES, target=4.0),
            lambda: uncompressed(
                folder / "bursts", name=f"{FRAMES} frames in {len(BURSTS)} bursts", series=BURSTS, target=8.0
            ),
            lambda: compressed(folder / "compressed"),
            lambda: against_ccdproc(folder),
            lambda: against_package(folder),
            against_reading,
            lambda: against_octave(folder),
            against_numpy,
            lambda: against_libraw(folder),
            simulated_against_numpy,
        ):
            for one in benchmark():
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
    print(f"kept in {path}")
    return 1 if any(one.verdict == "MISSED" for one in found) else 0


if __name__ == "__main__":
    sys.exit(main())
