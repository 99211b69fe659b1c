"""Whole runs that are killed, or share a cache, come to the bytes of one from the beginning."""

import json
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest
from mixed_study import write_frame

SIZE, FRAMES = (120, 160), 4
PLAN = {"flat/exp10ms": 10, "flat/exp20ms": 11, "dark/exp10ms": 12, "dark/exp20ms": 13, "bias/exp1ms": 14}
KILLED = """
import os, signal, sys
from fullwell.cli import main
from fullwell.workflow.cache import series_cache
written, write = [], series_cache.write_packed
def killed_in_the_third(file, value):
    write(file, value)
    written.append(file.name)
    if len(written) == 3:
        file.truncate(file.tell() // 2)
        os.kill(os.getpid(), signal.SIGKILL)
series_cache.write_packed = killed_in_the_third
main()
"""
REDUCED = """
import hashlib, sys, time
from pathlib import Path
from fullwell.frames.selection import Selection
from fullwell.frames.study import load_study
from fullwell.workflow.cache.opening import opened_cache
from fullwell.workflow.cache.series_cache import SeriesCache
from fullwell.workflow.options import CacheChoice, Options
from fullwell.workflow.reduce import reduce_study
study = load_study(Path(sys.argv[1]), Selection())
time.sleep(max(0.0, float(sys.argv[3]) - time.time()))
for _ in range(5):
    cache = SeriesCache(Path(sys.argv[2]), recheck=True)
    found = reduce_study(study, workers=2, keep=tuple(one.kind for one in study.series), cache=cache)
    cache.sweep()
    digest = hashlib.sha256(repr(found.statistics).encode())
    for sums in found.sums.values():
        digest.update(sums.tobytes())
    print(digest.hexdigest())
"""


@pytest.fixture(scope="module")
def on_disk(tmp_path_factory: pytest.TempPathFactory) -> Path:
    root = tmp_path_factory.mktemp("resume") / "study"
    for folder, seed in PLAN.items():
        (root / folder).mkdir(parents=True)
        rng = np.random.default_rng(seed)
        level = 64 if "flat" not in folder else 100 * (seed - 7)
        for number in range(FRAMES):
            mosaic = rng.normal(level, 3 + level**0.5 / 4, SIZE).round().clip(0, 1023).astype(np.uint16)
            write_frame(root / folder / f"{number}.dng", mosaic, 2 * number % 4 + 1)
    return root


def measured(study: Path, out: Path, *options: str, code: str = "from fullwell.cli import main; main()") -> int:
    command = [sys.executable, "-c", code, "characterize", str(study), "-o", str(out), "--workers", "1", "--quiet"]
    return subprocess.run([*command, *options], check=False, timeout=300).returncode


def results(out: Path) -> tuple[bytes, dict[str, object]]:
    """Return the document without ``run``, and what ``run`` says of the cache."""
    document = json.loads((out / "results.json").read_text())
    run = document.pop("run")
    return json.dumps(document).encode(), run["cache"]


def test_a_killed_run_is_resumed_to_the_same_bytes(on_disk: Path, tmp_path: Path) -> None:
    out, whole, kept = tmp_path / "out", tmp_path / "whole", tmp_path / "out.cache"
    assert measured(on_disk, out, code=KILLED) == -signal.SIGKILL
    assert not out.exists()
    assert len(list(kept.glob("*.series"))) == 2
    assert len(list(kept.glob("*.part"))) == 1
    assert measured(on_disk, out) in {0, 1}
    assert measured(on_disk, whole, "--no-cache") in {0, 1}
    resumed, told = results(out)
    assert told["series_found"] == 2
    assert results(whole) == (resumed, None)
    assert not (tmp_path / "whole.cache").exists()


def test_two_runs_share_a_cache(on_disk: Path, tmp_path: Path) -> None:
    start = str(time.time() + 6.0)  # both are up by then, and run side by side
    command = [sys.executable, "-c", REDUCED, str(on_disk), str(tmp_path / "cache"), start]
    running = [subprocess.Popen(command, stdout=subprocess.PIPE, text=True) for _ in range(2)]
    found = [one.communicate(timeout=300)[0].split() for one in running]
    assert [len(digests) for digests in found] == [5, 5]
    assert len({digest for digests in found for digest in digests}) == 1
    assert not list((tmp_path / "cache").glob("*.part"))
