"""An uncompressed frame of 12 megapixels against LibRaw, which most raw software stands on."""

import statistics
from pathlib import Path

import numpy as np
import rawpy
from numpy.typing import NDArray

from benchmarks.studies import frames_of, write_study
from benchmarks.timing import REPEATS, Comparison, cpu_seconds
from fullwell.frames.series import Kind
from fullwell.raw.open import read_raw

NAME = "LibRaw / reading an uncompressed DNG of 12 MP"


def against_libraw(folder: Path) -> list[Comparison]:
    """Compare reading and decoding an uncompressed DNG, one thread each."""
    header = frames_of(write_study(folder / "study", ((Kind.FLAT, 1),)))[0].header

    def ours() -> NDArray[np.uint16]:
        return read_raw(header.path).mosaic

    def libraw() -> NDArray[np.uint16]:
        with rawpy.imread(str(header.path)) as raw:
            return raw.raw_image_visible.copy()

    if not np.array_equal(ours(), libraw()):
        raise RuntimeError("LibRaw decoded something else")
    pairs = [(cpu_seconds(libraw), cpu_seconds(ours)) for _ in range(2 * REPEATS)]
    theirs_s, ours_s = (statistics.median(times) for times in zip(*pairs, strict=True))
    ratio = statistics.median(other / own for other, own in pairs)
    detail = f"{theirs_s * 1e3:.1f} ms against {ours_s * 1e3:.1f} ms of processor time, header included"
    return [Comparison(name=NAME, value=ratio, target=10.0, at_least=True, detail=detail)]
