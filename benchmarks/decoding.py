"""An uncompressed frame of 12 megapixels against LibRaw, which most raw software stands on."""

from pathlib import Path

import numpy as np
import rawpy
from numpy.typing import NDArray

from benchmarks.studies import frames_of, write_study
from benchmarks.timing import Comparison, medians
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
    times = medians({"libraw": libraw, "ours": ours})
    detail = f"{times['libraw'] * 1e3:.1f} ms against {times['ours'] * 1e3:.1f} ms"
    return [Comparison(name=NAME, value=times["libraw"] / times["ours"], target=10.0, at_least=True, detail=detail)]
