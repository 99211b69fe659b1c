"""A second look at a few frames, for the published study's read noise per repeat and std-against-exposure line.

Everything else in the study's tables follows from burst sums; these two need single frames: the first five of the
read-noise burst of each ISO, and the flats of the lowest ISO once the map is known. A frame that can no longer be read
is left out and named.
"""

from collections import deque
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from threading import Event
from typing import Final

import numpy as np
from numpy.typing import NDArray

from fullwell.errors import RawFileError, UnreadableFileError
from fullwell.findings import Finding, Severity, listed
from fullwell.fit.legacy.read_noise import ReadNoiseRepeats, read_noise_repeats
from fullwell.fit.legacy.shading_map import LegacyMap
from fullwell.fit.legacy.std_line import StdLine, fit_std_line
from fullwell.frames.series import Exclusion, Frame
from fullwell.raw.open import decode, read_bytes
from fullwell.statistics.burst import LEGACY_FRAMES
from fullwell.statistics.single_frames import corrected_std, frame_products
from fullwell.workflow.executor import Progress, run_threads
from fullwell.workflow.measure.bursts import Burst, IsoBursts
from fullwell.workflow.measure.read_noise import choose_burst

CODE: Final = "second-look-failed"
MOST_BYTES: Final = 600_000_000
"""Mosaics that all threads together hold at once."""


@dataclass(frozen=True, slots=True, kw_only=True)
class SecondLook:
    """What single frames say.

    Parameters
    ----------
    read_noise
        Per ISO that has an unlit burst of two frames or more.
    std_line
        None without flats of two exposures at the lowest ISO.
    findings
        Frames that could be read the first time and now could not.

    """

    read_noise: tuple[ReadNoiseRepeats, ...] = ()
    std_line: StdLine | None = None
    findings: tuple[Finding, ...] = ()


def base_group(groups: Sequence[IsoBursts]) -> IsoBursts | None:
    """Return the bursts of the lowest ISO that has flats: the first of them makes the study's one map."""
    lit = [group for group in groups if group.flats]
    return min(lit, key=lambda group: (group.iso is None, group.iso or 0.0), default=None)


def used_frames(burst: Burst) -> tuple[Frame, ...]:
    """Return the frames of a burst that were not left out, by name."""
    names = frozenset(burst.statistics.frames)
    return tuple(sorted((one for one in burst.series.frames if one.name in names), key=lambda frame: frame.name))


def _first_frames(burst: Burst) -> tuple[Frame, ...]:
    return used_frames(burst)[:LEGACY_FRAMES]


def _known(burst: Burst) -> bool:
    """Whether the first frames were looked at together when they were read."""
    first = burst.first
    return (
        first is not None and bool(first.products) and first.frames == tuple(one.name for one in _first_frames(burst))
    )


def frame_exposure_s(burst: Burst, frame: Frame) -> float:
    """Return a frame's own exposure, its burst's where it has none [s]."""
    return burst.exposure_s if frame.header.exposure_s is None else frame.header.exposure_s


def look_again(
    groups: Sequence[IsoBursts],
    *,
    base: LegacyMap | None,
    workers: int,
    black_dn: Sequence[float] | None = None,
    progress: Progress | None = None,
) -> SecondLook:
    """Read what the study's per-frame figures need, once more.

    Parameters
    ----------
    groups
        Every burst, by ISO.
    base
        The study's map of the whole mosaic; without it no frame is corrected.
    workers
        Threads; the outcome does not depend on their number.
    black_dn
        As in `fit_legacy_map`: None leaves the pedestal in, as published [DN].
    progress
        Told of every frame.

    """
    unlit = [(group.iso, burst) for group in groups if (burst := choose_burst(group))]
    lowest = base_group(groups)
    flats = (
        [] if base is None or lowest is None else [(one, frame) for one in lowest.flats for frame in used_frames(one)]
    )
    look = _Look(progress)
    repeats: list[ReadNoiseRepeats | None] = [None] * len(unlit)
    spreads: list[float | None] = [None] * len(flats)
    shading = None if base is None or not flats else base.region(top=0, left=0, height=base.height, width=base.width)

    def read_noise(index: int) -> None:
        repeats[index] = look.repeats(*unlit[index])

    def spread(index: int) -> None:
        if shading is not None:
            spreads[index] = look.spread(flats[index][1], shading, black_dn)

    tasks = deque[tuple[Callable[[int], None], int]]()
    tasks.extend((read_noise, index) for index in range(len(unlit)))
    tasks.extend((spread, index) for index in range(len(flats)))
    anew = [frame for _, burst in unlit if not _known(burst) for frame in _first_frames(burst)]
    every = [*anew, *(frame for _, frame in flats)]
    if progress is not None and every:
        progress.start(len(every))
    run_threads(_taker(tasks), workers=_workers(workers, every, len(tasks)))
    known = [
        (frame_exposure_s(burst, frame), std)
        for (burst, frame), std in zip(flats, spreads, strict=True)
        if std is not None
    ]
    return SecondLook(
        read_noise=tuple(one for one in repeats if one is not None),
        std_line=_line(known),
        findings=look.findings(),
    )


def _line(known: Sequence[tuple[float, float]]) -> StdLine | None:
    if len({exposure_s for exposure_s, _ in known}) < 2:
        return None
    return fit_std_line([exposure_s for exposure_s, _ in known], [std for _, std in known])


def _taker(tasks: deque[tuple[Callable[[int], None], int]]) -> Callable[[int, Event], None]:
    def work(_: int, stop: Event) -> None:
        while not stop.is_set():
            try:
                task, index = tasks.popleft()
            except IndexError:
                return
            task(index)

    return work


def _workers(workers: int, frames: Sequence[Frame], tasks: int) -> int:
    """Return how many threads there is memory for, each with a burst of mosaics."""
    pixels = max((frame.header.height * frame.header.width for frame in frames), default=1)
    return max(1, min(workers, tasks, MOST_BYTES // (2 * LEGACY_FRAMES * pixels)))


class _Look:
    """What the threads of one second look share."""

    def __init__(self, progress: Progress | None) -> None:
        self._progress = progress
        self._failed: dict[str, str] = {}

    def repeats(self, iso: float | None, burst: Burst) -> ReadNoiseRepeats | None:
        """Return both flows of each of the first frames that can be read, None where fewer than two can."""
        frames, planes = _first_frames(burst), burst.statistics.planes
        if burst.first is not None and _known(burst):
            means = [sum(plane.n * plane.frame_means[at] for plane in planes) for at in range(len(frames))]
            sums = [round(total) for total in means]
            n = sum(plane.n for plane in planes)
            return read_noise_repeats(burst.first.frames, sums, burst.first.products, iso=iso, n=n)
        mosaics = [(frame.name, mosaic) for frame in frames if (mosaic := self._mosaic(frame)) is not None]
        if len(mosaics) < 2:
            return None
        names, codes = [name for name, _ in mosaics], [mosaic for _, mosaic in mosaics]
        sums = [int(mosaic.sum(dtype=np.uint64)) for mosaic in codes]
        return read_noise_repeats(names, sums, frame_products(codes), iso=iso, n=codes[0].size)

    def spread(self, frame: Frame, shading: NDArray[np.float64], black_dn: Sequence[float] | None) -> float | None:
        """Return the spread of a corrected flat, None where it cannot be read [DN]."""
        mosaic = self._mosaic(frame)
        return None if mosaic is None else corrected_std(mosaic, shading, black_dn=black_dn)

    def findings(self) -> tuple[Finding, ...]:
        """Return what was lost."""
        if not self._failed:
            return ()
        names = sorted(self._failed)
        message = (
            f"When they were read a second time, {listed([f'{name} ({self._failed[name]})' for name in names])} could "
            "not be used: the published study's tables of single frames are without them. Were files changed during "
            "the run? Run it again."
        )
        return (Finding(code=CODE, severity=Severity.ERROR, message=message, files=tuple(names)),)

    def _mosaic(self, frame: Frame) -> NDArray[np.uint16] | None:
        try:
            return self._decoded(frame)
        except (RawFileError, OSError) as error:
            self._failed[frame.name] = Exclusion.of(frame.name, error).reason.rstrip(".")
        finally:
            if self._progress is not None:
                self._progress.advance()
        return None

    @staticmethod
    def _decoded(frame: Frame) -> NDArray[np.uint16]:
        mosaic = decode(frame.header, read_bytes(frame.header))
        if mosaic.shape != (frame.header.height, frame.header.width):
            raise UnreadableFileError("file-damaged", "the file changed its size")
        return mosaic
