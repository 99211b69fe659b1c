"""Frames of a series that are in memory together, and what may be summed up over them."""

from collections.abc import Sequence
from typing import Protocol

from fullwell.kernels.stack import Band, Stack


class Batch:
    """Frames of one series that are added together.

    Parameters
    ----------
    names
        One per frame.
    stack
        The frames.
    pairs
        Places in the stack of frames that follow each other in the series, by name. A frame is in one pair at most,
        and a pair whose other frame is damaged is missing: the pairs of a series depend on its files alone, never on
        threads or memory.

    """

    def __init__(self, names: Sequence[str], stack: Stack, *, pairs: Sequence[tuple[int, int]] = ()) -> None:
        self.names = tuple(names)
        self.pairs = tuple(pairs)
        self.stack = stack

    def rows(self, strip: Band) -> Stack:  # noqa: ARG002 - a batch that reads its files as it goes must know which
        """Return the frames; only the rows of ``strip`` may be looked at, and only until the next call."""
        return self.stack


class Addition(Protocol):
    """A batch on its way into the sums of a series, in the hands of one thread."""

    def add(self, stack: Stack, band: Band) -> None:
        """Add a strip of every frame; called once for each (`Layout.strips`)."""
        ...

    def commit(self) -> None:
        """Hear that all rows have been added."""
        ...


class Accumulator(Protocol):
    """Exact sums over the frames of a series, which threads add to side by side and which merge in any order."""

    def begin(self, batch: Batch) -> Addition | None:
        """Return what takes the rows of a batch, None where nobody wants them."""
        ...
