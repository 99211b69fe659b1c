"""Sums that are kept lie in memory while there is room, and in files beyond it."""

from pathlib import Path

import numpy as np
import pytest

from fullwell.workflow import scratch
from fullwell.workflow.scratch import KeptSums


def sums(value: int) -> np.ndarray:
    return np.full((2, 3), value, np.uint32)


def files(folder: Path) -> int:
    return len(list(folder.iterdir()))


@pytest.fixture
def kept(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> KeptSums:
    """Room for two of three."""
    monkeypatch.setattr(scratch, "MOST_KEPT_BYTES", 2 * sums(0).nbytes)
    return KeptSums(series=3, pixels=6, folder=tmp_path)


def test_what_is_forgotten_makes_room(kept: KeptSums, tmp_path: Path) -> None:
    first, _second = kept.keep(sums(1)), kept.keep(sums(2))
    kept.forget(first)
    third = kept.keep(sums(3))
    assert files(tmp_path) == 0
    fourth = kept.keep(sums(4))
    assert files(tmp_path) == 1
    assert ((third == 3) & (fourth == 4)).all()
    assert not third.flags.writeable
    assert not fourth.flags.writeable


def test_ahead_of_time_all_may_be_kept_where_there_are_files(
    kept: KeptSums, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(scratch, "MOST_KEPT_BYTES", 3 * sums(0).nbytes)
    in_memory = KeptSums(series=3, pixels=6)
    for where, roomy in ((kept, [True] * 3), (in_memory, [True, True, False])):
        found = [(where.keep(sums(value)), where.roomy()) for value in range(3)]
        assert [one for _, one in found] == roomy
    assert files(tmp_path) == 0
