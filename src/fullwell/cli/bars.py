"""Progress bars: frames done, frames per second, time left."""

from collections.abc import Generator
from contextlib import contextmanager

from rich.console import Console
from rich.progress import (
    BarColumn,
    MofNCompleteColumn,
    Progress,
    ProgressColumn,
    Task,
    TaskID,
    TextColumn,
    TimeRemainingColumn,
)
from rich.text import Text


class _RateColumn(ProgressColumn):
    """Frames per second."""

    def render(self, task: Task) -> Text:
        """Return the speed of a task."""
        speed = task.finished_speed or task.speed
        return Text("" if speed is None else f"{speed:.1f} frames/s")


class BarProgress:
    """A bar for each piece of work; a new one replaces the last."""

    def __init__(self, bars: Progress) -> None:
        self._bars = bars
        self._task: TaskID | None = None

    def start(self, total_frames: int) -> None:
        """Begin a new bar."""
        if self._task is not None:
            self._bars.remove_task(self._task)
        self._task = self._bars.add_task("frames", total=total_frames)

    def advance(self, frames: int = 1) -> None:
        """Move the bar."""
        if self._task is not None:
            self._bars.advance(self._task, frames)


@contextmanager
def bars_on_terminal() -> Generator[BarProgress | None, None, None]:
    """Provide bars on stderr; None where stderr is no terminal and nothing forces it to be taken for one."""
    console = Console(stderr=True)
    if not console.is_terminal:
        yield None
        return
    columns = (
        BarColumn(),
        MofNCompleteColumn(),
        TextColumn("frames"),
        _RateColumn(),
        TimeRemainingColumn(compact=True),
        TextColumn("left"),
    )
    with Progress(*columns, console=console, transient=True) as bars:
        yield BarProgress(bars)
