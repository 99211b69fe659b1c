"""Slope and intercept of every pixel against reading its means once, and against Octave's vectorized least squares."""

import json
import shutil
import subprocess
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from benchmarks.studies import HEIGHT, WIDTH, mosaic
from benchmarks.timing import REPEATS, Comparison, medians
from fullwell.statistics.pixels import response_maps

WORKERS = 2
EXPOSURES_S = (0.002, 0.004, 0.006, 0.008, 0.010)
OCTAVE = "Octave's [x ones]\\Y / slope and intercept, per pixel"
READING = f"slope and intercept / reading: {len(EXPOSURES_S)} means of 12 MP, {WORKERS} threads each"
_SOLVE = """
warning("off", "all");
x = [{times}]';
file = fopen("{path}"); Y = fread(file, [{pixels}, numel(x)], "single=>{kind}")'; fclose(file);
seconds = zeros(1, 3);
for k = 1:numel(seconds)
  tic; line = [x ones(numel(x), 1)] \\ Y; seconds(k) = toc;
end
found = {{median(seconds(2:end)), mean(double(line(1, :))), OCTAVE_VERSION}};
printf('{{"seconds": %.9g, "slope": %.9g, "version": "%s"}}\\n', found{{:}});
"""


def means() -> list[NDArray[np.float32]]:
    """Return one mean image for each exposure time."""
    surface = mosaic(0).astype(np.float32)
    return [np.float32(64.0) + surface * np.float32(t / EXPOSURES_S[-1]) for t in EXPOSURES_S]


def against_reading() -> list[Comparison]:
    """Compare with summing each mean once, in as many threads; results go to the same memory every time."""
    images, out = means(), np.empty((2, HEIGHT, WIDTH), np.float32)
    edges = [HEIGHT * k // WORKERS for k in range(WORKERS + 1)]
    parts = [image[edges[k] : edges[k + 1]] for image in images for k in range(WORKERS)]

    def read() -> None:
        with ThreadPoolExecutor(WORKERS) as pool:
            list(pool.map(np.sum, parts))

    def solve() -> None:
        response_maps(images, EXPOSURES_S, workers=WORKERS, out=out)

    times = medians({"read": read, "solve": solve}, repeats=2 * REPEATS)
    detail = f"{times['solve'] * 1e3:.1f} ms against {times['read'] * 1e3:.1f} ms"
    return [Comparison(name=READING, value=times["solve"] / times["read"], target=6.0, detail=detail)]


def against_octave(folder: Path) -> list[Comparison]:
    """Compare with GNU Octave where it is installed: the faster of its double and its single precision."""
    octave = shutil.which("octave-cli") or shutil.which("octave")
    if octave is None:
        return [Comparison(name=OCTAVE, value=None, target=20.0, at_least=True, detail="octave is not installed")]
    images, out = means(), np.empty((2, HEIGHT, WIDTH), np.float32)
    path = folder / "means.f32"
    np.stack(images).tofile(path)

    def ours() -> float:
        return medians({"solve": lambda: response_maps(images, EXPOSURES_S, workers=WORKERS, out=out)})["solve"]

    before = ours()
    peers = [_octave(octave, path, kind) for kind in ("double", "single")]
    mine = (before + ours()) / 2
    peer = min(peers, key=lambda one: one["seconds"])
    if not np.isclose(peer["slope"], out[0].mean(dtype=np.float64), rtol=1e-5):
        raise RuntimeError("Octave solved something else")
    theirs_ns, mine_ns = (seconds / (HEIGHT * WIDTH) * 1e9 for seconds in (peer["seconds"], mine))
    detail = f"{theirs_ns:.1f} ns (Octave {peer['version']}) against {mine_ns:.2f} ns a pixel"
    return [Comparison(name=OCTAVE, value=peer["seconds"] / mine, target=20.0, at_least=True, detail=detail)]


def _octave(octave: str, path: Path, kind: str) -> dict[str, float]:
    """Return Octave's median time [s] and its mean slope."""
    times = " ".join(map(str, EXPOSURES_S))
    script = path.with_suffix(f".{kind}.m")
    script.write_text(_SOLVE.format(times=times, path=path, pixels=HEIGHT * WIDTH, kind=kind), encoding="utf-8")
    command = [octave, "--no-gui", "--norc", "--quiet", str(script)]
    return json.loads(subprocess.run(command, check=True, capture_output=True, text=True).stdout)
