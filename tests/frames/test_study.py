"""A folder becomes a study: every rule of RESULTS 1, and nothing lost without a word."""

import os
import sys
from collections.abc import Callable, Sequence
from pathlib import Path
from random import Random

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from fullwell.errors import UsageError
from fullwell.findings import Severity
from fullwell.frames.selection import Selection
from fullwell.frames.series import Camera, Kind, Study
from fullwell.frames.study import load_study

MakeFrame = Callable[..., Path]
Shared = Callable[[str], Path]


def load(path: Path) -> Study:
    return load_study(path, Selection())


def frames_of(study: Study) -> list[tuple[str, float | None, float | None, tuple[str, ...]]]:
    return [
        (one.kind.value, one.iso, one.exposure_s, tuple(frame.name for frame in one.frames)) for one in study.series
    ]


def codes(study: Study, severity: Severity | None = None) -> set[str]:
    return {one.code for one in study.findings if severity in {None, one.severity}}


def test_metadata_names_and_sidecars_in_this_order(tmp_path: Path, make_dng: MakeFrame) -> None:
    make_dng(tmp_path / "flat/ISO_800/exp5s_0.dng", iso=100, exposure_us=2000)
    make_dng(tmp_path / "flat/ISO_800/exp5s_1.dng", iso=None, exposure_us=None)
    sidecar = {"ExposureTime": 7e6, "DeviceTemperature": 21.5}
    make_dng(tmp_path / "flat/ISO_800/exp6s_2.dng", iso=None, exposure_us=None)
    (tmp_path / "flat/ISO_800/exp6s_2.json").write_text(str(sidecar).replace("'", '"'), encoding="utf-8")
    make_dng(tmp_path / "flat/ISO_800/plain.dng", iso=None, exposure_us=None)
    (tmp_path / "flat/ISO_800/plain.json").write_text(str(sidecar).replace("'", '"'), encoding="utf-8")
    series = load(tmp_path).series
    assert [(one.iso, one.exposure_s, one.temperature_c) for one in series] == [
        (100.0, 0.002, None),
        (800.0, 5.0, None),
        (800.0, 6.0, 21.5),
        (800.0, 7.0, 21.5),
    ]


def test_a_disagreement_of_name_and_sidecar_is_said(tmp_path: Path, make_tiff: MakeFrame) -> None:
    make_tiff(tmp_path / "flat/exp1000us_0.tif", sidecar={"PixelFormat": "Mono12", "ExposureTime": 1004.0})
    make_tiff(tmp_path / "flat/exp1000us_1.tif", sidecar={"PixelFormat": "Mono12", "ExposureTime": 1006.0})
    (finding,) = [one for one in load(tmp_path).findings if one.code == "exposure-ambiguous"]
    assert finding.files == ("flat/exp1000us_1.tif",)
    assert finding.severity is Severity.WARNING


def test_exposures_within_half_a_percent_are_one_series(tmp_path: Path, make_dng: MakeFrame) -> None:
    for n, us in enumerate((10_000, 10_040, 10_100, 20_000)):
        make_dng(tmp_path / f"dark/{n}.dng", exposure_us=us)
    assert frames_of(load(tmp_path)) == [
        ("dark", 100.0, (0.01 + 0.01004) / 2, ("dark/0.dng", "dark/1.dng")),
        ("dark", 100.0, 0.0101, ("dark/2.dng",)),
        ("dark", 100.0, 0.02, ("dark/3.dng",)),
    ]


def test_an_exposure_nobody_knows_is_an_error_for_flat_and_dark_only(tmp_path: Path, make_dng: MakeFrame) -> None:
    for folder in ("flat", "dark", "bias", "scene"):
        make_dng(tmp_path / folder / "a.dng", exposure_us=None)
    study = load(tmp_path)
    assert {one.name for one in study.excluded} == {"flat/a.dng", "dark/a.dng"}
    assert {one.code for one in study.excluded} == {"exposure-unknown"} == codes(study, Severity.ERROR)
    assert [(one.kind, one.exposure_s) for one in study.series] == [(Kind.BIAS, None), (Kind.SCENE, None)]


def test_a_frame_without_iso_stands_apart_where_others_have_one(tmp_path: Path, make_dng: MakeFrame) -> None:
    make_dng(tmp_path / "flat/a.dng", iso=None)
    make_dng(tmp_path / "flat/b.dng", iso=None)
    assert (load(tmp_path).isos, codes(load(tmp_path))) == ((None,), set())
    make_dng(tmp_path / "flat/c.dng", iso=100)
    make_dng(tmp_path / "flat/d.dng", iso=100)
    study = load(tmp_path)
    assert study.isos == (None, 100.0)
    assert codes(study, Severity.WARNING) == {"iso-unknown"}


def test_damaged_and_foreign_frames_are_named_and_nothing_else_changes(
    tmp_path: Path, make_dng: MakeFrame, shared_data: Shared
) -> None:
    for n in range(4):
        make_dng(tmp_path / f"flat/{n}.dng")
    before = load(tmp_path)
    (tmp_path / "flat/text.dng").write_text("this is no raw file", encoding="utf-8")
    (tmp_path / "flat/empty.dng").write_bytes(b"")
    whole = (tmp_path / "flat/0.dng").read_bytes()
    (tmp_path / "flat/cut.dng").write_bytes(whole[: len(whole) // 2])
    make_dng(tmp_path / "flat/large.dng", height=10)
    make_dng(tmp_path / "flat/turned.dng", cfa="BGGR")
    make_dng(tmp_path / "flat/deep.dng", white=16383)
    (tmp_path / "flat/lossy.dng").symlink_to(shared_data("lossy-6d/canon_eos_6d.dng"))
    study = load(tmp_path)
    assert frames_of(study) == frames_of(before)
    assert (study.black_level, study.white_level) == (before.black_level, before.white_level)
    reasons = {one.name: one.code for one in study.excluded}
    assert set(reasons) == {f"flat/{name}.dng" for name in ("text", "empty", "cut", "large", "turned", "deep", "lossy")}
    assert reasons["flat/large.dng"] == "frame-size-differs"
    assert reasons["flat/turned.dng"] == "cfa-differs"
    assert reasons["flat/deep.dng"] == "bit-depth-differs"
    errors = [one for one in study.findings if one.severity is Severity.ERROR]
    assert {name for one in errors for name in one.files} == set(reasons)
    for name in reasons:
        assert any(name in one.message for one in errors)


def test_other_folders_are_left_out_and_named(tmp_path: Path, make_dng: MakeFrame) -> None:
    make_dng(tmp_path / "session/dark/deep/er/a.dng")
    make_dng(tmp_path / "session/dark/deep/er/b.dng")
    make_dng(tmp_path / "session/odd/deep/c.dng")
    make_dng(tmp_path / "notes/x/c.dng")
    make_dng(tmp_path / ".hidden/flat/c.dng")
    make_dng(tmp_path / "session/dark/.c.dng")
    make_dng(tmp_path / "loose.dng")
    (tmp_path / "out").mkdir()
    (tmp_path / "out/results.json").write_text("{}", encoding="utf-8")
    (tmp_path / "inputs").mkdir()  # of a simulation, with what it was made from
    (tmp_path / "inputs/map.npy").touch()
    (tmp_path / "truth.json").touch()
    study = load(tmp_path)
    assert [frame.name for one in study.series for frame in one.frames] == [
        "session/dark/deep/er/a.dng",
        "session/dark/deep/er/b.dng",
    ]
    said = {one.code: one for one in study.findings}
    assert said["folders-left-out"].files == ("notes", "session/odd")
    assert said["folders-left-out"].severity is Severity.INFO
    assert said["files-left-out"].files == ("loose.dng",)
    assert study.excluded == ()


def test_frames_kept_among_results_are_no_frames_of_the_study(tmp_path: Path, make_dng: MakeFrame) -> None:
    """A loop keeps simulated frames there; results of other programs are nobody's sign."""
    for folder in ("flat", "loop/study/flat", "other/flat", "flat/results"):
        make_dng(tmp_path / folder / "a.dng")
    for folder, schema in (("loop", "fullwell-results/1"), ("flat/results", "fullwell-results/1"), ("other", "x/1")):
        (tmp_path / folder / "results.json").write_text(f'{{"schema": "{schema}"}}', encoding="utf-8")
    study = load(tmp_path)
    assert [frame.name for one in study.series for frame in one.frames] == ["flat/a.dng", "other/flat/a.dng"]
    assert study.findings == ()
    assert len(load(tmp_path / "loop").series[0].frames) == 1


@pytest.mark.skipif(sys.platform != "linux", reason="names are text there")
def test_a_name_that_is_no_text_is_left_out_and_told(tmp_path: Path, make_dng: MakeFrame) -> None:
    for name in ("flat/a ü\n.dng", os.fsdecode(b"flat/b\xff.dng"), os.fsdecode(b"flat/\xfe/c.dng")):
        make_dng(tmp_path / name)
    (tmp_path / "flat" / os.fsdecode(b"\xff.xyz")).touch()
    (tmp_path / os.fsdecode(b"\xff")).mkdir()
    study = load(tmp_path)
    assert [frame.name for one in study.series for frame in one.frames] == ["flat/a ü\n.dng"]
    found = {one.code: one for one in study.findings}
    assert found["files-unknown"].files == ("flat/\\udcff.xyz",)
    assert found["folders-left-out"].files == ("\\udcff",)
    said = found["name-no-text"]
    assert said.severity is Severity.ERROR
    assert said.files == ("flat/\\udcfe/c.dng", "flat/b\\udcff.dng")
    assert all(name in said.message for name in said.files)


def test_companions_are_passed_over_in_silence(tmp_path: Path, make_dng: MakeFrame) -> None:
    for n in range(2):
        make_dng(tmp_path / f"flat/{n}.dng")
        for companion in (".jpg", ".JPG", ".json", ".txt", ".xmp", ".png"):
            (tmp_path / f"flat/{n}{companion}").write_text("{}", encoding="utf-8")
    assert load(tmp_path).findings == ()


@pytest.mark.parametrize(
    ("files", "word"),
    [
        ((), "is empty"),
        (("flat/a.jpg", "dark/b.jpeg"), "JPEG"),
        (("flat/a.txt",), "no raw frames"),
        (("stuff/a.dng",), "no folder that says"),
        (("flat/a.dng", "flat/b.dng"), "None of the 2 raw files"),
    ],
)
def test_a_folder_with_nothing_to_measure_says_what_to_do(tmp_path: Path, files: Sequence[str], word: str) -> None:
    for name in files:
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).write_text("x", encoding="utf-8")
    with pytest.raises(UsageError, match=word):
        load(tmp_path)


def test_a_missing_path_and_a_single_file(tmp_path: Path, make_dng: MakeFrame) -> None:
    with pytest.raises(UsageError, match="does not exist"):
        load(tmp_path / "none")
    with pytest.raises(UsageError, match="fullwell inspect"):
        load(make_dng(tmp_path / "flat/a.dng"))


def test_the_cfa_is_asked_for_where_nobody_says_it(tmp_path: Path, make_tiff: MakeFrame) -> None:
    make_tiff(tmp_path / "flat/exp1ms_0.tif")
    with pytest.raises(UsageError, match="--cfa"):
        load(tmp_path)
    study = load_study(tmp_path, Selection(cfa="GRBG"))
    assert (study.cfa, study.series[0].frames[0].header.cfa) == ("GRBG", "GRBG")
    assert (study.bit_depth, study.white_level, study.black_level) == (16, None, None)


@pytest.mark.parametrize(("text", "cfa"), [("Mono12", "mono"), ("BayerRG12", "RGGB"), ("BayerBG10p", "BGGR")])
def test_the_cfa_and_depth_of_a_sidecar(tmp_path: Path, make_tiff: MakeFrame, text: str, cfa: str) -> None:
    make_tiff(tmp_path / "flat/exp1ms_0.tif", sidecar={"PixelFormat": text, "BlackLevel": 10})
    study = load(tmp_path)
    depth = int("".join(letter for letter in text if letter.isdigit()))
    sites = 1 if cfa == "mono" else 4
    assert (study.cfa, study.bit_depth) == (cfa, depth)
    assert study.black_level is not None
    assert study.white_level is not None
    assert (study.black_level.values, study.black_level.source) == ((10.0,) * sites, "sidecar")
    assert (study.white_level.values, study.white_level.source) == ((2.0**depth - 1,) * sites, "default")


def test_the_user_outranks_the_files(tmp_path: Path, make_dng: MakeFrame) -> None:
    make_dng(tmp_path / "flat/a.dng")
    make_dng(tmp_path / "flat/b.dng")
    study = load_study(
        tmp_path,
        Selection(cfa="BGGR", black_level=(60.0,), white_level=1000.0, camera=Camera(name="Mine", white_level=5.0)),
    )
    assert study.black_level is not None
    assert study.white_level is not None
    assert (study.black_level.values, study.black_level.source) == ((60.0,) * 4, "user")
    assert (study.white_level.values, study.white_level.source) == ((1000.0,) * 4, "user")
    assert (study.cfa, study.camera.name) == ("BGGR", "Mine")
    assert codes(study) == {"cfa-overridden"}


@pytest.mark.parametrize(("black", "white"), [((1.0, 2.0), 9.0), ((1.0, 2.0, 3.0), 9.0), ((10.0,), 9.0)])
def test_levels_that_cannot_be(tmp_path: Path, make_dng: MakeFrame, black: tuple[float, ...], white: float) -> None:
    make_dng(tmp_path / "flat/a.dng")
    with pytest.raises(UsageError, match="--black"):
        load_study(tmp_path, Selection(black_level=black, white_level=white))


def test_selections(tmp_path: Path, make_dng: MakeFrame) -> None:
    for kind in ("flat", "dark"):
        for iso in (100, 200):
            for us in (1000, 2000):
                make_dng(tmp_path / f"{kind}/{iso}_{us}.dng", iso=iso, exposure_us=us)
    study = load_study(tmp_path, Selection(isos=(200.0,), exposures_s=(0.001001,), kinds=(Kind.FLAT,)))
    assert frames_of(study) == [("flat", 200.0, 0.001, ("flat/200_1000.dng",))]
    with pytest.raises(UsageError, match=r"ISO 100 200 and exposures 0\.001 0\.002"):
        load_study(tmp_path, Selection(isos=(300.0,)))
    with pytest.raises(UsageError, match="--only"):
        load_study(tmp_path, Selection(kinds=(Kind.CHART,)))


def test_checks_that_warn(tmp_path: Path, make_tiff: MakeFrame) -> None:
    for n, temperature in enumerate((20.0, 22.5)):
        sidecar = {"PixelFormat": "Mono12", "DeviceTemperature": temperature, "BlackLevel": 10 + n}
        make_tiff(tmp_path / f"dark/exp{n + 1}ms.tif", sidecar=sidecar)
    assert codes(load(tmp_path), Severity.WARNING) == {
        "temperature-spread",
        "single-frame-series",
        "black-level-varies",
    }


def test_a_damaged_sidecar_warns(tmp_path: Path, make_dng: MakeFrame) -> None:
    for n in range(2):
        make_dng(tmp_path / f"flat/{n}.dng")
        (tmp_path / f"flat/{n}.json").write_text("{", encoding="utf-8")
    (finding,) = load(tmp_path).findings
    assert (finding.code, finding.files) == ("sidecar-unreadable", ("flat/0.dng", "flat/1.dng"))


def test_link_loops_end_and_a_linked_frame_counts_once_per_kind(tmp_path: Path, make_dng: MakeFrame) -> None:
    for n in range(2):
        make_dng(tmp_path / f"dark/{n}.dng")
    (tmp_path / "dark/again").symlink_to(tmp_path / "dark", target_is_directory=True)
    (tmp_path / "dark/root").symlink_to(tmp_path, target_is_directory=True)
    (tmp_path / "loop").symlink_to(tmp_path, target_is_directory=True)
    (tmp_path / "dark/2.dng").symlink_to(tmp_path / "dark/0.dng")
    (tmp_path / "bias").mkdir()
    (tmp_path / "bias/0.dng").symlink_to(tmp_path / "dark/0.dng")
    study = load(tmp_path)
    assert frames_of(study) == [
        ("bias", 100.0, 0.01, ("bias/0.dng",)),
        ("dark", 100.0, 0.01, ("dark/0.dng", "dark/1.dng")),
    ]
    assert "files-twice" in codes(study, Severity.INFO)


@settings(max_examples=15, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(st.randoms(use_true_random=False))
def test_the_file_systems_order_never_matters(
    tmp_path: Path, make_dng: MakeFrame, monkeypatch: pytest.MonkeyPatch, random: Random
) -> None:
    if not (tmp_path / "flat").exists():
        for n in range(6):
            make_dng(tmp_path / f"flat/{n % 2}/{n}.dng", exposure_us=10_000 + 7 * n, black=64 + n % 2)
            make_dng(tmp_path / f"dark/{n}.dng", height=8 + 2 * (n % 2))
        (tmp_path / "dark/bad.dng").write_text("no", encoding="utf-8")
    expected = load(tmp_path)
    scan = os.scandir

    class Shuffled:
        def __init__(self, folder: str | Path) -> None:
            with scan(folder) as entries:
                self.entries = list(entries)
            random.shuffle(self.entries)

        def __enter__(self) -> Sequence[os.DirEntry[str]]:
            return self.entries

        def __exit__(self, *_nothing: object) -> None:
            pass

    with monkeypatch.context() as patch:
        patch.setattr("os.scandir", Shuffled)
        assert load(tmp_path) == expected


def test_imx541_through_its_folder(shared_data: Shared) -> None:
    study = load(shared_data("imx541"))
    exposures = {
        kind: [round(one.exposure_s * 1e6) for one in study.select(kind, iso=None) if one.exposure_s]
        for kind in (Kind.FLAT, Kind.DARK)
    }
    assert exposures[Kind.FLAT] == [25, 81, 272, 985, 1757, 2867, 5240, 6443]
    assert exposures[Kind.DARK] == [25, 2867, 6443]
    assert [len(one.frames) for one in study.series] == [2, 8, 2, 2, 2, 2, 2, 2, 8, 2, 2]
    assert (study.width, study.height, study.cfa, study.bit_depth) == (1128, 1128, "mono", 12)
    assert study.black_level is not None
    assert study.white_level is not None
    assert (study.black_level.values, study.black_level.source) == ((10.0,), "sidecar")
    assert study.white_level.values == (4095.0,)
    assert study.excluded == ()
