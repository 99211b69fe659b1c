"""The whole command: what a small study takes beside reading it, and the full-size demo study beside decoding it."""

import os
import subprocess
import sys
import time
from pathlib import Path

from benchmarks.reduction import WORKERS, decode_only, decode_with_imagecodecs, side_by_side
from benchmarks.studies import small_study
from benchmarks.timing import Comparison, medians
from fullwell.frames.selection import Selection
from fullwell.frames.series import Frame
from fullwell.frames.study import load_study

FULL_STUDY = "FULLWELL_FULL_STUDY"


_MAIN = """
import sys
from benchmarks.peak import peak_bytes
from fullwell.cli import main
try:
    main()
finally:
    sys.stderr.write(f"{peak_bytes()}\\n")
"""


def run(study: Path, out: Path, *options: str) -> tuple[float, int]:
    """Characterize a study in a process of its own; return how long it took [s] and its largest memory [byte]."""
    command = [sys.executable, "-c", _MAIN, "characterize", str(study), "-o", str(out), "--quiet", *options]
    started = time.perf_counter()
    ended = subprocess.run(command, check=False, stderr=subprocess.PIPE, text=True)
    taken = time.perf_counter() - started
    if ended.returncode not in {0, 1}:
        raise RuntimeError(ended.stderr)
    return taken, int(ended.stderr.split()[-1])


def small(folder: Path) -> list[Comparison]:
    """Time a study of 20 frames of a megapixel, as a user waits for it, and what loading the program takes of that."""
    study, out = small_study(folder / "study"), folder / "out"
    load = [sys.executable, "-c", "import fullwell.workflow.characterize, fullwell.report.plots"]
    times = medians(
        {
            "whole": lambda: run(study, out, "--no-cache"),
            "load": lambda: subprocess.run(load, check=True),
        }
    )
    detail = f"{times['load']:.2f} s of it to load the program"
    name = "characterize, report included: 20 frames of a megapixel"
    return [Comparison(name=name, value=times["whole"], target=10.0, unit="s", detail=detail)]


def full_study(folder: Path) -> list[Comparison]:
    """Compare `characterize` on a study of full-size frames, report included, with decoding its frames."""
    path = os.environ.get(FULL_STUDY)
    name = "characterize, report included / decoding: the full-size demo study"
    if not path:
        detail = f"set {FULL_STUDY} to the study that `fullwell demo --full` writes"
        return [Comparison(name=name, value=None, target=1.6, detail=detail)]
    frames: list[Frame] = [frame for one in load_study(Path(path), Selection()).series for frame in one.frames]
    decoders = {"imagecodecs": decode_with_imagecodecs, "our own": decode_only}
    decode_s = medians(
        {name: lambda decoder=decoder: side_by_side(frames, decoder) for name, decoder in decoders.items()}, repeats=1
    )
    out = folder / "out"
    took = [run(Path(path), out, "--no-cache", "--camera", "pixel-4a", "--workers", str(WORKERS)) for _ in range(2)]
    whole_s, peak = took[-1]
    return [
        *(
            Comparison(
                name=f"{name}, {decoder}",
                value=whole_s / alone_s,
                target=1.6,
                detail=f"{whole_s:.1f} s against {alone_s:.1f} s, {len(frames)} frames",
            )
            for decoder, alone_s in decode_s.items()
        ),
        Comparison(name="peak memory: the full-size demo study", value=peak / 1e9, target=1.0, unit="GB"),
    ]
