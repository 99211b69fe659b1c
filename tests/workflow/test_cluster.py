"""A cluster of processes says what one thread says, also when one of them is killed."""

import dataclasses
import itertools
import logging
import os
import signal
from collections.abc import Generator, Sequence

import pytest
from distributed import Client, LocalCluster, SchedulerPlugin
from mixed_study import HEIGHT, TILE, WIDTH, assert_same_reduction, mixed_study

from fullwell.errors import UsageError
from fullwell.frames.series import Frame, Kind, Study
from fullwell.statistics.moments import Layout
from fullwell.workflow import cluster as door
from fullwell.workflow import merge_tree
from fullwell.workflow.cache import recipe
from fullwell.workflow.cluster import DaskCluster, connected
from fullwell.workflow.merge_tree import MergeTree, Part, Task, parts_of
from fullwell.workflow.reduce import Reduction, reduce_study

KEPT = (Kind.FLAT, Kind.DARK, Kind.BIAS)


@pytest.fixture(scope="module")
def local() -> Generator[LocalCluster]:
    """Two processes of one thread."""
    with LocalCluster(
        n_workers=2, threads_per_worker=1, dashboard_address=":0", silence_logs=logging.CRITICAL
    ) as cluster:
        yield cluster


@pytest.fixture
def client(local: LocalCluster) -> Generator[Client]:
    with Client(local) as client:
        yield client


@pytest.fixture(scope="module")
def study(tmp_path_factory: pytest.TempPathFactory) -> Study:
    """Series of 7 to 75 frames: the same files many times under names of their own, some of them damaged."""
    root = tmp_path_factory.mktemp("cluster")
    small, _ = mixed_study(root)
    longer = [
        dataclasses.replace(series, frames=tuple(copies(series.frames, times)))
        for series, times in zip(small.series[:3], (7, 9, 1), strict=True)
    ]
    (root / "dark-0.02-02.dng").write_bytes(b"")
    (root / "flat-0.02-01.dng").write_bytes(b"II*\0")
    return dataclasses.replace(small, series=(*longer, *small.series[3:]))


def copies(frames: Sequence[Frame], times: int) -> list[Frame]:
    return [dataclasses.replace(frame, name=f"{time}/{frame.name}") for time in range(times) for frame in frames]


@pytest.fixture(autouse=True)
def short_parts(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(merge_tree, "PART_FRAMES", 4)


@pytest.fixture(scope="module")
def single(study: Study) -> Reduction:
    return reduce_study(study, workers=1, tile=TILE, keep=KEPT, pairs=True)


def assert_equal(found: Reduction, single: Reduction) -> None:
    assert_same_reduction(found, single)
    assert list(found.sums) == list(single.sums)
    for one, other in zip(found.sums.values(), single.sums.values(), strict=True):
        assert one.tobytes() == other.tobytes()


def test_a_cluster_says_what_a_thread_says(study: Study, single: Reduction, client: Client) -> None:
    found = reduce_study(study, workers=1, tile=TILE, keep=KEPT, pairs=True, cluster=DaskCluster(client))
    assert_equal(found, single)
    assert len(single.excluded) == 8


class Ledger(SchedulerPlugin):
    """Which process did which task, in the order in which they were done."""

    def __init__(self) -> None:
        self.done: dict[str, list[str]] = {}

    def transition(self, key: str, start: str, finish: str, *_: object, worker: str = "", **__: object) -> None:
        if (start, finish) == ("processing", "memory"):
            self.done.setdefault(key, []).append(worker)


def test_a_killed_process_costs_its_own_tasks(
    study: Study, single: Reduction, local: LocalCluster, client: Client
) -> None:
    victim = next(iter(local.workers.values()))
    pid, address = victim.process.pid, victim.worker_address
    ledger = Ledger()
    local.scheduler.add_plugin(ledger, name="ledger")

    class Assassin:
        """Kills a process once half of the frames are in."""

        def start(self, total_frames: int) -> None:
            self.half, self.frames = total_frames / 2, 0

        def advance(self, frames: int = 1) -> None:
            before, self.frames = self.frames, self.frames + frames
            if before < self.half <= self.frames:
                os.kill(pid, signal.SIGKILL)

    found = reduce_study(
        study, workers=1, tile=TILE, keep=KEPT, pairs=True, cluster=DaskCluster(client), progress=Assassin()
    )
    local.scheduler.remove_plugin("ledger")
    assert_equal(found, single)
    assert victim.process.pid != pid
    again = [key for key, workers in ledger.done.items() if len(workers) > 1]
    under_way = 2 * len(parts_of(study.series[0], layout())) + DaskCluster(client).most_under_way
    assert len(again) <= under_way, "sums that the lost process held are made again, finished series are not"
    assert any(address in workers for workers in ledger.done.values())


def layout() -> Layout:
    return Layout(height=HEIGHT, width=WIDTH, cfa="GRBG", tile=TILE)


def test_few_parts_are_under_way_however_many_there_are(study: Study) -> None:
    class Slow:
        """A flight that lands nothing before it must."""

        most = 0

        def __init__(self, *_: object) -> None:
            self.under_way: list[Task] = []

        def __enter__(self):
            return self

        def __exit__(self, *_: object) -> None:
            pass

        def __len__(self) -> int:
            return len(self.under_way)

        def __class_getitem__(cls, _: object):
            return cls

        def submit(self, work, arguments, *, mark: Task, priority: int = 0) -> None:
            del work, arguments, priority
            self.under_way.append(mark)
            Slow.most = max(Slow.most, len(self.under_way))

        def landed(self):
            return self.under_way.pop(0), FakeFuture()

    class FakeFuture:
        def result(self) -> str:
            return "outcome"

    class FakeClient:
        def nthreads(self) -> dict[str, int]:
            return {"one": 1, "two": 2}

    outcomes: list[object] = []
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(door, "_Flight", Slow)
        fake = DaskCluster(FakeClient())
        plan = type("Plan", (), {"layout": layout(), "pairs": False})
        fake.reduce(study.series, plan=plan, done=lambda series, _: outcomes.append(series), progress=None)
    assert Slow.most == fake.most_under_way == 6
    assert sorted(one.key for one in outcomes) == sorted(one.key for one in study.series)


def test_the_tree_merges_every_part_once(study: Study) -> None:
    tree = MergeTree(study.series, layout())
    under_way: list[Task] = []
    while (task := tree.next_part()) is not None:
        under_way.append(task)
    held: dict[str, list[str]] = {}
    for number in itertools.count():
        if not under_way:
            break
        task, handle = under_way.pop(len(under_way) // 2), f"handle {number}"
        held[handle] = [frame.name for one in task.arguments if isinstance(one, Part) for frame in one.frames]
        held[handle] += [name for one in task.arguments if isinstance(one, str) for name in held.pop(one)]
        if task.last:
            assert sorted(held.pop(handle)) == sorted(frame.name for frame in task.series.frames)
        if (then := tree.following(task, handle)) is not None:
            under_way.append(then)
    assert not held


def test_processes_of_this_machine_leave_interruptions_to_the_one_that_started_them() -> None:
    with connected("local", workers=1) as cluster:
        assert cluster is not None
        assert list(cluster.each(signal.getsignal, [signal.SIGINT])) == [(signal.SIGINT, signal.SIG_IGN)]


def test_no_scheduler_is_a_sentence(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(door, "_CONNECT_S", 0.2)
    with pytest.raises(UsageError, match="no scheduler answers"), connected("tcp://127.0.0.1:9", workers=1):
        pass


def test_processes_of_other_code_are_refused(local: LocalCluster) -> None:
    address = local.scheduler_address
    with connected(address, workers=1) as found:
        assert found is not None

    def differ() -> None:
        recipe.code = lambda: b"other"

    with Client(local) as client:
        client.run(differ)
    with pytest.raises(UsageError, match="another version"), connected(address, workers=1):
        pass
