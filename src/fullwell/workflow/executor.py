"""Threads that work side by side until all is done, one fails, or the user interrupts."""

import gc
import signal
import sys
import threading
from collections.abc import Callable, Generator, Iterable
from concurrent.futures import FIRST_EXCEPTION, ThreadPoolExecutor, wait
from contextlib import contextmanager
from threading import Event
from typing import Final, Protocol, TypeVar

from threadpoolctl import threadpool_limits

_Item = TypeVar("_Item")
_Found = TypeVar("_Found")

_TURN_S: Final = 0.0005
"""How long a thread keeps the interpreter while others wait for it [s]."""
_NEW_OBJECTS: Final = 100_000
"""Between two looks at what can be let go."""
POLL_S: Final = 0.1
"""How soon a waiting thread notices that it should stop [s]."""


class Progress(Protocol):
    """Who wants to know how far the work is; called from several threads."""

    def start(self, total_frames: int) -> None:
        """Hear how many frames there are."""
        ...

    def advance(self, frames: int = 1) -> None:
        """Hear that some frames are done."""
        ...


def run_threads(work: Callable[[int, Event], None], *, workers: int) -> None:
    """Run ``work(index, stop)`` on threads and return when all have returned.

    Parameters
    ----------
    work
        Called once per thread; it should return soon after ``stop`` is set.
    workers
        Number of threads, at least one.

    Raises
    ------
    BaseException
        What a thread raised first, or KeyboardInterrupt, after the others have stopped.

    """
    stop = Event()
    with ThreadPoolExecutor(max_workers=max(1, workers), thread_name_prefix="fullwell") as pool:
        try:
            futures = [pool.submit(work, index, stop) for index in range(max(1, workers))]
            pending = set(futures)
            while pending:
                done, pending = wait(pending, timeout=POLL_S, return_when=FIRST_EXCEPTION)
                if any(future.exception() for future in done):
                    stop.set()
        finally:
            stop.set()
    for future in futures:
        future.result()


def in_threads(work: Callable[[_Item], _Found], items: Iterable[_Item], *, workers: int) -> tuple[_Found, ...]:
    """Return ``work(item)`` of every item, in their order, computed side by side."""
    with one_algebra_thread(), ThreadPoolExecutor(max(1, workers)) as pool:
        return tuple(pool.map(work, items))


@contextmanager
def one_algebra_thread() -> Generator[None]:
    """Keep linear algebra to one thread: on many small matrices its own threads cost more than they bring."""
    with threadpool_limits(1, user_api="blas"):
        yield


@contextmanager
def old_objects_aside() -> Generator[None]:
    """Let the collector pass over all objects that are there, and look rarely at new ones.

    Compilers and libraries hold very many, for good; what is made of frames is let go without it.
    """
    before = gc.get_threshold()
    gc.freeze()
    gc.set_threshold(_NEW_OBJECTS)
    try:
        yield
    finally:
        gc.set_threshold(*before)
        gc.unfreeze()


@contextmanager
def short_turns() -> Generator[None]:
    """Let threads take turns at the interpreter ten times as often as it would.

    A thread that decodes comes back to it for every few lines of a frame, and would wait 5 ms for one that measures.
    """
    before = sys.getswitchinterval()
    sys.setswitchinterval(_TURN_S)
    try:
        yield
    finally:
        sys.setswitchinterval(before)


@contextmanager
def interruptions_later() -> Generator[None]:
    """Let an interruption wait for the end of the block; processes that begin in it, and theirs, never hear of one.

    A terminal sends it to every process of a command. Those that have only begun would answer with a traceback.
    """
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    came: list[int] = []
    former = {one: signal.getsignal(one) for one in (signal.SIGINT, signal.SIGTERM)}
    heard = {number: handler for number, handler in former.items() if callable(handler)}
    for number in heard:
        signal.signal(number, lambda number, _frame: came.append(number))
    blocks = hasattr(signal, "pthread_sigmask")
    if blocks:
        from multiprocessing.resource_tracker import ensure_running  # noqa: PLC0415 - loads when used

        ensure_running()  # before, for it lets them through when it begins
    blocked = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT}) if blocks else set[int]()
    try:
        yield
    finally:
        if blocks:
            signal.pthread_sigmask(signal.SIG_SETMASK, blocked)
        for number, handler in heard.items():
            signal.signal(number, handler)
        for number in came[:1]:
            signal.raise_signal(number)
