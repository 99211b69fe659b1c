"""Hash, moments and maps against only reading, and against only decoding; and the memory they take."""

import subprocess
import sys
import threading
from collections.abc import Callable
from pathlib import Path

import imagecodecs

from benchmarks.studies import FRAMES, frames_of, write_study
from benchmarks.timing import Comparison, medians
from fullwell.frames.series import Frame, Kind, Study
from fullwell.raw.open import decode, read_bytes
from fullwell.raw.segments import Layout
from fullwell.workflow.cache.series_cache import SeriesCache
from fullwell.workflow.reduce import Reduction, reduce_study

WORKERS = 2
ONE_SERIES = ((Kind.FLAT, FRAMES),)
BURSTS = (*((Kind.FLAT, 5),) * (FRAMES // 5 - 6), *((Kind.DARK, 5),) * 5, (Kind.BIAS, 5))


def side_by_side(frames: list[Frame], work: Callable[[list[Frame]], None]) -> None:
    """Give each of two threads half of the frames."""
    threads = [threading.Thread(target=work, args=(frames[k::WORKERS],)) for k in range(WORKERS)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()


def read_only(frames: list[Frame]) -> None:
    """Read files into one buffer, one after the other."""
    buffer = memoryview(bytearray(max(frame.size for frame in frames)))
    for frame in frames:
        with frame.header.path.open("rb", buffering=0) as file:
            file.readinto(buffer[: frame.size])


def decode_only(frames: list[Frame]) -> None:
    """Read and decode files."""
    for frame in frames:
        decode(frame.header, read_bytes(frame.header))


def decode_with_imagecodecs(frames: list[Frame]) -> None:
    """Read files and decode their segments with the library that other readers of DNG stand on."""
    for frame in frames:
        data, layout = read_bytes(frame.header), frame.header.layout
        if not isinstance(layout, Layout):
            raise TypeError(f"{frame.header.path} holds no lossless JPEG")
        for offset, count in zip(layout.offsets, layout.counts, strict=True):
            imagecodecs.ljpeg_decode(bytes(data[offset : offset + count]))


def peak_gigabytes(study: Study) -> float | None:
    """Return the largest memory a process of its own takes to reduce a study [GB]; None where nothing tells."""
    if sys.platform == "win32":
        return None
    command = [sys.executable, "-m", "benchmarks.peak", str(study.root)]
    return int(subprocess.run(command, check=True, capture_output=True, text=True).stdout) / 1e9


def one_series(folder: Path) -> list[Comparison]:
    """Compare the reduction of one long series of uncompressed frames with reading them."""
    return _uncompressed(folder, name=f"{FRAMES} flats in one series", series=ONE_SERIES, target=3.0)


def many_bursts(folder: Path) -> list[Comparison]:
    """Compare the reduction of short series, each of which is paid for by its five frames, with reading them."""
    return _uncompressed(folder, name=f"{FRAMES} frames in {len(BURSTS)} bursts", series=BURSTS, target=6.0)


def _uncompressed(folder: Path, *, name: str, series: tuple[tuple[Kind, int], ...], target: float) -> list[Comparison]:
    study = write_study(folder / "study", series)
    frames = frames_of(study)
    times = medians(
        {
            "read": lambda: side_by_side(frames, read_only),
            "reduce": lambda: reduce_study(study, workers=WORKERS),
        }
    )
    return [
        Comparison(
            name=f"hash, moments and maps / reading: {name}",
            value=times["reduce"] / times["read"],
            target=target,
            detail=f"{times['reduce']:.2f} s against {times['read']:.2f} s",
        ),
        Comparison(name=f"peak memory: {name}", value=peak_gigabytes(study), target=1.0, unit="GB"),
    ]


def compressed(folder: Path) -> list[Comparison]:
    """Compare the reduction of lossless-JPEG frames with decoding them, here and with another decoder."""
    study = write_study(folder / "study", ((Kind.FLAT, FRAMES),), compression="lossless-jpeg")
    frames = frames_of(study)
    times = medians(
        {
            "our own": lambda: side_by_side(frames, decode_only),
            "imagecodecs": lambda: side_by_side(frames, decode_with_imagecodecs),
            "reduce": lambda: reduce_study(study, workers=WORKERS),
        }
    )
    return [
        Comparison(
            name=f"hash, moments and maps / decoding: {FRAMES} lossless-JPEG frames, {decoder}",
            value=times["reduce"] / times[decoder],
            target=1.15,
            detail=f"{times['reduce']:.2f} s against {times[decoder]:.2f} s",
        )
        for decoder in ("imagecodecs", "our own")
    ]


def memory(folder: Path) -> list[Comparison]:
    """Compare the memory that a series of many frames takes with that of a tenth of them."""
    counts = FRAMES // 3, 10 * FRAMES // 3
    few, many = (peak_gigabytes(write_study(folder / str(count), ((Kind.FLAT, count),))) for count in counts)
    name = f"peak memory: {counts[1]} frames / {counts[0]}"
    if few is None or many is None:
        return [Comparison(name=name, value=None, target=1.02, detail="nothing tells it here")]
    detail = f"{many * 1e3:.0f} MB against {few * 1e3:.0f} MB"
    return [Comparison(name=name, value=many / few, target=1.02, detail=detail)]


def resume(folder: Path) -> list[Comparison]:
    """Compare a run that finds every series in its cache with the run that read them."""
    study = write_study(folder / "study", BURSTS)
    kinds = tuple(Kind)

    def run(*, recheck: bool) -> Reduction:
        cache = SeriesCache(folder / "cache", recheck=recheck)
        return reduce_study(study, workers=WORKERS, keep=kinds, cache=cache, scratch=folder)

    fresh = reduce_study(study, workers=WORKERS, keep=kinds, scratch=folder)
    run(recheck=False)
    if repr(run(recheck=False).statistics) != repr(fresh.statistics):
        raise RuntimeError("the cache holds something else")
    times = medians(
        {
            "read": lambda: reduce_study(study, workers=WORKERS, keep=kinds, scratch=folder),
            "resume": lambda: run(recheck=False),
            "recheck": lambda: run(recheck=True),
        }
    )
    return [
        Comparison(
            name=f"resuming {how} / reading, {len(BURSTS)} uncompressed bursts",
            value=times[which] / times["read"],
            target=target,
            detail=f"{times[which]:.2f} s against {times['read']:.2f} s",
        )
        for which, how, target in (("resume", "by the file system's word", 0.5), ("recheck", "by content", 1.0))
    ]
