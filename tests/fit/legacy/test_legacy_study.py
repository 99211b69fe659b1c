"""The published study's arithmetic: its own numbers, brute force, and laws that hold for any Bayer order."""

import itertools
import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fullwell.fit.legacy.dark import DarkFrames, study_dark_lines
from fullwell.fit.legacy.read_noise import read_noise_repeats
from fullwell.fit.legacy.regions import Box, study_regions
from fullwell.fit.legacy.response import StudyResponse, response_figures, study_response
from fullwell.fit.legacy.shading_map import evaluate, fit_legacy_map, fit_poly22
from fullwell.fit.legacy.std_line import fit_std_line
from fullwell.fit.legacy.volts import VoltScale
from fullwell.raw.cfa import BAYER, MONO, channels
from fullwell.statistics.single_frames import corrected_std, frame_products

HEIGHT, WIDTH = 280, 352
EXPOSURES_S = (0.001, 0.002, 0.004)
FRAMES = (4, 5, 3)
ROUNDING = 1e-13
"""Some hundred times the rounding of float64: what is left of sums in another order."""


def planes(seed: int) -> dict[str, np.ndarray]:
    """Sums of three bursts per channel, shape (3, rows, columns)."""
    rng = np.random.default_rng(seed)
    x, y = np.mgrid[: HEIGHT // 2, : WIDTH // 2]
    light = 1.0 - 2e-5 * (x - 60.0) ** 2 - 1e-5 * (y - 90.0) ** 2
    levels = {"R": 60_000.0, "G1": 110_000.0, "G2": 108_000.0, "B": 70_000.0}
    return {
        channel: np.stack(
            [
                rng.poisson(frames * (64.0 + level * exposure_s * light))
                for frames, exposure_s in zip(FRAMES, EXPOSURES_S, strict=True)
            ]
        ).astype(np.uint32)
        for channel, level in levels.items()
    }


def mosaics(by_channel: dict[str, np.ndarray], cfa: str) -> list[np.ndarray]:
    sums = np.empty((len(EXPOSURES_S), HEIGHT, WIDTH), np.uint32)
    for site, channel in enumerate(channels(cfa)):
        sums[:, site // 2 :: 2, site % 2 :: 2] = by_channel[channel]
    return list(sums)


def response_of(
    sums: list[np.ndarray], cfa: str, *, frames: tuple[int, ...] = FRAMES, black_dn: tuple[float, ...] | None = None
) -> StudyResponse:
    base = fit_legacy_map(sums[0], frames[0], cfa=cfa, black_dn=black_dn)
    regions = study_regions(HEIGHT, WIDTH)
    return study_response(sums, frames, EXPOSURES_S, iso=55.0, cfa=cfa, base=base, regions=regions, black_dn=black_dn)


def test_the_published_numbers_are_where_the_study_looks() -> None:
    """imcrop [917 1505 1317 967] is rows 1505-2472 and columns 917-2234; the tile loop swaps its coordinates."""
    regions = study_regions(3024, 4032)
    assert regions.crop == Box(top=1504, left=916, height=2472 - 1504, width=2234 - 916)
    assert not regions.scaled
    r_coord, c_coord = (1, 193, 387, 581), (1, 263, 527, 791)
    assert regions.tiles == tuple(
        Box(top=1504 + c - 1, left=916 + r - 1, height=64, width=64) for c in c_coord for r in r_coord
    )


@given(st.integers(2, 4000) | st.integers(2, 60), st.integers(2, 5000) | st.integers(2, 60))
def test_scaled_regions_keep_their_phase_and_stay_inside(height: int, width: int) -> None:
    regions = study_regions(height, width)
    assert regions.scaled == (height < 2472 or width < 2234)
    for box in (regions.crop, *regions.tiles):
        assert box.top % 2 == box.left % 2 == box.height % 2 == box.width % 2 == 0
        assert box.top + box.height <= height
        assert box.left + box.width <= width
    for tile in regions.tiles:
        assert regions.crop.top <= tile.top <= regions.crop.top + regions.crop.height - tile.height
        assert regions.crop.left <= tile.left <= regions.crop.left + regions.crop.width - tile.width


def test_a_quarter_of_the_pixels_scales_by_a_half() -> None:
    """Every number halved, cut off, and 1 added where that is even: 458 -> 459, 752 -> 753, 658 -> 659, 483."""
    regions = study_regions(1512, 2016)
    assert regions.crop == Box(top=752, left=458, height=484, width=660)
    assert regions.tiles[1] == Box(top=752 + 0, left=458 + 96, height=32, width=32)
    assert regions.tiles[4] == Box(top=752 + 130, left=458 + 0, height=32, width=32)


@pytest.mark.parametrize("shape", [(3, 3), (40, 61), (700, 900)])
def test_a_quadratic_surface_is_found_again(shape: tuple[int, int]) -> None:
    x, y = np.meshgrid(np.arange(1, shape[0] + 1), np.arange(1, shape[1] + 1), indexing="ij")
    sums = (1_000_000 + 30 * x + 20 * y - 2 * x**2 - x * y - 3 * y**2 + 4_000_000).astype(np.uint32)
    fitted = fit_poly22(sums, 2)
    scale = sums.max() / 2
    for found, truth, size in zip(
        fitted.coefficients,
        (2_500_000.0, 15.0, 10.0, -1.0, -0.5, -1.5),
        (1, shape[0], shape[1], shape[0] ** 2, shape[0] * shape[1], shape[1] ** 2),
        strict=True,
    ):
        assert abs(found - truth) * size < 1e-11 * scale
    assert math.isclose(fitted.maximum, sums.max() / 2, rel_tol=1e-12)


@given(st.tuples(*[st.floats(-20.0, 20.0)] * 5), st.integers(3, 40), st.integers(3, 40))
def test_the_maximum_is_the_highest_value_on_the_grid(bends: tuple[float, ...], rows: int, columns: int) -> None:
    x, y = np.arange(1.0, rows + 1.0), np.arange(1.0, columns + 1.0)
    sums = np.rint(evaluate((100_000.0, *bends), x, y)).astype(np.uint32)
    found = fit_poly22(sums, 1)
    assert found.maximum == pytest.approx(evaluate(found.coefficients, x, y).max(), rel=ROUNDING)


def test_a_plane_of_two_rows_has_no_quadratic_surface() -> None:
    with pytest.raises(ValueError, match="3 x 3"):
        fit_poly22(np.ones((2, 9), np.uint32), 1)


def test_the_map_is_the_least_squares_of_its_plane() -> None:
    sums = planes(1)["R"][0]
    fitted = fit_poly22(sums, 4)
    x, y = (axis.ravel() + 1.0 for axis in np.indices(sums.shape))
    columns = np.stack([x**0, x, y, x**2, x * y, y**2], axis=1)
    scale = np.abs(columns).max(axis=0)
    expected = np.linalg.lstsq(columns / scale, sums.ravel() / 4.0, rcond=None)[0] / scale
    np.testing.assert_allclose(fitted.coefficients, expected, rtol=1e-10)
    assert math.isclose(fitted.maximum, float((columns @ expected).max()), rel_tol=1e-12)


@pytest.mark.parametrize("region", [(0, 0, 280, 352), (1, 0, 7, 9), (0, 1, 4, 5), (33, 21, 10, 3)])
def test_a_region_of_the_map_is_cut_out_of_the_whole(region: tuple[int, int, int, int]) -> None:
    base = fit_legacy_map(mosaics(planes(2), "GRBG")[0], 4, cfa="GRBG")
    whole = np.empty((HEIGHT, WIDTH))
    for site, surface in enumerate(base.surfaces):
        x, y = (np.arange(1.0, size // 2 + 1.0) for size in (HEIGHT, WIDTH))
        whole[site // 2 :: 2, site % 2 :: 2] = evaluate(surface.coefficients, x, y) / surface.maximum
    top, left, height, width = region
    cut = base.region(top=top, left=left, height=height, width=width)
    np.testing.assert_allclose(cut, whole[top : top + height, left : left + width], rtol=ROUNDING)


def test_channels_do_not_depend_on_the_bayer_order() -> None:
    by_channel = planes(3)
    first, *others = (response_of(mosaics(by_channel, cfa), cfa) for cfa in BAYER)
    for other, channel in itertools.product(others, (1, 2, 3)):
        assert other.crop[channel].channel == "RGB"[channel - 1]
        np.testing.assert_array_equal(other.crop[channel].slope_dn_per_s, first.crop[channel].slope_dn_per_s)
        np.testing.assert_array_equal(other.tiles[6][channel].intercept_dn, first.tiles[6][channel].intercept_dn)


def test_each_pixel_has_the_line_of_polyfit() -> None:
    sums = mosaics(planes(4), "BGGR")
    response = response_of(sums, "BGGR")
    shading = fit_legacy_map(sums[0], 4, cfa="BGGR").region(top=0, left=0, height=HEIGHT, width=WIDTH)
    levels = [burst / frames / shading for burst, frames in zip(sums, FRAMES, strict=True)]
    for index in (0, 6, 15):
        box = response.regions.tiles[index]
        part = np.stack([one[box.top : box.top + box.height, box.left : box.left + box.width] for one in levels])
        slope, intercept = np.polyfit(EXPOSURES_S, part.reshape(3, -1), 1).reshape(2, box.height, box.width)
        every, _, green, _ = response.tiles[index]
        np.testing.assert_allclose(every.slope_dn_per_s, slope, rtol=1e-10)
        np.testing.assert_allclose(every.intercept_dn, intercept, rtol=1e-10)
        np.testing.assert_allclose(green.slope_dn_per_s, (slope[::2, 1::2] + slope[1::2, ::2]) / 2.0, rtol=1e-10)


def test_the_pedestal_can_be_subtracted() -> None:
    """As if the files had been written without it."""
    by_channel = planes(5)
    black = {"R": 60, "G1": 64, "G2": 62, "B": 66}
    without = {
        channel: part - (np.array(FRAMES) * black[channel])[:, None, None].astype(np.uint32)
        for channel, part in by_channel.items()
    }
    levels = tuple(float(black[channel]) for channel in channels("RGGB"))
    subtracted = response_of(mosaics(by_channel, "RGGB"), "RGGB", black_dn=levels)
    direct = response_of(mosaics(without, "RGGB"), "RGGB")
    for one, other in zip(subtracted.crop, direct.crop, strict=True):
        scale = float(np.abs(other.slope_dn_per_s).max()) * max(EXPOSURES_S)
        np.testing.assert_allclose(one.slope_dn_per_s, other.slope_dn_per_s, rtol=1e-12)
        np.testing.assert_allclose(one.intercept_dn, other.intercept_dn, rtol=0.0, atol=1e-12 * scale)


def test_mono_has_one_channel() -> None:
    rng = np.random.default_rng(6)
    sums = [
        rng.poisson(frames * (64.0 + 1e5 * exposure_s), (HEIGHT, WIDTH)).astype(np.uint32)
        for frames, exposure_s in zip(FRAMES, EXPOSURES_S, strict=True)
    ]
    response = response_of(sums, MONO)
    assert response.channels == (MONO,)
    assert response.crop_spread.prnu_percent.shape == (1, 1)
    assert response.tile_spread.intercept_std.shape == (16, 1)
    assert [figure.channel for figure in response_figures(response)] == [MONO] * 4


def test_figures_are_the_crop_and_the_median_of_the_tiles() -> None:
    response = response_of(mosaics(planes(7), "BGGR"), "BGGR")
    figures = {(one.quantity, one.channel, one.region): one for one in response_figures(response)}
    assert len(figures) == 2 * 4 * 2
    green = response.crop[2].slope_dn_per_s
    crop = response.regions.crop
    place = f"{crop.left},{crop.top},{crop.width},{crop.height}"
    own = figures[("prnu", "G", place)]
    assert math.isclose(own.value, 100.0 * green.std(ddof=1) / green.mean(), rel_tol=1e-12)
    assert (own.method, own.unit, own.n, own.flags) == ("legacy-slope-std", "%", green.size, ("scaled-crop",))
    blue = [tile[3].intercept_dn.std(ddof=1) for tile in response.tiles]
    assert math.isclose(figures[("dsnu", "B", None)].value, np.median(blue), rel_tol=1e-12)
    assert figures[("dsnu", "B", None)].method == "legacy-intercept-std"


def test_the_mean_of_two_greens_hides_half_of_the_variance() -> None:
    """METHOD 5.3: .7071 of any independent variation; over n pixels a ratio of standard deviations scatters by 1/n."""
    rng = np.random.default_rng(8)
    sums = [rng.normal(1e6, 1e3, (HEIGHT, WIDTH)).astype(np.uint32) for _ in EXPOSURES_S]
    spread = response_of(sums, "BGGR").crop_spread
    _, red, green, blue = spread.slope_std[0]
    n = response_of(sums, "BGGR").crop[1].slope_dn_per_s.size
    assert abs(green / math.hypot(red, blue) - 0.5) < 0.5 * 4.0 / math.sqrt(n)


def test_one_exposure_has_no_line() -> None:
    with pytest.raises(ValueError, match="two exposure times that differ"):
        fit_std_line([0.01, 0.01], [1.0, 2.0])


def test_repeats_are_brute_force_and_their_mean_squares_the_published_flows() -> None:
    rng = np.random.default_rng(9)
    frames = [rng.normal(64.0, 1.5, (50, 70)).round().astype(np.uint16) for _ in range(5)]
    sums = [int(frame.sum()) for frame in frames]
    found = read_noise_repeats("abcde", sums, frame_products(frames), iso=55.0, n=3500)
    stack = np.stack(frames).astype(float)
    mean = stack.mean(axis=0)
    for j in range(5):
        pairs = [np.var(stack[i] - stack[j], ddof=1) / 2.0 for i in range(5) if i != j]
        assert math.isclose(found.flow1_dn[j], math.sqrt(np.mean(pairs)), rel_tol=1e-12)
        assert math.isclose(found.flow2_dn[j], np.std(mean - stack[j], ddof=1), rel_tol=1e-12)
    flow1, flow2 = (math.sqrt(np.mean(np.square(flow))) for flow in (found.flow1_dn, found.flow2_dn))
    assert math.isclose(flow1 / flow2, math.sqrt(5 / 4), rel_tol=1e-12)
    every = [np.var(a - b, ddof=1) / 2.0 for a, b in itertools.combinations(stack, 2)]
    assert math.isclose(flow1, math.sqrt(np.mean(every)), rel_tol=1e-12)


def test_products_of_the_largest_codes_are_exact() -> None:
    frame = np.full((1 << 10, 1 << 9), 65535, np.uint16)
    assert frame_products([frame, frame])[0][1] == 65535**2 * frame.size


@pytest.mark.parametrize("black_dn", [None, (60.0, 61.0, 62.0, 63.0)])
def test_corrected_std_is_std2(black_dn: tuple[float, ...] | None) -> None:
    rng = np.random.default_rng(10)
    mosaic = rng.integers(64, 900, (801, 500)).astype(np.uint16)
    shading = rng.uniform(0.5, 1.0, mosaic.shape)
    level = np.zeros(mosaic.shape)
    for site, black in enumerate(black_dn or ()):
        level[site // 2 :: 2, site % 2 :: 2] = black
    expected = ((mosaic - level) / shading).std(ddof=1)
    assert math.isclose(corrected_std(mosaic, shading, black_dn=black_dn), expected, rel_tol=1e-12)


def dark_bursts(seed: int) -> list[DarkFrames]:
    rng = np.random.default_rng(seed)
    return [
        DarkFrames(
            exposures_s=np.full(3, exposure_s),
            frame_means_dn=64.0 + 0.06 * exposure_s + rng.normal(0.0, 0.01, (3, 4)),
            pixels=np.array([12, 9, 8, 6]),
        )
        for exposure_s in (0.01, 0.02, 0.04, 0.08)
    ]


@pytest.mark.parametrize("every_frame", [True, False])
def test_dark_lines_are_polyfits(every_frame: bool) -> None:  # noqa: FBT001 - a parametrized value
    bursts = dark_bursts(11)
    lines = study_dark_lines(bursts, iso=99.0, cfa="BGGR", every_frame=every_frame)
    assert [line.channel for line in lines] == ["all", "R", "G", "B"]
    count = 3 if every_frame else 1
    time = np.concatenate([burst.exposures_s[:count] for burst in bursts])
    means = np.concatenate([burst.frame_means_dn[:count] for burst in bursts])
    levels = (means @ [12, 9, 8, 6] / 35.0, means[:, 3], (means[:, 1] + means[:, 2]) / 2.0, means[:, 0])
    for line, level in zip(lines, levels, strict=True):
        np.testing.assert_allclose((line.slope_dn_per_s, line.intercept_dn), np.polyfit(time, level, 1), rtol=1e-9)


def test_mono_has_one_dark_line() -> None:
    bursts = [
        DarkFrames(exposures_s=one.exposures_s, frame_means_dn=one.frame_means_dn[:, :1], pixels=one.pixels[:1])
        for one in dark_bursts(12)
    ]
    assert [line.channel for line in study_dark_lines(bursts, iso=None, cfa=MONO, every_frame=True)] == [MONO]


@pytest.mark.parametrize(("bit_depth", "white", "bits"), [(10, 1023.0, 10), (16, 1023.0, 10), (14, 15520.0, 14)])
def test_the_container_does_not_count_as_bits(bit_depth: int, white: float, bits: int) -> None:
    assert VoltScale(swing_v=0.459, bit_depth=bit_depth, white_level=white).code_bits == bits


def test_volts_as_published() -> None:
    """METHOD 3.2: .4591 / 1024 for read noise, .459 / 1023 elsewhere; METHOD 5.3: 1e-4 taken for DN is 4.5e-8 V."""
    volts = VoltScale(swing_v=0.45907, bit_depth=10, white_level=1023.0)
    assert volts.read_noise_v(1.5) == 1.5 * (0.4591 / 1024)
    assert volts.level_v(0.0001) == 0.0001 * 0.459 / 1023
    line = fit_std_line([0.001, 0.002], [6.5535 + 100.0, 6.5535 + 200.0])
    assert math.isclose(line.intercept_dn, 6.5535, rel_tol=1e-12)
    assert math.isclose(line.as_published, 1e-4, rel_tol=1e-12)
    assert f"{volts.level_v(line.as_published):.1e}" == "4.5e-08"
