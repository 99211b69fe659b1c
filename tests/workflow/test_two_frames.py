"""A series that is two frames comes to the same bits with and without sums of single pixels."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import tifffile
from hypothesis import given
from hypothesis import strategies as st
from mixed_study import TILE, assert_same, assert_same_reduction, mixed_study

from fullwell.frames.series import Frame, Kind, Series
from fullwell.raw.open import read_header
from fullwell.statistics.accumulation import Accumulation
from fullwell.statistics.batch import Batch
from fullwell.statistics.moments import Layout, stack_of
from fullwell.statistics.pairs import pairs_of
from fullwell.workflow.reduce import reduce_study


@given(
    height=st.integers(2, 150),
    width=st.integers(2, 150),
    cfa=st.sampled_from(("mono", "RGGB")),
    tile=st.sampled_from((1, 4, 7, 64)),
    top=st.sampled_from((0, 1, 255, 4095, 16383, 16384, 40000, 65535)),
    unlit=st.booleans(),
    seed=st.integers(0, 2**32 - 1),
)
def test_two_frames_need_no_maps(
    *, height: int, width: int, cfa: str, tile: int, top: int, unlit: bool, seed: int
) -> None:
    rng = np.random.default_rng(seed)
    scene = rng.integers(0, top + 1, (height, width)).astype(np.float64)
    noise = rng.normal(0.0, top / 50, (2, height, width))
    stack = stack_of(list(np.rint(scene + noise).clip(0, top).astype(np.uint16)))
    layout = Layout(height=height, width=width, cfa=cfa, tile=tile)
    with_maps, without = (Accumulation(layout, unlit=unlit) for _ in range(2))
    batch = Batch(("a", "b"), stack)
    with_maps.look_at_pair(batch)
    with_maps.add(batch)
    without.add_only_two(batch, pairs=True)
    without.look_at_pair(batch)
    assert_same(without.finish(), with_maps.finish())


@pytest.mark.parametrize("damaged", [False, True])
def test_a_study_of_pairs_comes_to_the_same_with_and_without_its_sums(tmp_path: Path, *, damaged: bool) -> None:
    study, _ = mixed_study(tmp_path)
    pairs = tuple(replace(one, frames=one.frames[:2]) for one in study.series if len(one.frames) > 1)
    if damaged:
        pairs[0].frames[1].header.path.write_bytes(b"")
    study = replace(study, series=pairs)
    for together in (False, True):
        kept = reduce_study(study, workers=2, tile=TILE, keep=tuple(Kind), pairs=together)
        assert_same_reduction(reduce_study(study, workers=2, tile=TILE, pairs=together), kept)
        assert kept.sums


@pytest.mark.parametrize("top", [4095, 65535])
def test_pairs_read_in_parts_are_filtered_as_whole_ones(tmp_path: Path, *, top: int) -> None:
    rng = np.random.default_rng(3)
    frames: list[Frame] = []
    for name in ("a.tif", "b.tif"):
        scene = np.linspace(0, top - 99, 300)[:, np.newaxis] + rng.integers(0, 99, (300, 80))
        tifffile.imwrite(tmp_path / name, scene.astype(np.uint16), photometric="minisblack")
        header = read_header(tmp_path / name)
        frames.append(Frame(name=name, header=header, size=(tmp_path / name).stat().st_size))
    study = replace(mixed_study(tmp_path)[0], cfa="mono", height=300, width=80)
    study = replace(study, series=(Series(kind=Kind.FLAT, iso=None, exposure_s=1.0, frames=tuple(frames)),))
    kept = reduce_study(study, workers=1, tile=TILE, keep=tuple(Kind), pairs=True)
    found = reduce_study(study, workers=1, tile=TILE, pairs=True)
    assert_same_reduction(found, kept)
    ((plane,),) = (one.planes for one in found.statistics.values())
    assert plane.pair is not None
    assert plane.pair.filtered_variance is not None


def test_the_first_two_frames_of_any_series_are_looked_at_together(tmp_path: Path) -> None:
    study, mosaics = mixed_study(tmp_path)
    found = reduce_study(study, workers=2, tile=TILE, pairs=True)
    layout = Layout(height=study.height, width=study.width, cfa=study.cfa, tile=TILE)
    for series in study.series:
        stack = stack_of([mosaics[frame.name] for frame in series.frames[:2]])
        known = [plane.pair for plane in found.statistics[series.key].planes]
        if len(series.frames) < 2:
            assert known == [None] * 4
        else:
            assert_same(tuple(known), pairs_of(stack, (0, 1), layout, filtered=series.kind is Kind.FLAT))
