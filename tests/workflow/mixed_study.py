"""A small study of all ways into memory, what its frames come to, and how two reductions are compared."""

import dataclasses
from pathlib import Path

import numpy as np
import tifffile

from fullwell.frames.series import Camera, Frame, Kind, Series, Study
from fullwell.raw.open import read_header
from fullwell.raw.write import write_dng
from fullwell.statistics.burst import burst_sums
from fullwell.statistics.finalize import finalize
from fullwell.statistics.moments import Layout, Moments, stack_of
from fullwell.statistics.series import SeriesStatistics
from fullwell.workflow.reduce import Reduction

HEIGHT, WIDTH, TILE = 70, 90, 16
PLAN = ((Kind.FLAT, 0.02, 9), (Kind.FLAT, 0.01, 4), (Kind.DARK, 0.02, 7), (Kind.BIAS, None, 1))
Mosaics = dict[str, np.ndarray]


def write_frame(path: Path, mosaic: np.ndarray, number: int) -> None:
    """Write every second frame compressed and every fifth as TIFF, so that all ways into memory are taken."""
    if number % 5 == 4:
        tifffile.imwrite(path, mosaic, photometric="minisblack")
        return
    compression = "lossless-jpeg" if number % 2 else "none"
    write_dng(path, mosaic, cfa="GRBG", black_level=(64,) * 4, white_level=1023, bit_depth=10, compression=compression)


def mixed_study(root: Path) -> tuple[Study, Mosaics]:
    rng = np.random.default_rng(5)
    mosaics: Mosaics = {}
    series: list[Series] = []
    for kind, exposure, count in PLAN:
        frames: list[Frame] = []
        for number in range(count):
            name = f"{kind}-{exposure}-{number:02d}.dng"
            mosaics[name] = rng.normal(300, 9, (HEIGHT, WIDTH)).round().astype(np.uint16)
            write_frame(root / name, mosaics[name], number)
            header = dataclasses.replace(read_header(root / name), cfa="GRBG")
            frames.append(Frame(name=name, header=header, size=(root / name).stat().st_size))
        series.append(Series(kind=kind, iso=100.0, exposure_s=exposure, frames=tuple(frames)))
    found = Study(
        root=root,
        camera=Camera(),
        series=tuple(series),
        width=WIDTH,
        height=HEIGHT,
        cfa="GRBG",
        bit_depth=10,
        black_level=None,
        white_level=None,
    )
    return found, mosaics


def direct(series: Series, mosaics: Mosaics) -> SeriesStatistics:
    """Statistics of mosaics in memory, without threads or files; frames without a mosaic are left out."""
    moments = Moments(
        Layout(height=HEIGHT, width=WIDTH, cfa="GRBG", tile=TILE), every_histogram=series.kind is not Kind.FLAT
    )
    names = sorted(frame.name for frame in series.frames if frame.name in mosaics)
    bursts = None
    for part in (names[:5], names[5:]):
        if part:
            moments.add(part, stack_of([mosaics[name] for name in part]))
        if part == names[:5] and (len(names) <= 5 or series.kind is not Kind.FLAT):
            bursts = burst_sums(moments)
    return finalize(moments, bursts=bursts)


def assert_same(mine: object, its: object) -> None:
    """Compare nested statistics bit by bit."""
    if dataclasses.is_dataclass(mine):
        assert type(mine) is type(its)
        for field in dataclasses.fields(mine):
            assert_same(getattr(mine, field.name), getattr(its, field.name))
    elif isinstance(mine, np.ndarray):
        np.testing.assert_array_equal(mine, its)
    elif isinstance(mine, tuple):
        assert isinstance(its, tuple)
        assert len(mine) == len(its)
        for one, other in zip(mine, its, strict=True):
            assert_same(one, other)
    else:
        assert mine == its or (mine != mine and its != its)  # noqa: PLR0124 - NaN is NaN here


def assert_same_reduction(mine: Reduction, its: Reduction) -> None:
    assert list(mine.statistics) == list(its.statistics)
    for one, other in zip(mine.statistics.values(), its.statistics.values(), strict=True):
        assert_same(one, other)
    assert list(mine.hashes.items()) == list(its.hashes.items())
    assert mine.excluded == its.excluded
    assert mine.findings == its.findings
