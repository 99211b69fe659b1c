"""Hash, moments and maps against only reading, and against only decoding; and the memory they take."""

import subprocess
import sys
import threading
from collections.abc import Callable
from pathlib import Path

from benchmarks.studies import frames_of, write_study
from benchmarks.timing import Comparison, medians
from fullwell.frames.series import Frame, Kind, Study
from fullwell.raw.open import decode
from fullwell.workflow.reduce import reduce_study

WORKERS = 2
FRAMES = 150
ONE_SERIES = ((Kind.FLAT, FRAMES),)
BURSTS = (*((Kind.FLAT, 5),) * 24, *((Kind.DARK, 5),) * 5, (Kind.BIAS, 5))


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
        decode(frame.header, frame.header.path.read_bytes())


def peak_gigabytes(study: Study) -> float | None:
    """Return the largest memory a process of its own takes to reduce a study [GB]; None where nothing tells."""
    if sys.platform == "win32":
        return None
    command = [sys.executable, "-m", "benchmarks.peak", str(study.root)]
    return int(subprocess.run(command, check=True, capture_output=True, text=True).stdout) / 1e9


def uncompressed(folder: Path, *, name: str, series: tuple[tuple[Kind, int], ...], target: float) -> list[Comparison]:
    """Compare the reduction of uncompressed frames with reading them; every series is paid for by its frames."""
    study = write_study(folder, series)
    frames = frames_of(study)
    times = medians(
        {
            "read": lambda: side_by_side(frames, read_only),
            "reduce": lambda: reduce_study(study, workers=WORKERS),
        }
    )
    detail = f"{times['reduce']:.2f} s against {times['read']:.2f} s"
    return [
        Comparison(
            name=f"hash, moments and maps / reading: {name}",
            value=times["reduce"] / times["read"],
            target=target,
            detail=detail,
        ),
        Comparison(name=f"peak memory: {name}", value=peak_gigabytes(study), target=1.2, unit="GB"),
    ]


def compressed(folder: Path) -> list[Comparison]:
    """Compare the reduction of lossless-JPEG frames with decoding them."""
    study = write_study(folder, ((Kind.FLAT, FRAMES),), compression="lossless-jpeg")
    frames = frames_of(study)
    times = medians(
        {
            "decode": lambda: side_by_side(frames, decode_only),
            "reduce": lambda: reduce_study(study, workers=WORKERS),
        }
    )
    return [
        Comparison(
            name=f"hash, moments and maps / decoding: {FRAMES} lossless-JPEG frames",
            value=times["reduce"] / times["decode"],
            target=1.25,
            detail=f"{times['reduce']:.2f} s against {times['decode']:.2f} s",
        )
    ]
