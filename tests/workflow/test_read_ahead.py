"""What is read in the background comes group by group, keeps within its bounds, and stops when nobody waits."""

import threading
from contextlib import closing
from pathlib import Path

import numpy as np
import pytest

from fullwell.frames.selection import Selection
from fullwell.frames.series import Kind, Series
from fullwell.frames.study import load_study
from fullwell.kernels.pixel_maps import Rows
from fullwell.raw.write import write_dng
from fullwell.statistics.pixels import combine
from fullwell.workflow.read_ahead import ReadAhead, Stoppable
from fullwell.workflow.reduce import reduce_in_groups, reduce_study
from fullwell.workflow.scratch import narrowed
from fullwell.workflow.wanted import may_be_mapped

KEYS = [[("flat", float(group), float(one)) for one in range(3)] for group in range(4)]


@pytest.mark.parametrize("ahead", [0, 1, 2])
def test_no_more_groups_are_kept_than_there_is_room_for(ahead: int) -> None:
    waits = ReadAhead(KEYS, ahead=ahead)
    kept: list[float] = []
    done = 0

    def read() -> None:
        for group in KEYS:
            for key in group:
                waits.admit(key, lambda: True)
                kept.append(key[1])
                assert key[1] <= done + ahead
                waits.arrived(key)

    with closing(waits.groups(read)) as places:
        for place in places:
            assert kept.count(place) == len(KEYS[place])
            done = place + 1
    assert len(kept) == 12


def test_reading_stops_when_nobody_waits_any_more() -> None:
    waits = ReadAhead(KEYS, ahead=1)
    told = Stoppable(None, waits)
    ended = threading.Event()

    def read() -> None:
        try:
            waits.arrived(KEYS[0][0])
            waits.arrived(KEYS[0][1])
            waits.arrived(KEYS[0][2])
            while True:
                told.advance()
        finally:
            ended.set()

    with closing(waits.groups(read)) as places:
        assert next(places) == 0
        assert not ended.is_set()
    assert ended.is_set()


@pytest.mark.parametrize("first", [True, False])
def test_what_goes_wrong_in_the_background_is_raised(*, first: bool) -> None:
    waits = ReadAhead(KEYS, ahead=1)

    def read() -> None:
        for group in KEYS[: 0 if first else 2]:
            for key in group:
                waits.arrived(key)
        raise OSError("gone")

    with pytest.raises(OSError, match="gone"), closing(waits.groups(read)) as places:
        for _ in places:
            pass


def test_groups_come_to_what_the_whole_study_does(tmp_path: Path) -> None:
    rng = np.random.default_rng(3)
    for iso in (100, 200):
        for kind, level in (("flat", 400), ("dark", 60)):
            for frame in range(3):
                path = tmp_path / kind / f"iso{iso}_{frame}.dng"
                path.parent.mkdir(exist_ok=True)
                mosaic = rng.poisson(level, (40, 48)).astype(np.uint16)
                write_dng(
                    path,
                    mosaic,
                    cfa="RGGB",
                    iso=iso,
                    exposure_s=0.01,
                    white_level=1023,
                    bit_depth=10,
                    black_level=(60,) * 4,
                )
    study = load_study(tmp_path, Selection())
    whole = reduce_study(study, workers=2, tile=8, keep=(Kind.FLAT,))
    groups = [[one for one in study.series if one.iso == iso] for iso in study.isos]
    kept = [one.key for one in study.series if one.kind is Kind.FLAT]
    for workers in (1, 2):
        found = list(reduce_in_groups(study, groups, workers=workers, tile=8, kept=kept))
        assert [list(one.statistics) for one in found] == [[one.key for one in group] for group in groups]
        for one in found:
            assert all(repr(one.statistics[key]) == repr(whole.statistics[key]) for key in one.statistics)
            assert all(np.array_equal(one.sums[key], whole.sums[key]) for key in one.sums)
            assert list(one.sums) == [key for key in one.statistics if key[0] == "flat"]


def series(kind: Kind, exposure_s: float, frames: int = 5) -> Series:
    """Return a series of so many frames."""
    return Series(kind=kind, iso=100.0, exposure_s=exposure_s, frames=(None,) * frames)  # type: ignore[arg-type]


def test_unlit_series_far_from_the_flats_are_not_kept() -> None:
    flats = [series(Kind.FLAT, exposure_s) for exposure_s in (0.01, 0.04)]
    near = [series(Kind.DARK, exposure_s) for exposure_s in (0.004, 0.008, 0.02, 0.05, 0.1)]
    shortest, far = series(Kind.BIAS, 0.0001), [series(Kind.DARK, 0.002), series(Kind.DARK, 0.5)]
    alone = series(Kind.DARK, 0.03, frames=1)
    kept = {one.key for one in (*flats, *near, shortest)}
    assert may_be_mapped((*flats, *near, shortest, *far, alone)) == kept
    assert may_be_mapped((shortest, *far)) == {one.key for one in (shortest, *far)}


def test_maps_of_sums_of_several_widths_are_those_of_the_widest() -> None:
    rng = np.random.default_rng(5)
    wide = [rng.integers(0, 5000 * (1 + 30 * (k == 3)), (9, 14)).astype(np.uint32) for k in range(6)]
    some: list[Rows] = [narrowed(one) for one in wide]
    assert [one.dtype for one in some] == [np.uint32 if k == 3 else np.uint16 for k in range(6)]
    coefficients = rng.normal(size=(2, 6, 4))
    assert np.array_equal(combine(some, coefficients, cell=2), combine(wide, coefficients, cell=2))


def test_without_memory_nothing_is_read_ahead() -> None:
    waits = ReadAhead(KEYS, ahead=1)
    places: list[tuple[float, int]] = []
    done = 0

    def read() -> None:
        for group in KEYS:
            for key in group:
                waits.admit(key, lambda: False)
                places.append((key[1], done))
                waits.arrived(key)

    with closing(waits.groups(read)) as found:
        for place in found:
            done = place + 1
    assert all(place <= finished for place, finished in places)
