"""A whole EMVA 1288 campaign, process against process: Fullwell's profile against the emva1288 package on one set."""

import json
import os
import statistics
import subprocess
import sys
import time
from pathlib import Path
from typing import Final

import numpy as np
import tifffile
from PIL import Image

from benchmarks.timing import Comparison

SIDE: Final = 2048
STEPS: Final = 50
STACK: Final = 50
_TARGETS: Final = {"tif": 8.0, "png": 4.0}
_REPEATS: Final = 3

_PACKAGE: Final = """
import sys
from pathlib import Path
from emva1288.process.data import Data1288
from emva1288.process.loader import LoadImageData
from emva1288.process.parser import ParseEmvaDescriptorFile
from emva1288.process.results import Results1288
descriptor, out, scope = sys.argv[1:]
Path(out).mkdir(exist_ok=True)
data = Data1288(LoadImageData(ParseEmvaDescriptorFile(descriptor).images).data).data
results = Results1288(data)
results.xml(out + "/results.xml")
if scope == "report":
    from emva1288.report.report import Report1288, info_op
    report = Report1288(out)
    report.add(info_op(), data, results=results)
    report.latex()
"""
"""A descriptor becomes a file of results; and a report: plots as PDF, and LaTeX that nobody has compiled yet."""

_OURS: Final = """
import os
import sys
from pathlib import Path
from fullwell.report.document import results_json
from fullwell.workflow.characterize import measure
from fullwell.workflow.options import Options
descriptor, out = sys.argv[1:]
Path(out).mkdir(exist_ok=True)
options = Options(profiles=("emva1288-4.0-linear",), workers=os.cpu_count())
Path(out, "results.json").write_text(results_json(measure(Path(descriptor), options=options).results))
"""
"""A descriptor becomes a file of results."""

SCOPES: Final = ("results", "report")


def against_package(folder: Path) -> list[Comparison]:
    """Compare with the package in the environment that FULLWELL_EMVA1288 names (the path of its python).

    Results are compared with results, the report with the report. Both sides are whole processes, run in turns on files
    that the system holds in memory; the first turn of each, which compiles, does not count.
    """
    python = os.environ.get("FULLWELL_EMVA1288")
    found: list[Comparison] = []
    for ending, target in _TARGETS.items():
        descriptor = None if python is None else _write(folder / f"emva-{ending}", ending)
        for scope in SCOPES:
            name = f"EMVA 1288, {scope}, 300 frames of 4 megapixels, {ending}: emva1288 over fullwell"
            if python is None or descriptor is None:
                detail = "set FULLWELL_EMVA1288 to a python that has emva1288 1.0.2"
                found.append(Comparison(name=name, value=None, target=target, at_least=True, detail=detail))
                continue
            theirs, ours = _turns(_theirs(python, descriptor, scope), _ours(descriptor, scope))
            detail = f"{theirs[0]:.1f} s against {ours[0]:.1f} s"
            found.append(Comparison(name=name, value=theirs[0] / ours[0], target=target, at_least=True, detail=detail))
            if not theirs[1]:
                continue
            memory = f"EMVA 1288, {scope}, memory, {ending}: fullwell over emva1288"
            detail = f"{ours[1] / 1e6:.0f} MB against {theirs[1] / 1e6:.0f} MB"
            found.append(Comparison(name=memory, value=ours[1] / theirs[1], target=1.0, detail=detail))
    return found


def _theirs(python: str, descriptor: Path, scope: str) -> list[str]:
    return [python, "-c", _PACKAGE, str(descriptor), str(descriptor.parent / f"theirs-{scope}"), scope]


def _ours(descriptor: Path, scope: str) -> list[str]:
    out = str(descriptor.parent / f"ours-{scope}")
    if scope == "results":
        return [sys.executable, "-c", _OURS, str(descriptor), out]
    script = [sys.executable, "-m", "fullwell", "characterize", str(descriptor), "-o", out]
    return [*script, "--profile", "emva1288-4.0-linear", "--quiet", "--no-cache"]


def _turns(theirs: list[str], ours: list[str]) -> tuple[tuple[float, int], tuple[float, int]]:
    """Return the median time and the most memory of both, which take turns [s, byte]."""
    _run(theirs)
    _run(ours)
    pairs = [(_run(theirs), _run(ours)) for _ in range(_REPEATS)]
    first, second = (
        (statistics.median(run[0] for run in runs), max(run[1] for run in runs)) for runs in zip(*pairs, strict=True)
    )
    return first, second


def _run(command: list[str]) -> tuple[float, int]:
    """Return the time of a process and the most memory that it and its own processes took together [s, byte]."""
    environment = {name: value for name, value in os.environ.items() if name != "PYTHONDONTWRITEBYTECODE"}
    started = time.perf_counter()
    process = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, env=environment)
    most = 0
    while process.poll() is None:
        most = max(most, _held(process.pid))
        time.sleep(0.02)
    taken = time.perf_counter() - started
    if process.returncode:
        raise RuntimeError(f"{command[0]} ended with {process.returncode}: {json.dumps(command)}")
    return taken, most


def _held(pid: int) -> int:
    """Return the memory of a process and of those it started; 0 where the system does not tell [byte]."""
    try:
        pages = int(Path(f"/proc/{pid}/statm").read_text().split()[1])
        children = Path(f"/proc/{pid}/task/{pid}/children").read_text().split()
    except (OSError, IndexError):
        return 0
    return pages * os.sysconf("SC_PAGE_SIZE") + sum(_held(int(child)) for child in children)


def _write(root: Path, ending: str) -> Path:
    """Write a campaign by exposure time; every frame has the same noise at another place."""
    (root / "img").mkdir(parents=True)
    rng = np.random.default_rng(1)
    pattern = rng.normal(1.0, 0.0068, (SIDE, SIDE)).astype(np.float32)
    noise = rng.standard_normal(SIDE * SIDE, dtype=np.float32)
    lines = ["v 4.0", f"n 12 {SIDE} {SIDE}"]
    taken = 0

    def block(head: str, name: str, electrons: float, count: int) -> None:
        nonlocal taken
        lines.append(head)
        for number in range(count):
            path = root / "img" / f"{name}_{number:03d}.{ending}"
            lines.append(f"i img\\{path.name}")
            taken += 1
            moved = np.roll(noise, 7919 * taken).reshape(SIDE, SIDE)
            codes = 60.0 + 0.4 * electrons * pattern + np.sqrt(0.16 * electrons + 1.0) * moved
            _save(path, np.rint(codes).clip(0, 4095).astype(np.uint16))

    for step in range(1, STEPS + 1):
        electrons = 11500.0 * step / STEPS
        block(f"b {step * 200000} {electrons / 0.6}", f"b{step}", electrons, 2)
        block(f"d {step * 200000}", f"d{step}", 0.0, 2)
    block("b 4400000 8433.3", "half", 5060.0, STACK)
    block("d 4400000", "dark", 0.0, STACK)
    descriptor = root / "campaign.txt"
    descriptor.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return descriptor


def _save(path: Path, codes: np.ndarray) -> None:
    if path.suffix == ".png":
        Image.fromarray(codes).save(path, compress_level=1)
    else:
        tifffile.imwrite(path, codes, photometric="minisblack")
