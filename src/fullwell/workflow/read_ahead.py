"""Groups of series are read in the background while somebody works on what came of the last one.

Reading keeps the processors busy with compiled loops, which need no interpreter; what is measured of a group needs
little else. Side by side they fill the machine, and no more than a few groups' worth of pixels are ever in memory.
"""

from collections.abc import Callable, Generator, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from threading import Condition

from fullwell.frames.series import SeriesKey
from fullwell.workflow.executor import POLL_S, Progress


class _AbandonedError(Exception):
    """Nobody waits for what is read any more."""


class ReadAhead:
    """Who waits for whom: the reader for room, the one who works for groups.

    Parameters
    ----------
    groups
        Keys of the series of each group, in the order they are read.
    ahead
        How many groups are kept besides the one that is worked on.

    """

    def __init__(self, groups: Sequence[Sequence[SeriesKey]], *, ahead: int) -> None:
        self._place = {key: place for place, group in enumerate(groups) for key in group}
        self._left = [len(group) for group in groups]
        self._wanted = 0
        self._begun = False
        self._ahead = ahead
        self._stopped = False
        self._changed = Condition()

    def admit(self, key: SeriesKey, roomy: Callable[[], bool]) -> None:
        """Wait until there is room for what a series came to.

        Parameters
        ----------
        key
            Of the series.
        roomy
            Whether there is memory for a group that is not waited for yet.

        """
        with self._changed:
            while not self._stopped and not self._admitted(self._place[key], roomy):
                self._changed.wait(POLL_S)
        self.check()

    def _admitted(self, place: int, roomy: Callable[[], bool]) -> bool:
        return place <= self._wanted or (place <= self._wanted + self._ahead and roomy())

    def arrived(self, key: SeriesKey) -> None:
        """Say that what a series came to is there."""
        with self._changed:
            self._left[self._place[key]] -= 1
            self._begun = True
            self._changed.notify_all()

    def check(self) -> None:
        """Raise where all shall stop."""
        if self._stopped:
            raise _AbandonedError

    def groups(self, read: Callable[[], None], *, meanwhile: Callable[[], None] | None = None) -> Generator[int]:
        """Call ``read`` in the background and yield the place of each group once it is there.

        What ``read`` raises is raised here. A caller that gives up closes the generator, which stops the reading.

        Parameters
        ----------
        read
            Says of each series when it has arrived.
        meanwhile
            Called once the first series has arrived, while others are read.

        """
        with ThreadPoolExecutor(1, thread_name_prefix="fullwell-reader") as pool:
            try:
                reading = pool.submit(read)
                if meanwhile is not None:
                    self._wait_to_begin(reading)
                    meanwhile()
                for place in range(len(self._left)):
                    self._wait(place, reading)
                    yield place
                    with self._changed:
                        self._wanted = place + 1
                        self._changed.notify_all()
                reading.result()
            finally:
                self._stopped = True

    def _wait_to_begin(self, reading: "Future[None]") -> None:
        with self._changed:
            while not self._begun and not reading.done():
                self._changed.wait(POLL_S)

    def _wait(self, place: int, reading: "Future[None]") -> None:
        with self._changed:
            while self._left[place]:
                if reading.done():
                    reading.result()
                    raise RuntimeError("a series was not read")
                self._changed.wait(POLL_S)


class Stoppable:
    """Progress that is told all in all, and that stops the reading when asked to.

    Parameters
    ----------
    progress
        Who wants to know, if anybody.
    ahead
        Who knows whether to stop.

    """

    def __init__(self, progress: Progress | None, ahead: ReadAhead) -> None:
        self._progress = progress
        self._ahead = ahead

    def start(self, total_frames: int) -> None:
        """Hear how many frames there are."""
        if self._progress is not None:
            self._progress.start(total_frames)

    def advance(self, frames: int = 1) -> None:
        """Hear that some frames are done."""
        self._ahead.check()
        if self._progress is not None:
            self._progress.advance(frames)
