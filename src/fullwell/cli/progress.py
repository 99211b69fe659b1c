"""Progress of long work on stderr: a bar on a terminal, now and then a line elsewhere, nothing when quiet."""

import sys
import threading
import time
from collections.abc import Generator
from contextlib import contextmanager
from typing import Final

from fullwell.workflow.executor import Progress

_SECONDS_BETWEEN_LINES: Final = 5.0


class LineProgress:
    """A plain line every few seconds, for logs."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._total = self._done = 0
        self._began = self._said = 0.0

    def start(self, total_frames: int) -> None:
        """Begin counting."""
        self._total, self._done = total_frames, 0
        self._began = self._said = time.monotonic()

    def advance(self, frames: int = 1) -> None:
        """Count, and say so when some seconds have passed."""
        with self._lock:
            self._done += frames
            now = time.monotonic()
            if now - self._said < _SECONDS_BETWEEN_LINES:
                return
            self._said = now
            rate = self._done / (now - self._began)
            left_s = max(self._total - self._done, 0) / rate
            sys.stderr.write(f"{self._done} of {self._total} frames, {rate:.1f} frames/s, {left_s:.0f} s left\n")
            sys.stderr.flush()


@contextmanager
def shown_progress(*, quiet: bool) -> Generator[Progress | None, None, None]:
    """Provide what tells of progress: None when quiet."""
    if quiet:
        yield None
        return
    from fullwell.cli.bars import bars_on_terminal  # noqa: PLC0415 - Rich loads only where something is shown

    with bars_on_terminal() as bars:
        yield bars or LineProgress()
