import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from shading_maps import known_map, lens, shaded_mosaic

from fullwell.errors import UsageError
from fullwell.raw.cfa import BAYER, MONO, cell, channels, shifted
from fullwell.workflow.shading.correction import corrected, gain_maps
from fullwell.workflow.shading.placement import Geometry, place, turned_cfa

SIZE = (96, 128)
SHOWN_LEFT = {1: 0, 8: 1, 3: 2, 6: 3}


def letters(cfa: str, size: tuple[int, int]) -> np.ndarray:
    return np.array([[cfa[row % 2 * 2 + column % 2] for column in range(size[1])] for row in range(size[0])])


@given(
    cfa=st.sampled_from(BAYER),
    quarters=st.integers(0, 3),
    size=st.tuples(st.integers(2, 7), st.integers(2, 7)),
)
def test_a_turned_cfa_is_that_of_the_turned_mosaic(cfa: str, quarters: int, size: tuple[int, int]) -> None:
    turned = np.rot90(letters(cfa, size), quarters)
    assert turned_cfa(cfa, quarters=quarters, size=size) == "".join(turned[:2, :2].ravel())


@pytest.mark.parametrize("size", [SIZE, (95, 128), (96, 127), (95, 127), (96, 96)])
@pytest.mark.parametrize("quarters", range(4))
@pytest.mark.parametrize("cfa", [*BAYER, MONO])
def test_a_turned_scene_gets_the_turned_map(cfa: str, quarters: int, size: tuple[int, int]) -> None:
    """The tag that a program leaves after it has turned the mosaic shows it upright as before."""
    shading = known_map(cfa=cfa, size=size, orientation=6)
    tag = {left: tag for tag, left in SHOWN_LEFT.items()}[(SHOWN_LEFT[6] - quarters) % 4]
    turned = (size[::-1] if quarters % 2 else size, turned_cfa(cfa, quarters=quarters, size=size))
    scene = Geometry(height=turned[0][0], width=turned[0][1], cfa=turned[1], orientation=tag)
    seen = quarters
    if turned == (size, cfa):
        seen = 0  # nothing tells the turn: the mosaic counts, not the tag
    placement = place(shading, scene)
    assert (placement.quarters, placement.shift) == (seen, (0, 0))
    whole = np.empty(size)
    period = cell(cfa)
    for site, channel in enumerate(channels(cfa)):
        window = (slice(site // period, None, period), slice(site % period, None, period))
        whole[window] = lens(channel, np.arange(size[0])[window[0]], np.arange(size[1])[window[1]], size=size)
    whole = np.rot90(whole, seen)
    for site in range(cell(scene.cfa) ** 2):
        top, left = site // period, site % period
        rows, columns = (
            np.arange(first, end, period, dtype=float) for first, end in ((top, whole.shape[0]), (left, whole.shape[1]))
        )
        # Cubic interpolation of step h errs by 5/384 h^4 |f''''|, |f''''| < 200/reach^4 here, h < 3: below 1e-6.
        np.testing.assert_allclose(
            placement.at(site, rows, columns), whole[top::period, left::period], rtol=0, atol=1e-6
        )


@pytest.mark.parametrize("cfa", BAYER)
def test_a_shifted_mosaic_gets_its_planes_by_colour(cfa: str) -> None:
    shading = known_map(cfa="BGGR")
    placement = place(shading, Geometry(height=SIZE[0], width=SIZE[1], cfa=cfa))
    assert placement.quarters == 0
    assert shifted("BGGR", rows=placement.shift[0], columns=placement.shift[1]) == cfa
    for site, channel in enumerate(channels(cfa)):
        assert placement.channel(site).channel == channel
        rows, columns = np.arange(site // 2, 96.0, 2.0), np.arange(site % 2, 128.0, 2.0)
        np.testing.assert_allclose(
            placement.at(site, rows, columns), lens(channel, rows, columns, size=SIZE), rtol=0, atol=1e-6
        )


def test_half_a_turn_is_believed_only_with_its_tag() -> None:
    shading = known_map(cfa="BGGR")
    half = {"height": 96, "width": 128, "cfa": "RGGB"}
    assert place(shading, Geometry(**half, orientation=3)).quarters == 2
    assert place(shading, Geometry(**half, orientation=1)).shift == (1, 1)
    assert place(shading, Geometry(**half, orientation=2)).shift == (1, 1)
    assert place(shading, Geometry(height=96, width=128, cfa="BGGR", orientation=3)).quarters == 0
    assert place(shading, Geometry(**half, orientation=1), quarters=2).quarters == 2


def test_a_turned_and_shifted_scene_is_turned_by_its_tag() -> None:
    shading = known_map(cfa="BGGR")
    placement = place(shading, Geometry(height=128, width=96, cfa="BGGR", orientation=8), quarters=None)
    assert placement.quarters == 3
    assert (
        shifted(turned_cfa("BGGR", quarters=3, size=SIZE), rows=placement.shift[0], columns=placement.shift[1])
        == "BGGR"
    )


@pytest.mark.parametrize(
    ("scene", "words"),
    [
        (Geometry(height=90, width=128, cfa="BGGR"), "128 x 90 pixels, the map 128 x 96"),
        (Geometry(height=128, width=96, cfa="BGGR"), "Give --turn 90 or --turn 270"),
        (Geometry(height=96, width=128, cfa=MONO), "CFA is mono, the map's is BGGR"),
    ],
)
def test_a_map_that_does_not_fit_is_refused_in_a_sentence(scene: Geometry, words: str) -> None:
    with pytest.raises(UsageError, match=words):
        place(known_map(cfa="BGGR"), scene)


@pytest.mark.parametrize(
    ("black", "white", "scale"), [(64.0, 1023.0, None), (0.0, 1023.0, None), (4096.0, 65535.0, 0.5)]
)
@pytest.mark.parametrize("cfa", ["GRBG", MONO])
def test_a_corrected_scene_is_the_scene_without_its_lens(
    cfa: str, black: float, white: float, scale: float | None
) -> None:
    codes, signal = shaded_mosaic(cfa=cfa, black=black, full=0.85 * (white - black))
    codes[5, 7] = 0  # below black: noise must not wrap
    codes[90, 120] = int(white)
    levels = {"black_level": (black,) * cell(cfa) ** 2, "white_level": (white,) * cell(cfa) ** 2}
    result = corrected(codes, place(known_map(cfa=cfa), Geometry(height=96, width=128, cfa=cfa)), **levels)
    corners = (np.array([0.0, 95.0]), np.array([0.0, 127.0]))
    least, smallest = (lens(one, *corners, size=SIZE).min() for one in ("R", "mono" if cfa == MONO else "R"))
    assert result.scale.is_integer() if scale is None else result.scale < 1.0
    assert result.white_level <= 65535
    found = (result.mosaic - result.black_level[0]) / result.scale
    # Half a code of the scene, made larger by the map, half a code of the result, and the interpolation of the map.
    bound = 0.5 / least + 0.5 / result.scale + 1e-6 * white / least
    usual = np.ones(SIZE, dtype=bool)
    usual[5, 7] = usual[90, 120] = False
    assert np.abs(found - signal)[usual].max() <= bound
    assert found[5, 7] <= -black + bound
    assert result.mosaic[90, 120] > result.white_level
    assert result.mosaic.max() <= 65535
    if scale is None:
        needed = (white - black) / smallest + result.black_level[0] / result.scale
        assert (result.scale + 1.0) * needed > 65535
        distinct = [np.unique(plane).size for plane in (codes, result.mosaic)]
        assert distinct[1] >= distinct[0]


def test_gain_maps_undo_the_lens() -> None:
    placement = place(known_map(cfa="BGGR"), Geometry(height=96, width=128, cfa="BGGR"))
    maps = gain_maps(placement)
    assert [(one.top, one.left, one.row_pitch, one.column_pitch) for one in maps] == [
        (0, 0, 2, 2),
        (0, 1, 2, 2),
        (1, 0, 2, 2),
        (1, 1, 2, 2),
    ]
    for site, one in enumerate(maps):
        rows, columns = np.arange(site // 2, 96, 2), np.arange(site % 2, 128, 2)
        product = one.at(rows, columns, size=SIZE)[:, :, 0] * placement.at(
            site, rows.astype(float), columns.astype(float)
        )
        # Linear interpolation errs by h^2/8 f'' per axis; of (1 + u^2)^2.2 with u < 0.8, f'' < 20/reach^2 and h < 1.6.
        np.testing.assert_allclose(product, 1.0, rtol=0, atol=2 * 1.6**2 / 8 * 20 / 150.0**2)


def test_a_map_that_reaches_zero_divides_nothing() -> None:
    shading = known_map(cfa=MONO)
    shading.channels[0].normalized[0, 0] = -0.1
    placement = place(shading, Geometry(height=96, width=128, cfa=MONO))
    codes, _signal = shaded_mosaic(cfa=MONO)
    with pytest.raises(UsageError, match="not above 0"):
        corrected(codes, placement, black_level=(64.0,), white_level=(1023.0,))
    with pytest.raises(UsageError, match="not above 0"):
        gain_maps(placement)
