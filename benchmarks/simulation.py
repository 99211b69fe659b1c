"""Simulated frames of 12.19 megapixels: random numbers against NumPy's, the whole camera against them and another's."""

import json
import os
import subprocess
import threading
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from benchmarks.studies import BLACK, HEIGHT, WHITE, WIDTH
from benchmarks.timing import Comparison, medians
from fullwell.kernels.random import Draws, add_normal, poisson
from fullwell.model.sensor import SensorParameters
from fullwell.simulate.camera import Surroundings, build, take
from fullwell.simulate.geometry import tiles
from fullwell.simulate.lens import Lens
from fullwell.simulate.shot import Exposure

WORKERS = 2
PIXELS = HEIGHT * WIDTH
LEVELS = ((800.0, 8.0), (3.0, 2.5))
READ_NOISE = 2.5
CAMERA = "emva1288's camera / ours, the whole chain, per pixel"
SENSOR = SensorParameters(
    width=WIDTH,
    height=HEIGHT,
    cfa="RGGB",
    bit_depth=10,
    black_level=(float(BLACK),) * 4,
    white_level=WHITE,
    base_iso=100.0,
    system_gain=0.17,
    full_well=6000.0,
    response=(0.5, 1.0, 1.0, 0.6),
    read_noise=READ_NOISE,
    read_noise_row=0.3,
    dark_current=4.0,
    dsnu=1.0,
    prnu=0.007,
)
_PEER = """
import json, statistics, time
import numpy as np
from emva1288.camera.camera import Camera
camera = Camera(width=640, height=480, bit_depth=12)
radiance = camera.get_radiance_for(mean=2000.0)
times = []
for _ in range(6):
    started = time.perf_counter()
    camera.grab(radiance)
    times.append(time.perf_counter() - started)
print(json.dumps({"seconds": statistics.median(times[1:]), "pixels": 640 * 480}))
"""


def against_numpy() -> list[Comparison]:
    """Compare Poisson numbers and read noise with NumPy's, and the whole chain with those two."""
    camera = build(
        SENSOR,
        seed=1,
        around=Surroundings(lens=Lens(shading="cos4", exponents=(1.0,) * 4, focal_length_mm=4.38, flare=0.001)),
    )
    found: list[Comparison] = []
    for level, target in LEVELS:
        exposure = Exposure(iso=100.0, exposure_s=0.01, electrons=level)
        times = medians(
            {
                "numpy": lambda level=level: with_numpy(level),
                "ours": lambda level=level: on_two_threads(lambda frame: noise(level, frame)),
                "chain": lambda exposure=exposure: on_two_threads(lambda _frame: take(camera, exposure)),
            }
        )
        ours, chain = times["ours"] / WORKERS, times["chain"] / WORKERS
        detail = f"{times['numpy'] * 1e3:.0f} ms, one thread, against {ours * 1e3:.0f} ms a frame on {WORKERS} threads"
        name = f"NumPy / Poisson and read noise of 12 MP at {level:g} e-"
        found.append(Comparison(name=name, value=times["numpy"] / ours, target=target, at_least=True, detail=detail))
        detail = f"{chain * 1e3:.0f} ms a frame on {WORKERS} threads"
        name = f"The whole camera / Poisson and read noise of 12 MP at {level:g} e-"
        found.append(Comparison(name=name, value=chain / ours, target=2.0, detail=detail))
        if level == LEVELS[0][0]:
            found += _against_emva1288(chain / PIXELS)
    return found


def with_numpy(level: float) -> NDArray[np.float64]:
    """Return Poisson electrons and read noise as anybody would make them."""
    rng = np.random.default_rng(1)
    return rng.poisson(level, (HEIGHT, WIDTH)) + READ_NOISE * rng.standard_normal((HEIGHT, WIDTH))


def noise(level: float, frame: int) -> NDArray[np.float64]:
    """Return the same of our own numbers, tile by tile."""
    out = np.empty((HEIGHT, WIDTH))
    for tile in tiles(HEIGHT, WIDTH):
        first = tile.top * WIDTH
        charge = poisson(np.full(tile.shape, level), Draws(seed=1, stream=3, frame=frame, first=first, stride=WIDTH))
        add_normal(charge, READ_NOISE, Draws(seed=1, stream=4, frame=frame, first=first, stride=WIDTH))
        out[tile.window] = charge
    return out


def on_two_threads(work: Callable[[int], object]) -> None:
    """Make a frame on each of two threads."""
    threads = [threading.Thread(target=work, args=(number,)) for number in range(WORKERS)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()


def _against_emva1288(ours_s: float) -> list[Comparison]:
    """Compare with the camera of emva1288 in the environment that FULLWELL_PEERS names (the path of its python)."""
    peers = os.environ.get("FULLWELL_PEERS")
    if peers:
        done = subprocess.run([peers, "-c", _PEER], check=False, capture_output=True, text=True)
        if done.returncode == 0:
            peer = json.loads(done.stdout)
            theirs_s = peer["seconds"] / peer["pixels"]
            detail = f"{theirs_s * 1e9:.0f} ns against {ours_s * 1e9:.1f} ns a pixel"
            return [Comparison(name=CAMERA, value=theirs_s / ours_s, target=40.0, at_least=True, detail=detail)]
    detail = "set FULLWELL_PEERS to a python that has emva1288 (numpy below 2)"
    return [Comparison(name=CAMERA, value=None, target=40.0, at_least=True, detail=detail)]
