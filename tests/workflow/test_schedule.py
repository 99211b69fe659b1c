"""Which frames a thread takes."""

import pytest

from fullwell.frames.series import Kind, Series
from fullwell.workflow.schedule import OpenSeries, Schedule


@pytest.mark.parametrize(("frames", "taken"), [(22, (6, 3, 2)), (40, (10, 5, 3, 2)), (6, (3,)), (5, (3,))])
def test_few_frames_are_not_divided_further(frames: int, taken: tuple[int, ...]) -> None:
    series = Series(kind=Kind.FLAT, iso=100.0, exposure_s=0.01, frames=())
    opened = OpenSeries(series)
    opened.rest.extend(((None, None),) * (frames // 2) + ((None,),) * (frames % 2))  # type: ignore[arg-type]
    schedule = Schedule([series], most_open=1, pairs=False, progress=None)
    found: list[int] = []
    while opened.rest:
        found.append(len(list(schedule.next_groups(opened, workers=2))))
    assert tuple(found) == taken
