"""Studies on disk with the content of real frames: 12.19 megapixels, 10 bits, noise around a shaded surface."""

import os
from pathlib import Path
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from fullwell.frames.series import Camera, Frame, Kind, Series, Study
from fullwell.raw.open import read_header
from fullwell.raw.write import write_dng

HEIGHT, WIDTH = (int(side) for side in os.environ.get("FULLWELL_BENCH_SIZE", "3024x4032").split("x"))
FRAMES = int(os.environ.get("FULLWELL_BENCH_FRAMES", "150"))
"""Of the larger studies; both are smaller where only results are compared."""
DISTINCT = 6
BLACK, WHITE = 64, 1023


def mosaic(number: int, *, dark: bool = False) -> NDArray[np.uint16]:
    """Return a frame: read noise over black, or shot noise around a surface that falls off to the corners."""
    rng = np.random.default_rng(number)
    noise = rng.standard_normal((HEIGHT, WIDTH), dtype=np.float32)
    if dark:
        return (BLACK + 2 * noise).round().clip(0, WHITE).astype(np.uint16)
    y, x = np.ogrid[-1 : 1 : HEIGHT * 1j, -1 : 1 : WIDTH * 1j]
    signal = (500 / (1 + 0.5 * (x * x + y * y)) ** 2).astype(np.float32)
    signal[::2, ::2] *= 0.6
    signal[1::2, 1::2] *= 0.7
    return (BLACK + signal + np.sqrt(4 + 0.2 * signal) * noise).round().clip(0, WHITE).astype(np.uint16)


def write_study(
    folder: Path, series: tuple[tuple[Kind, int], ...], *, compression: Literal["none", "lossless-jpeg"] = "none"
) -> Study:
    """Write series of some kinds and numbers of frames; beyond the first few the same content is written again."""
    folder.mkdir(parents=True)
    contents: dict[tuple[bool, int], bytes] = {}
    for index, (kind, count) in enumerate(series):
        for number in range(count):
            path = folder / f"{index:02d}-{kind}-{number:03d}.dng"
            content = (kind is not Kind.FLAT, number % DISTINCT)
            if content in contents:
                path.write_bytes(contents[content])
                continue
            write_dng(
                path,
                mosaic(content[1], dark=content[0]),
                cfa="RGGB",
                black_level=(BLACK,) * 4,
                white_level=WHITE,
                bit_depth=10,
                iso=100,
                exposure_s=0.01,
                compression=compression,
            )
            contents[content] = path.read_bytes()
    return study_in(folder)


def study_in(folder: Path) -> Study:
    """Return the study that `write_study` wrote into a folder."""
    series: dict[tuple[str, str], list[Frame]] = {}
    for path in sorted(folder.glob("*.dng")):
        index, kind, _number = path.stem.split("-")
        frame = Frame(name=path.name, header=read_header(path), size=path.stat().st_size)
        series.setdefault((index, kind), []).append(frame)
    return Study(
        root=folder,
        camera=Camera(),
        series=tuple(
            Series(kind=Kind(kind), iso=100.0, exposure_s=0.01 * (int(index) + 1), frames=tuple(frames))
            for (index, kind), frames in series.items()
        ),
        width=WIDTH,
        height=HEIGHT,
        cfa="RGGB",
        bit_depth=10,
        black_level=None,
        white_level=None,
    )


def frames_of(study: Study) -> list[Frame]:
    """Return every frame of a study."""
    return [frame for series in study.series for frame in series.frames]


def small_study(folder: Path) -> Path:
    """Write a study folder of 20 frames of a megapixel: two exposures of flats, two of darks, five frames each."""
    rows, columns = min(HEIGHT, 1024), min(WIDTH, 1024)
    for kind, exposure_s in (("flat", 0.01), ("flat", 0.02), ("dark", 0.01), ("dark", 0.04)):
        for number in range(5):
            path = folder / kind / f"{exposure_s:g}s-{number}.dng"
            path.parent.mkdir(parents=True, exist_ok=True)
            codes = mosaic(100 * number + round(1000 * exposure_s), dark=kind == "dark")[:rows, :columns]
            lit = BLACK + (codes.astype(np.int64) - BLACK) * (1 if exposure_s < 0.02 or kind == "dark" else 2) // 2
            write_dng(
                path,
                (lit if kind == "flat" else codes).clip(0, WHITE).astype(np.uint16),
                cfa="RGGB",
                black_level=(BLACK,) * 4,
                white_level=WHITE,
                bit_depth=10,
                iso=100,
                exposure_s=exposure_s,
            )
    return folder
