"""A whole EMVA 1288 campaign, process against process: Fullwell's profile against the emva1288 package on one set."""

import json
import os
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

_PACKAGE: Final = """
import sys
from emva1288.process.data import Data1288
from emva1288.process.loader import LoadImageData
from emva1288.process.parser import ParseEmvaDescriptorFile
from emva1288.process.results import Results1288
parsed = ParseEmvaDescriptorFile(sys.argv[1])
Results1288(Data1288(LoadImageData(parsed.images).data).data).xml(sys.argv[2])
"""
"""What the package is for: a descriptor becomes a file of results."""


def against_package(folder: Path) -> list[Comparison]:
    """Compare with the package in the environment that FULLWELL_EMVA1288 names (the path of its python)."""
    python = os.environ.get("FULLWELL_EMVA1288")
    found: list[Comparison] = []
    for ending, target in _TARGETS.items():
        name = f"EMVA 1288, 300 frames of 4 megapixels, {ending}: emva1288 over fullwell"
        if python is None:
            detail = "set FULLWELL_EMVA1288 to a python that has emva1288 1.0.2"
            found.append(Comparison(name=name, value=None, target=target, at_least=True, detail=detail))
            continue
        root = folder / f"emva-{ending}"
        descriptor = _write(root, ending)
        theirs = _run([python, "-c", _PACKAGE, str(descriptor), str(root / "results.xml")])
        script = [sys.executable, "-m", "fullwell", "characterize", str(descriptor), "-o", str(root / "out")]
        options = ["--profile", "emva1288-4.0-linear", "--quiet", "--no-cache"]
        _run([*script, *options])
        ours = _run([*script, *options])
        detail = f"{theirs[0]:.1f} s against {ours[0]:.1f} s"
        found.append(Comparison(name=name, value=theirs[0] / ours[0], target=target, at_least=True, detail=detail))
        memory = f"EMVA 1288, memory, {ending}: fullwell over emva1288"
        detail = f"{ours[1] / 1e6:.0f} MB against {theirs[1] / 1e6:.0f} MB"
        found.append(Comparison(name=memory, value=ours[1] / theirs[1], target=1.0, detail=detail))
    return found


def _run(command: list[str]) -> tuple[float, int]:
    """Return the time of a process and the most memory it took [s, byte]."""
    started = time.perf_counter()
    process = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    _, status, usage = os.wait4(process.pid, 0)
    taken = time.perf_counter() - started
    process.returncode = os.waitstatus_to_exitcode(status)
    if process.returncode:
        raise RuntimeError(f"{command[0]} ended with {process.returncode}: {json.dumps(command)}")
    return taken, usage.ru_maxrss * (1 if sys.platform == "darwin" else 1024)


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
