"""What benchmarks compare comes to the same; how fast is for `make bench` to say."""

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parent.parent
SMALL = {"FULLWELL_BENCH_SIZE": "192x256", "FULLWELL_BENCH_FRAMES": "40"}
NAMES = (
    "series",
    "bursts",
    "lossless-jpeg",
    "resume",
    "decoding",
    "lossless-jpeg-decoding",
    "numpy",
    "dask",
    "responses",
    "unpacking",
)


@pytest.mark.skipif(not (ROOT / "benchmarks").is_dir(), reason="an installed copy has no benchmarks")
def test_what_is_compared_is_the_same(tmp_path: Path) -> None:
    environment = {**os.environ, **SMALL, "PYTHONPATH": str(ROOT)}
    command = [sys.executable, "-m", "benchmarks", *NAMES]
    ended = subprocess.run(command, cwd=tmp_path, env=environment, capture_output=True, text=True, check=False)
    assert ended.returncode in {0, 1}, ended.stderr
    (kept,) = (tmp_path / "bench-results").glob("*.json")
    found = json.loads(kept.read_text())["comparisons"]
    assert len(found) >= len(NAMES)
    assert all(one["value"] > 0 for one in found)
