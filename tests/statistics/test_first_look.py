"""What the first frames tell one by one is what their mosaics tell, in whatever batches and strips they come."""

import numpy as np
import pytest

from fullwell.kernels.frame_products import add_frame_products
from fullwell.kernels.stack import Band
from fullwell.statistics.accumulation import Accumulation
from fullwell.statistics.batch import Batch
from fullwell.statistics.first_look import LARGEST_SIDE, middle
from fullwell.statistics.moments import Layout, stack_of
from fullwell.statistics.single_frames import frame_products

RNG = np.random.default_rng(11)
NAMES = tuple("abcdefg")


@pytest.mark.parametrize("highest", [1023, 65535])
@pytest.mark.parametrize("frames", [1, 2, 5])
def test_products_equal_their_readable_twin(highest: int, frames: int) -> None:
    mosaics = RNG.integers(highest // 2, highest + 1, (frames, 33, 1300)).astype(np.uint16)
    totals = np.zeros((frames, frames), np.uint64)
    for top in range(0, 33, 8):
        add_frame_products(stack_of(mosaics), Band(top, min(top + 8, 33), 2, 4), totals)
    assert [tuple(row[at:]) for at, row in enumerate(totals.tolist())] == [
        row[at:] for at, row in enumerate(frame_products(list(mosaics)))
    ]


@pytest.mark.parametrize("unlit", [True, False])
@pytest.mark.parametrize("shape", [(70, 90), (1100, 1030)])
def test_first_frames_are_looked_at_as_they_pass(shape: tuple[int, int], *, unlit: bool) -> None:
    mosaics = dict(zip(NAMES, RNG.integers(40, 90, (7, *shape)).astype(np.uint16), strict=True))
    sums = Accumulation(Layout(height=shape[0], width=shape[1], cfa="RGGB", tile=8), unlit=unlit)
    sums.expect(NAMES)
    for some in (("f", "g"), ("c", "b", "a", "e", "d")):
        sums.add(Batch(some, stack_of([mosaics[name] for name in some])))
    found = sums.look.found
    assert found is not None
    assert found.middles is not None
    assert found.frames == NAMES[: 5 if unlit else 2]
    assert found.products == (frame_products([mosaics[name] for name in NAMES[:5]]) if unlit else ())
    rows, columns = middle(shape, 2)
    assert [rows.stop - rows.start, columns.stop - columns.start] == [min(side, LARGEST_SIDE) for side in shape]
    for name, kept in zip("ab", found.middles, strict=True):
        np.testing.assert_array_equal(kept, mosaics[name][rows, columns])
    sums.clear(unlit=unlit)
    assert sums.look.found is None


def test_frames_that_come_apart_are_not_looked_at() -> None:
    sums = Accumulation(Layout(height=16, width=16, cfa="mono", tile=8), unlit=True)
    sums.expect(NAMES)
    for some in (("a", "b", "c"), ("d", "e")):
        sums.add(Batch(some, stack_of(list(RNG.integers(40, 90, (len(some), 16, 16)).astype(np.uint16)))))
    assert sums.look.found is None
