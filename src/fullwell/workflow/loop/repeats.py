"""Many turns of the loop: cameras of one make, each with a sensor and noise of its own, side by side in processes."""

import multiprocessing
import shutil
import signal
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path

from fullwell.simulate.config import SimulationConfig
from fullwell.workflow.executor import interruptions_later, one_algebra_thread
from fullwell.workflow.loop.camera import options_for, turn
from fullwell.workflow.loop.tally import Share, shares_of


@dataclass(frozen=True, slots=True, kw_only=True)
class Repeat:
    """One further camera.

    Parameters
    ----------
    config
        With a seed of its own.
    folder
        Where its frames go.
    keep
        Whether they stay.

    """

    config: SimulationConfig
    folder: Path
    keep: bool


def repeats_of(config: SimulationConfig, count: int, *, folder: Path, keep: bool) -> tuple[Repeat, ...]:
    """Return further cameras of the same make, numbered from 2: the first is the config's own."""
    return tuple(
        Repeat(config=config.with_seed(config.seed + number - 1), folder=folder / f"{number:04d}", keep=keep)
        for number in range(2, count + 1)
    )


def run_repeats(repeats: tuple[Repeat, ...], *, workers: int, done: Callable[[], None]) -> Iterator[list[Share]]:
    """Yield what every camera came to, in their order whatever the number of workers.

    Parameters
    ----------
    repeats
        The cameras.
    workers
        Processes. With one, everything happens in this one.
    done
        Called after every camera.

    """
    if workers < 2 or len(repeats) < 2:
        for repeat in repeats:
            found = run_repeat(repeat)
            done()
            yield found
        return
    context = multiprocessing.get_context("spawn")
    with ExitStack() as held:
        with interruptions_later():
            pool = held.enter_context(
                context.Pool(min(workers, len(repeats)), initializer=_leave_interrupts_to_the_parent)
            )
        for found in pool.imap(run_repeat, repeats):
            done()
            yield found


def run_repeat(repeat: Repeat) -> list[Share]:
    """Simulate and measure one camera on one thread."""
    with one_algebra_thread():
        found = turn(repeat.config, repeat.folder, options=options_for(repeat.config, workers=1), progress=None)
    if not repeat.keep:
        shutil.rmtree(repeat.folder, ignore_errors=True)
    return shares_of(found.compared)


def _leave_interrupts_to_the_parent() -> None:
    signal.signal(signal.SIGINT, signal.SIG_IGN)
