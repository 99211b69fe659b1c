"""Decoding a lossless-JPEG DNG against LibRaw: the same file, one thread each, pairs in turn."""

import statistics
from pathlib import Path

import numpy as np
import rawpy

from benchmarks.studies import BLACK, WHITE, mosaic
from benchmarks.timing import REPEATS, Comparison, cpu_seconds
from fullwell.raw.open import read_raw
from fullwell.raw.write import write_dng

NAME = "LibRaw / decoding a lossless-JPEG DNG of 12 MP, per core"


def against_libraw(folder: Path) -> list[Comparison]:
    """Compare the processor time of one frame: header and mosaic, from a file in the system's cache."""
    path = folder / "lossless.dng"
    frame = mosaic(0)
    levels = {"black_level": (BLACK,) * 4, "white_level": WHITE, "bit_depth": 10}
    write_dng(path, frame, cfa="RGGB", iso=100, exposure_s=0.01, compression="lossless-jpeg", **levels)
    if not (np.array_equal(read_raw(path).mosaic, frame) and np.array_equal(with_libraw(path), frame)):
        raise RuntimeError("a decoder gave something else than was written")
    pairs = [(cpu_seconds(lambda: with_libraw(path)), cpu_seconds(lambda: read_raw(path))) for _ in range(2 * REPEATS)]
    theirs, ours = (statistics.median(times) for times in zip(*pairs, strict=True))
    ratio = statistics.median(libraw / fullwell for libraw, fullwell in pairs)
    detail = f"{theirs * 1e3:.1f} ms against {ours * 1e3:.1f} ms of processor time"
    return [Comparison(name=NAME, value=ratio, target=2.0, at_least=True, detail=detail)]


def with_libraw(path: Path) -> np.ndarray:
    """Return the mosaic as LibRaw decodes it."""
    with rawpy.imread(str(path)) as raw:
        return np.array(raw.raw_image)
