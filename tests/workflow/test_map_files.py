import json
from pathlib import Path

import numpy as np
import pytest

from fullwell.errors import UsageError
from fullwell.fit.shading.data import ShadingData
from fullwell.raw.cfa import channels
from fullwell.workflow.maps import (
    ChannelMap,
    NamedArray,
    ShadingMapFile,
    load_shading_map,
    map_grid,
    save_pixel_maps,
    save_shading_map,
    shading_stem,
)


def falloff(rows: np.ndarray, columns: np.ndarray, *, centre: tuple[float, float], reach: float) -> np.ndarray:
    squared = (rows - centre[0])[:, None] ** 2 + (columns - centre[1])[None, :] ** 2
    return (1.0 + squared / reach**2) ** -2.0


def shading(*, cfa: str = "GBRG", width: int = 700, height: int = 500, iso: float | None = 55.0) -> ShadingMapFile:
    rng = np.random.default_rng(5)
    planes = []
    for index, channel in enumerate(channels(cfa)):
        grid = map_grid((height // 2, width // 2))
        bins = (31, 43)
        signal = rng.normal(500.0, 1.0, bins)
        signal[3, 4] = np.nan
        data = ShadingData(
            rows=np.arange(bins[0]) * 8 + 3.5,
            columns=np.arange(bins[1]) * 8 + 3.5,
            signal_dn=signal,
            temporal_variance_dn2=np.full(bins, 0.1),
            fixed_variance=np.full(bins, 1e-6),
            plane_shape=(height // 2, width // 2),
            pitch_um=2.8,
        )
        planes.append(
            ChannelMap(
                channel=channel,
                model="p-spline",
                parameters={"coefficients": rng.normal(size=(5, 6)), "name": np.asarray("p-spline")},
                data=data,
                grid_row=grid[0],
                grid_column=grid[1],
                normalized=falloff(*grid, centre=(130.25, 170.5), reach=400.0 + index),
                centre=(130.25, 170.5),
                maximum_dn=512.0 + index,
                black_level_dn=64.0,
            )
        )
    return ShadingMapFile(
        cfa=cfa, width=width, height=height, orientation=6, iso=iso, exposure_s=0.0004, channels=tuple(planes)
    )


@pytest.mark.parametrize("iso", [55.0, None])
def test_a_shading_map_comes_back_as_it_was(tmp_path: Path, iso: float | None) -> None:
    saved = shading(iso=iso)
    loaded = load_shading_map(save_shading_map(tmp_path, saved))
    for name in ("cfa", "width", "height", "orientation", "iso", "exposure_s", "camera"):
        assert getattr(loaded, name) == getattr(saved, name)
    for ours, theirs in zip(loaded.channels, saved.channels, strict=True):
        assert (ours.channel, ours.model, ours.centre) == (theirs.channel, theirs.model, theirs.centre)
        assert (ours.maximum_dn, ours.black_level_dn) == (theirs.maximum_dn, theirs.black_level_dn)
        np.testing.assert_array_equal(ours.normalized, theirs.normalized)
        for name in ("plane_shape", "pitch_um", "focal_length_mm"):
            assert getattr(ours.data, name) == getattr(theirs.data, name)
        for name in ("rows", "columns", "signal_dn", "temporal_variance_dn2", "fixed_variance"):
            stored = getattr(theirs.data, name).astype(np.float32)
            np.testing.assert_array_equal(getattr(ours.data, name), stored, err_msg=name)
        np.testing.assert_array_equal(ours.parameters["coefficients"], theirs.parameters["coefficients"])
        assert str(ours.parameters["name"]) == "p-spline"


def test_the_same_map_is_the_same_bytes_and_its_companion_tells_every_array(tmp_path: Path) -> None:
    first, second = tmp_path / "1", tmp_path / "2"
    for folder in (first, second):
        folder.mkdir()
        save_shading_map(folder, shading())
    name = f"{shading_stem(iso=55.0, exposure_s=0.0004)}.npz"
    assert (first / name).read_bytes() == (second / name).read_bytes()
    document = json.loads((first / name).with_suffix(".json").read_text(encoding="utf-8"))
    with np.load(first / name) as opened:
        told = {one["name"]: (tuple(one["shape"]), one["dtype"]) for one in document["arrays"]}
        kinds = {key: "str" if opened[key].dtype.kind == "U" else opened[key].dtype.name for key in opened.files}
        assert told == {key: (opened[key].shape, kinds[key]) for key in opened.files}
    assert told["cfa"] == ((), "str")
    assert all(np.dtype(kind) for _, kind in told.values())
    units = {one["name"]: one["unit"] for one in document["arrays"]}
    assert (units["R.signal_dn"], units["B.grid_row"], units["G1.normalized"]) == ("DN", "pixel", "1")
    assert units["R.temporal_variance_dn2"] == "DN^2"


def test_a_map_between_its_grid_points_is_the_smooth_surface(tmp_path: Path) -> None:
    loaded = load_shading_map(save_shading_map(tmp_path, shading()))
    rows, columns = np.arange(-0.75, 250.0, 0.5), np.arange(-0.75, 350.0, 0.5)
    truth = falloff(rows, columns, centre=(130.25, 170.5), reach=400.0)
    # A cubic interpolant of step h errs by at most 5/384 h^4 max|f''''| inside, and here |f''''| <= 72/reach^4; the
    # half step beyond an edge and the two axes together stay below four times that.
    step = max(float(np.diff(axis).max()) for axis in map_grid((250, 350)))
    bound = 4.0 * 5.0 / 384.0 * 72.0 * (step / 400.0) ** 4
    assert bound < 1e-6
    np.testing.assert_allclose(loaded.channels[0].at(rows, columns), truth, rtol=0.0, atol=bound)


def test_what_is_no_map_is_refused_in_a_sentence(tmp_path: Path) -> None:
    other = tmp_path / "other.npz"
    np.savez(other, a=np.zeros(3))
    (tmp_path / "text.npz").write_text("no archive", encoding="utf-8")
    whole = save_shading_map(tmp_path, shading())
    (tmp_path / "cut.npz").write_bytes(whole.read_bytes()[:5000])
    for name, words in (("missing.npz", "does not exist"), *((n, "no shading map") for n in ("other", "text", "cut"))):
        with pytest.raises(UsageError, match=words):
            load_shading_map((tmp_path / name).with_suffix(".npz"))


def test_maps_per_pixel_are_plain_float32_with_units(tmp_path: Path) -> None:
    slope = np.random.default_rng(3).normal(size=(7, 9))
    arrays = {"slope": NamedArray(values=slope, unit="DN/s", description="response of each pixel")}
    path = save_pixel_maps(tmp_path / "response.npz", arrays, about={"iso": 55})
    with np.load(path) as opened:
        assert opened["slope"].dtype == np.float32
        np.testing.assert_array_equal(opened["slope"], slope.astype(np.float32))
    document = json.loads(path.with_suffix(".json").read_text(encoding="utf-8"))
    assert document["schema"] == "fullwell-map/1"
    assert document["iso"] == 55
    assert document["arrays"] == [
        {"name": "slope", "shape": [7, 9], "dtype": "float32", "unit": "DN/s", "description": "response of each pixel"}
    ]
