"""Mean and variance of a burst against what astronomers, array users and dask.array make of the same frames."""

import json
import os
import subprocess
from collections.abc import Callable
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from benchmarks.studies import mosaic
from benchmarks.timing import Comparison, medians
from fullwell.statistics.maps import burst_maps

FRAMES = 5
CHUNK = 512
WORKERS = 2
NAME = f"ccdproc.combine / burst maps: {FRAMES} frames of 12 MP"
_PEER = """
import json, statistics, sys, time
import ccdproc, numpy
from astropy.nddata import CCDData
frames = [CCDData(frame, unit="adu") for frame in numpy.load(sys.argv[1])]
times = []
for _ in range(6):
    started = time.perf_counter()
    combined = ccdproc.combine(frames, method="average")
    times.append(time.perf_counter() - started)
print(json.dumps({"seconds": statistics.median(times[1:]), "version": ccdproc.__version__,
                  "mean": float(combined.data.mean())}))
"""


def against_ccdproc(folder: Path) -> list[Comparison]:
    """Compare with ccdproc in the environment that FULLWELL_PEERS names (the path of its python)."""
    peers = os.environ.get("FULLWELL_PEERS")
    if not peers:
        detail = "set FULLWELL_PEERS to a python that has ccdproc"
        return [Comparison(name=NAME, value=None, target=100.0, at_least=True, detail=detail)]
    frames = _burst()
    np.save(folder / "burst.npy", frames)
    maps = np.empty((2, *frames.shape[1:]), np.float32)
    before = medians({"maps": lambda: burst_maps(frames, workers=WORKERS, out=maps)})["maps"]
    command = [peers, "-c", _PEER, str(folder / "burst.npy")]
    peer = json.loads(subprocess.run(command, check=True, capture_output=True, text=True).stdout)
    after = medians({"maps": lambda: burst_maps(frames, workers=WORKERS, out=maps)})["maps"]
    ours = (before + after) / 2
    if not np.isclose(peer["mean"], float(frames.mean()), rtol=1e-9):
        raise RuntimeError("ccdproc combined other frames than ours")
    return [
        Comparison(
            name=NAME,
            value=peer["seconds"] / ours,
            target=100.0,
            at_least=True,
            detail=f"{peer['seconds']:.2f} s (ccdproc {peer['version']}) against {ours * 1e3:.1f} ms",
        )
    ]


def _burst() -> NDArray[np.uint16]:
    return np.stack([mosaic(number) for number in range(FRAMES)])


def _compared(
    name: str, theirs: Callable[[], object], frames: NDArray[np.uint16], *, target: float
) -> list[Comparison]:
    maps = np.empty((2, *frames.shape[1:]), np.float32)
    times = medians({"theirs": theirs, "ours": lambda: burst_maps(frames, workers=WORKERS, out=maps)})
    detail = f"{times['theirs'] * 1e3:.0f} ms against {times['ours'] * 1e3:.1f} ms"
    return [Comparison(name=name, value=times["theirs"] / times["ours"], target=target, at_least=True, detail=detail)]


def against_numpy(_: Path) -> list[Comparison]:
    """Compare with what anybody would write, and with the same in blocks that stay in the cache."""
    frames = _burst()
    ours = burst_maps(frames, workers=WORKERS)
    naive = frames.mean(axis=0), frames.var(axis=0, ddof=1)
    if not all(np.allclose(one, other, rtol=1e-5) for one, other in zip(ours, naive, strict=True)):
        raise RuntimeError("NumPy found something else")
    size = f"{FRAMES} frames of 12 MP"
    return _compared(
        f"NumPy's mean and var / burst maps: {size}",
        lambda: (frames.mean(axis=0), frames.var(axis=0, ddof=1)),
        frames,
        target=10.0,
    )


def against_dask(_: Path) -> list[Comparison]:
    """Compare with dask.array, in blocks, on as many threads."""
    from dask import array, config  # noqa: PLC0415 - a peer, loaded when it is asked for

    frames = _burst()
    blocks = array.from_array(frames, chunks=(FRAMES, CHUNK, CHUNK))

    def theirs() -> object:
        with config.set(scheduler="threads", num_workers=WORKERS):
            return array.compute(blocks.mean(axis=0), blocks.var(axis=0, ddof=1))

    if not np.allclose(theirs()[0], frames.mean(axis=0)):
        raise RuntimeError("dask.array found something else")
    return _compared(f"dask.array / burst maps: {FRAMES} frames of 12 MP", theirs, frames, target=10.0)
