"""Times side by side, in one run, so that a busy or a slow machine tells the same story."""

import statistics
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass

REPEATS = 5


@dataclass(frozen=True, slots=True, kw_only=True)
class Comparison:
    """One line of the table.

    Parameters
    ----------
    name
        What is compared with what.
    value
        A ratio, or an amount with its ``unit``.
    target
        What it must not exceed, or must reach where ``at_least``.
    detail
        The times behind it.

    """

    name: str
    value: float | None
    target: float
    unit: str = "x"
    at_least: bool = False
    detail: str = ""

    @property
    def verdict(self) -> str:
        """Return whether the target is met, or that it was skipped."""
        if self.value is None:
            return "skipped"
        met = self.value >= self.target if self.at_least else self.value <= self.target
        return "met" if met else "MISSED"


def cpu_seconds(subject: Callable[[], object]) -> float:
    """Return the processor time of one run, of all threads [s]."""
    started = time.process_time()
    subject()
    return time.process_time() - started


def medians(subjects: Mapping[str, Callable[[], object]], *, repeats: int = REPEATS) -> dict[str, float]:
    """Return the median time of each subject [s]; they take turns, and the first turn does not count."""
    times: dict[str, list[float]] = {name: [] for name in subjects}
    for _ in range(repeats + 1):
        for name, subject in subjects.items():
            started = time.perf_counter()
            subject()
            times[name].append(time.perf_counter() - started)
    return {name: statistics.median(taken[1:]) for name, taken in times.items()}
