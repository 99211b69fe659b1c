"""A DNG of 12 megapixels against LibRaw, which most raw software stands on: one thread each, pairs in turn."""

import statistics
from pathlib import Path
from typing import Literal

import numpy as np
import rawpy
from numpy.typing import NDArray

from benchmarks.studies import frames_of, write_study
from benchmarks.timing import REPEATS, Comparison, cpu_seconds
from fullwell.frames.series import Kind
from fullwell.raw.open import read_raw


def uncompressed(folder: Path) -> list[Comparison]:
    """Compare reading an uncompressed DNG."""
    name = "LibRaw / reading an uncompressed DNG of 12 MP"
    return _against_libraw(folder, name=name, compression="none", target=10.0)


def lossless_jpeg(folder: Path) -> list[Comparison]:
    """Compare decoding a lossless-JPEG DNG."""
    name = "LibRaw / decoding a lossless-JPEG DNG of 12 MP, per core"
    return _against_libraw(folder, name=name, compression="lossless-jpeg", target=2.0)


def _against_libraw(
    folder: Path, *, name: str, compression: Literal["none", "lossless-jpeg"], target: float
) -> list[Comparison]:
    """Compare the processor time of one frame from a file in the system's cache."""
    study = write_study(folder / "study", ((Kind.FLAT, 1),), compression=compression)
    path = frames_of(study)[0].header.path

    def ours() -> NDArray[np.uint16]:
        return read_raw(path).mosaic

    def libraw() -> NDArray[np.uint16]:
        with rawpy.imread(str(path)) as raw:
            return raw.raw_image_visible.copy()

    if not np.array_equal(ours(), libraw()):
        raise RuntimeError("LibRaw decoded something else")
    pairs = [(cpu_seconds(libraw), cpu_seconds(ours)) for _ in range(2 * REPEATS)]
    theirs_s, ours_s = (statistics.median(times) for times in zip(*pairs, strict=True))
    ratio = statistics.median(other / own for other, own in pairs)
    detail = f"{theirs_s * 1e3:.1f} ms against {ours_s * 1e3:.1f} ms of processor time, header included"
    return [Comparison(name=name, value=ratio, target=target, at_least=True, detail=detail)]
