"""Mean and variance of a burst against the astronomers' combination of the same frames."""

import json
import os
import subprocess
from pathlib import Path

import numpy as np

from benchmarks.studies import mosaic
from benchmarks.timing import Comparison, medians
from fullwell.statistics.maps import burst_maps

FRAMES = 5
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
    frames = np.stack([mosaic(number) for number in range(FRAMES)])
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
