"""Single frames read again: the same figures as the first time, and what happens when files change in between."""

import math
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest

from fullwell.findings import Severity
from fullwell.fit.legacy.read_noise import legacy_read_noise
from fullwell.fit.legacy.shading_map import fit_legacy_map
from fullwell.frames.selection import Selection
from fullwell.frames.series import Kind
from fullwell.frames.study import load_study
from fullwell.raw.open import read_raw
from fullwell.testing.studies import simulated_study, simulation
from fullwell.workflow.measure.bursts import IsoBursts, group_by_iso
from fullwell.workflow.published.second_look import SecondLook, base_group, look_again
from fullwell.workflow.reduce import reduce_study

STUDY = {
    "isos": [100, 200],
    "flat": {"exposures_s": [0.001, 0.002], "electrons": [1000.0, 2000.0], "frames": 2},
    "bias": {"exposures_s": [0.0001], "frames": 6},
}


@pytest.fixture
def groups(tmp_path: Path) -> tuple[IsoBursts, ...]:
    simulated_study(tmp_path / "study", simulation(study=STUDY))
    study = load_study(tmp_path / "study", Selection())
    reduction = reduce_study(study, workers=1, tile=16, keep=(Kind.FLAT,))
    return group_by_iso(study, reduction.statistics, reduction.sums)


def look(groups: Sequence[IsoBursts], *, workers: int = 2) -> SecondLook:
    first = groups[0].flats[0]
    base = fit_legacy_map(first.sums, first.frames, cfa="BGGR")
    return look_again(groups, base=base, workers=workers)


def test_repeats_make_up_the_published_flows(groups: tuple[IsoBursts, ...]) -> None:
    found = look(groups)
    assert [one.iso for one in found.read_noise] == [100.0, 200.0]
    for group, repeats in zip(groups, found.read_noise, strict=True):
        flows = legacy_read_noise(group.biases[0].statistics.legacy)
        assert repeats.frames == group.biases[0].statistics.frames[:5]
        for per_repeat, whole in ((repeats.flow1_dn, flows.pair_difference), (repeats.flow2_dn, flows.burst_mean)):
            assert math.isclose(math.sqrt(np.mean(per_repeat**2)), whole.value, rel_tol=1e-12)
    assert not found.findings


def test_first_frames_that_were_looked_at_are_not_read_again(tmp_path: Path) -> None:
    simulated_study(tmp_path / "study", simulation(study=STUDY))
    study = load_study(tmp_path / "study", Selection())
    reduction = reduce_study(study, workers=2, tile=16, keep=(Kind.FLAT,))
    again = look_again(group_by_iso(study, reduction.statistics, reduction.sums), base=None, workers=2)
    groups = group_by_iso(study, reduction.statistics, reduction.sums, reduction.first)
    for frame in (one for group in groups for one in group.biases[0].series.frames):
        (study.root / frame.name).unlink()
    known = look_again(groups, base=None, workers=2)
    assert not known.findings
    for one, other in zip(known.read_noise, again.read_noise, strict=True):
        assert one.frames == other.frames
        np.testing.assert_array_equal(one.flow1_dn, other.flow1_dn)
        np.testing.assert_array_equal(one.flow2_dn, other.flow2_dn)


def test_flats_of_the_lowest_iso_make_the_line(groups: tuple[IsoBursts, ...]) -> None:
    line = look(groups).std_line
    first = groups[0].flats[0]
    base = fit_legacy_map(first.sums, first.frames, cfa="BGGR")
    shading = base.region(top=0, left=0, height=base.height, width=base.width)
    frames = [frame for burst in groups[0].flats for frame in burst.series.frames]
    expected = [(read_raw(frame.header.path).mosaic / shading).std(ddof=1) for frame in frames]
    np.testing.assert_allclose(line.std_dn, expected, rtol=1e-12)
    assert line.exposure_s.tolist() == [0.001, 0.001, 0.002, 0.002]
    np.testing.assert_allclose(
        (line.slope_dn_per_s, line.intercept_dn), np.polyfit(line.exposure_s, expected, 1), rtol=1e-9
    )


def test_any_number_of_threads_finds_the_same(groups: tuple[IsoBursts, ...]) -> None:
    one, many = (look(groups, workers=workers) for workers in (1, 5))
    for a, b in zip(one.read_noise, many.read_noise, strict=True):
        assert a.flow1_dn.tolist() == b.flow1_dn.tolist()
    assert one.std_line.std_dn.tolist() == many.std_line.std_dn.tolist()


def test_frames_lost_between_the_looks_are_named_and_left_out(groups: tuple[IsoBursts, ...]) -> None:
    bias, flat = groups[0].biases[0].series.frames[1], groups[0].flats[1].series.frames[0]
    bias.header.path.write_bytes(bias.header.path.read_bytes()[:5000])
    flat.header.path.unlink()
    found = look(groups)
    assert [len(one.frames) for one in found.read_noise] == [4, 5]
    assert bias.name not in found.read_noise[0].frames
    assert found.std_line.exposure_s.tolist() == [0.001, 0.001, 0.002]
    (finding,) = found.findings
    assert (finding.code, finding.severity) == ("second-look-failed", Severity.ERROR)
    assert finding.files == tuple(sorted((bias.name, flat.name)))


def test_an_iso_that_lost_all_but_one_frame_has_no_repeats(groups: tuple[IsoBursts, ...]) -> None:
    for frame in groups[1].biases[0].series.frames[1:]:
        frame.header.path.unlink()
    assert [one.iso for one in look(groups).read_noise] == [100.0]


def test_without_a_map_only_read_noise_is_looked_at(groups: tuple[IsoBursts, ...]) -> None:
    found = look_again(groups, base=None, workers=1)
    assert found.std_line is None
    assert len(found.read_noise) == 2


def test_the_lowest_known_iso_with_flats_makes_the_map(groups: tuple[IsoBursts, ...]) -> None:
    assert base_group(tuple(reversed(groups))) is groups[0]
    assert base_group(()) is None


def test_every_frame_is_told_of(groups: tuple[IsoBursts, ...]) -> None:
    told: list[int] = []

    class Counting:
        def start(self, total_frames: int) -> None:
            told.append(-total_frames)

        def advance(self, frames: int = 1) -> None:
            told.append(frames)

    first = groups[0].flats[0]
    base = fit_legacy_map(first.sums, first.frames, cfa="BGGR")
    look_again(groups, base=base, workers=2, progress=Counting())
    assert told[0] == -(2 * 5 + 2 * 2)
    assert sum(told) == 0
