"""A simulated study is real files that other programs open, and the same files whoever writes them."""

import json
from pathlib import Path

import numpy as np
import pytest

from fullwell.errors import UsageError
from fullwell.frames.selection import Selection
from fullwell.frames.study import load_study
from fullwell.raw.open import read_raw
from fullwell.simulate.camera import build, take
from fullwell.simulate.truth import true_values
from fullwell.testing import simulated_study, simulation
from fullwell.workflow.simulation.simulate import simulate

STUDY = {
    "isos": [100, 400],
    "flat": {"exposures_s": [0.001], "electrons": [2000.0], "frames": 2},
    "dark": {"exposures_s": [0.5], "frames": 1},
    "bias": {"exposures_s": [0.0001], "frames": 2},
    "scene": {"subjects": ["patches"]},
}


def contents(folder: Path) -> dict[str, bytes]:
    return {path.relative_to(folder).as_posix(): path.read_bytes() for path in folder.rglob("*") if path.is_file()}


def test_files_are_the_same_for_any_number_of_workers(tmp_path: Path) -> None:
    config = simulation(study=STUDY, output={"compression": "lossless-jpeg"})
    written = [contents(simulated_study(tmp_path / str(n), config, workers=n).root) for n in (1, 2, 7)]
    assert written[0] == written[1] == written[2]
    other = simulation(seed=2, study=STUDY, output={"compression": "lossless-jpeg"})
    assert contents(simulated_study(tmp_path / "other", other).root) != written[0]


@pytest.mark.parametrize("compression", ["none", "lossless-jpeg"])
def test_libraw_reads_the_simulated_codes(tmp_path: Path, compression: str) -> None:

    rawpy = pytest.importorskip("rawpy")
    config = simulation(study=STUDY, output={"compression": compression})
    study = simulated_study(tmp_path / "study", config)
    frame = study.frames[0]
    mosaic = take(build(config.sensor, seed=config.seed), frame.exposure)
    path = study.root / f"{frame.name}.dng"
    with rawpy.imread(str(path)) as opened:
        assert np.array_equal(opened.raw_image_visible, mosaic)
        assert opened.black_level_per_channel == [256] * 4
        assert opened.white_level == 4095
    assert np.array_equal(read_raw(path).mosaic, mosaic)


def test_the_study_is_indexed_by_its_folders(tmp_path: Path) -> None:
    study = load_study(simulated_study(tmp_path / "study", simulation(study=STUDY)).root, Selection())
    assert [(one.kind, one.iso, one.exposure_s, len(one.frames)) for one in study.series] == [
        ("bias", 100.0, 0.0001, 2),
        ("bias", 400.0, 0.0001, 2),
        ("dark", 100.0, 0.5, 1),
        ("dark", 400.0, 0.5, 1),
        ("flat", 100.0, 0.001, 2),
        ("flat", 400.0, 0.00025, 2),
        ("scene", 100.0, 0.01, 1),
    ]
    assert study.cfa == "BGGR"
    assert study.excluded == ()
    assert study.black_level is not None
    assert study.black_level.values == (256.0,) * 4


def test_tiff_frames_are_indexed_by_their_names_and_sidecars(tmp_path: Path) -> None:
    written = simulated_study(tmp_path / "study", simulation(study=STUDY, output={"format": "tiff"}))
    study = load_study(written.root, Selection())
    assert {(one.kind, one.iso) for one in study.series} >= {("flat", 400.0), ("dark", 100.0), ("bias", 100.0)}
    assert study.cfa == "BGGR"
    frame = written.frames[0]
    mosaic = take(build(written.config.sensor, seed=1), frame.exposure)
    assert np.array_equal(read_raw(written.root / f"{frame.name}.tiff").mosaic, mosaic)


def test_headerless_frames_are_plain_little_endian_codes(tmp_path: Path) -> None:
    written = simulated_study(tmp_path / "study", simulation(study=STUDY, output={"format": "headerless"}))
    frame = written.frames[-1]
    mosaic = take(build(written.config.sensor, seed=1), frame.exposure)
    stored = np.fromfile(written.root / f"{frame.name}.raw", dtype="<u2").reshape(mosaic.shape)
    assert np.array_equal(stored, mosaic)
    sidecar = json.loads((written.root / f"{frame.name}.json").read_text(encoding="utf-8"))
    assert (sidecar["PixelFormat"], sidecar["ExposureTime"]) == ("BayerBG12", 10000.0)


def test_truth_is_written_beside_the_frames(tmp_path: Path) -> None:
    written = simulated_study(tmp_path / "study", simulation(study=STUDY))
    document = json.loads((written.root / "truth.json").read_text(encoding="utf-8"))
    assert document["schema"] == "fullwell-truth/1"
    assert {frame["path"] for frame in document["frames"]} == {f"{frame.name}.dng" for frame in written.frames}
    values = {(one["quantity"], one["channel"], one["unit"], one["iso"]): one["value"] for one in document["truth"]}
    assert values["system_gain", "G1", "DN/e-", 400.0] == 2.0
    assert values["black_level", "all", "DN", 100.0] == 256.0
    # 2.5 e- of each pixel, 0.3 e- of its row, 4 e-/s for 0.1 ms; 2 DN/e- at ISO 400.
    noise = np.sqrt(2.5**2 + 0.3**2 + 4.0 * 1e-4)
    assert values["read_noise", "R", "e-", 400.0] == pytest.approx(noise, rel=1e-12)
    assert values["read_noise", "R", "DN", 400.0] == pytest.approx(2.0 * noise, rel=1e-12)
    assert values["dark_current", "B", "DN/s", 400.0] == 8.0
    assert values["prnu", "B", "%", 400.0] == pytest.approx(0.6, rel=1e-12)
    assert values["saturation_capacity", "B", "e-", 100.0] == 7000.0
    assert values["saturation_capacity", "B", "e-", 400.0] == (4095 - 256) / 2.0


def test_every_true_value_has_a_name_of_its_own() -> None:
    named = [
        (one.quantity, one.channel, one.unit, one.iso, one.snr_threshold, one.exposure_s)
        for one in true_values(simulation())
    ]
    assert len(named) == len(set(named))


def test_only_a_simulation_of_ours_is_replaced(tmp_path: Path) -> None:
    config = tmp_path / "config.toml"
    config.write_text(
        "[camera]\nwidth = 32\nheight = 32\n[study]\nbias = {exposures_s = [0.001], frames = 1}\n", encoding="utf-8"
    )
    out = tmp_path / "study"
    simulate(config, out, workers=1)
    (out / "bias" / "stale.dng").touch()
    (out / ".DS_Store").touch()
    simulate(config, out, workers=1)
    assert sorted(path.name for path in out.iterdir()) == ["bias", "config.toml", "truth.json"]
    assert not (out / "bias" / "stale.dng").exists()
    (out / "study.toml").touch()
    with pytest.raises(UsageError, match=r"beside simulated frames it holds study\.toml"):
        simulate(config, out, workers=1)
    assert (out / "study.toml").exists()
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine" / "photo.dng").touch()
    with pytest.raises(UsageError, match="left untouched"):
        simulate(config, tmp_path / "mine", workers=1)
    assert [path.name for path in (tmp_path / "mine").iterdir()] == ["photo.dng"]
    with pytest.raises(UsageError, match="is a file"):
        simulate(config, config, workers=1)


def test_a_failure_leaves_nothing_behind(tmp_path: Path) -> None:
    class Stop:
        def start(self, total_frames: int) -> None:
            assert total_frames == 11

        def advance(self, frames: int = 1) -> None:
            assert frames == 1
            raise KeyboardInterrupt

    from fullwell.workflow.simulation.simulate import simulate_config  # noqa: PLC0415 - named where it is used

    with pytest.raises(KeyboardInterrupt):
        simulate_config(simulation(study=STUDY), tmp_path / "study", workers=2, progress=Stop())
    assert list(tmp_path.iterdir()) == []


def test_a_shading_map_file_is_stretched_over_the_mosaic(tmp_path: Path) -> None:
    corners = np.array([[0.2, 0.4], [0.6, 1.0]])
    np.save(tmp_path / "map.npy", corners)
    config = simulation(camera={"cfa": "mono", "prnu": 0.0}, lens={"shading": str(tmp_path / "map.npy")}, study=STUDY)
    shading = config.lens.map_for(config.sensor)
    assert shading[[0, 0, -1, -1], [0, -1, 0, -1]].tolist() == pytest.approx([0.2, 0.4, 0.6, 1.0], rel=1e-6)
    assert shading.mean() == pytest.approx(0.55, rel=1e-6)
    broken = simulation(lens={"shading": str(tmp_path / "missing.npy")}, study=STUDY)
    with pytest.raises(UsageError, match=r"missing\.npy"):
        broken.lens.map_for(broken.sensor)
