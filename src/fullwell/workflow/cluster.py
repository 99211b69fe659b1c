"""Dask's only door: tasks run in processes on this machine or many, which read the files themselves.

Only a few tasks that read are under way at any time, so that neither the scheduler nor this process ever holds a
study's worth of them. A process that is lost costs what it was doing and the sums it held, of series that are not
finished: Dask makes these again.
"""

import logging
from collections import deque
from collections.abc import Callable, Generator, Iterable, Iterator, Sequence
from contextlib import ExitStack, contextmanager
from types import TracebackType
from typing import TYPE_CHECKING, Any, Final, Generic, Self, TypeVar, cast

from fullwell.errors import UsageError
from fullwell.frames.series import Series
from fullwell.workflow.cache import recipe
from fullwell.workflow.executor import Progress, interruptions_later
from fullwell.workflow.merge_tree import MergeTree, Task
from fullwell.workflow.outcome import SeriesOutcome
from fullwell.workflow.plan import Done, Plan

if TYPE_CHECKING:
    from distributed import Client

LOCAL: Final = "local"
_PER_THREAD: Final = 2
"""Tasks under way for each thread of the cluster: one that is worked on, one that waits."""
_LEAST: Final = 4
_CONNECT_S: Final = 30.0
_DEAF: Final = "import signal; signal.signal(signal.SIGINT, signal.SIG_IGN)"
"""Run by processes of this machine: an interruption, which a terminal sends to all of them, is ours to handle."""
_SOON: Final = 10
"""Priority of merging over reading: it frees memory."""

_Item = TypeVar("_Item")
_Found = TypeVar("_Found")
_Mark = TypeVar("_Mark")


class DaskCluster:
    """A Dask cluster whose processes see the files of a study.

    Parameters
    ----------
    client
        Connected to it.

    """

    def __init__(self, client: "Client") -> None:
        self._client = client
        threads = cast("dict[str, int]", client.nthreads())
        self.most_under_way = max(_LEAST, _PER_THREAD * sum(threads.values()))

    def reduce(self, series: Sequence[Series], *, plan: Plan, done: Done, progress: Progress | None) -> None:
        """Reduce some series; see `threads.reduce_in_threads`.

        Raises
        ------
        UsageError
            The cluster gave up.

        """
        tree = MergeTree(series, plan.layout, pairs=plan.pairs)
        with _Flight[Task](self._client) as flight:
            while True:
                while len(flight) < self.most_under_way and (part := tree.next_part()) is not None:
                    flight.submit(part.work, part.arguments, mark=part)
                if not len(flight):
                    return
                task, future = flight.landed()
                if progress is not None:
                    progress.advance(task.frames)
                if task.last:
                    done(task.series, cast("SeriesOutcome", future.result()))
                if (then := tree.following(task, future)) is not None:
                    flight.submit(then.work, then.arguments, mark=then, priority=_SOON)

    def each(self, work: Callable[[_Item], _Found], items: Iterable[_Item]) -> Iterator[tuple[_Item, _Found]]:
        """Yield every item with what ``work`` makes of it, as they are done.

        Raises
        ------
        UsageError
            The cluster gave up.

        """
        waiting = deque(items)
        with _Flight[_Item](self._client) as flight:
            while waiting or len(flight):
                while waiting and len(flight) < self.most_under_way:
                    item = waiting.popleft()
                    flight.submit(work, (item,), mark=item)
                item, future = flight.landed()
                yield item, cast("_Found", future.result())


class _Flight(Generic[_Mark]):
    """Tasks that are under way, each with the caller's mark; what is still there at the end is called off."""

    def __init__(self, client: "Client") -> None:
        from distributed import as_completed  # noqa: PLC0415 - loads when used

        self._client = client
        self._under_way: dict[Any, _Mark] = {}
        self._landed = as_completed()

    def __enter__(self) -> Self:
        """Begin."""
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Call off what is under way."""
        self._client.cancel(list(self._under_way))
        self._under_way.clear()

    def __len__(self) -> int:
        """Return how many tasks are under way."""
        return len(self._under_way)

    def submit(
        self, work: Callable[..., object], arguments: tuple[object, ...], *, mark: _Mark, priority: int = 0
    ) -> None:
        """Send a task off."""
        future = self._client.submit(work, *arguments, pure=False, priority=priority)
        self._under_way[future] = mark
        self._landed.add(future)

    def landed(self) -> tuple[_Mark, Any]:
        """Return the mark and the future of a task that is done; wait for one."""
        from distributed import KilledWorker  # noqa: PLC0415 - as above

        future: Any = next(self._landed)
        mark = self._under_way.pop(future)
        if future.status == "error":
            error = future.exception()
            if isinstance(error, KilledWorker):
                raise UsageError(
                    "the Dask cluster lost several processes over the same frames, so they need more memory than a "
                    "process has, or crash it; give its processes more memory, or run without --dask"
                ) from error
            raise error
        return mark, future


@contextmanager
def connected(address: str | None, *, workers: int) -> Generator[DaskCluster | None]:
    """Provide a cluster.

    Parameters
    ----------
    address
        Of a scheduler, such as tcp://host:8786, or ``local`` for processes of this machine; None provides none.
    workers
        How many of these.

    Raises
    ------
    UsageError
        Dask is not installed, there is no such cluster, or its processes run other code.

    """
    if address is None:
        yield None
        return
    try:
        from distributed import Client, LocalCluster  # noqa: PLC0415 - loads when used
    except ImportError as error:
        raise UsageError("--dask needs Dask: install it with `pip install 'fullwell[dask]'`") from error
    if address == LOCAL:
        with ExitStack() as held:
            with interruptions_later():
                cluster = LocalCluster(
                    n_workers=workers,
                    threads_per_worker=1,
                    dashboard_address="127.0.0.1:0",  # any free port: clusters may stand side by side
                    silence_logs=logging.ERROR,
                    preload=[_DEAF],
                )
                client = held.enter_context(Client(held.enter_context(cluster)))
            yield DaskCluster(client)
        return
    try:
        client = Client(address, timeout=_CONNECT_S)
    except (OSError, ValueError) as error:
        raise UsageError(f"--dask {address}: no scheduler answers there ({error})") from error
    with client:
        _check(client, address)
        yield DaskCluster(client)


def _check(client: "Client", address: str) -> None:
    """See that there are processes, and that they would return the same bits."""
    try:
        client.wait_for_workers(1, timeout=_CONNECT_S)
    except TimeoutError as error:
        raise UsageError(f"--dask {address}: the scheduler has no worker processes; start some") from error
    its = cast("dict[str, bytes]", client.run(recipe.code))
    others = sorted(name for name, code in its.items() if code != recipe.code())
    if others:
        raise UsageError(
            f"--dask {address}: {', '.join(others)} run another version of Fullwell or of its libraries, which may not "
            "return the same bits; install the same everywhere"
        )
