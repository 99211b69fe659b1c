"""study.toml: what is read, what is refused with which sentence, and that what is written reads back."""

from collections.abc import Callable
from pathlib import Path

import pytest

from fullwell.errors import UsageError
from fullwell.frames.manifest import read_manifest, write_manifest
from fullwell.frames.selection import Selection
from fullwell.frames.series import Kind, Study
from fullwell.frames.study import index_folder, load_study

MakeFrame = Callable[..., Path]
_ONE = '[[series]]\nkind = "flat"\nfiles = ["a.tif"]\n'


def written(folder: Path, text: str) -> Path:
    path = folder / "study.toml"
    path.write_text(text, encoding="utf-8")
    return path


def essence(study: Study) -> object:
    return [(one.kind, one.iso, one.exposure_s, [frame.name for frame in one.frames]) for one in study.series]


def test_a_manifest_outranks_names_and_metadata(tmp_path: Path, make_dng: MakeFrame) -> None:
    make_dng(tmp_path / "dark" / "a [1].dng")
    make_dng(tmp_path / "dark" / "b.dng")
    path = written(
        tmp_path,
        '[camera]\nname = "X"\ncfa = "GBRG"\nblack_level = [1, 2, 3, 4]\nwhite_level = 1000\n'
        '[[series]]\nkind = "flat"\nfiles = ["dark/a [1].dng", "dark/b*"]\n'
        "exposure_s = 2\niso = 400\nphotons = 12.5\ntemperature_c = -5\n",
    )
    study = load_study(path, Selection())
    (series,) = study.series
    assert (series.kind, series.iso, series.exposure_s, series.photons) == (Kind.FLAT, 400.0, 2.0, 12.5)
    assert (series.temperature_c, study.cfa, study.camera.name) == (-5.0, "GBRG", "X")
    assert study.black_level is not None
    assert study.white_level is not None
    assert (study.black_level.values, study.black_level.source) == ((1.0, 2.0, 3.0, 4.0), "manifest")
    assert (study.white_level.values, study.white_level.source) == ((1000.0,) * 4, "manifest")
    assert [frame.name for frame in series.frames] == ["dark/a [1].dng", "dark/b.dng"]


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("[camera]\n", ["series is missing"]),
        ('[[series]]\nkind = "flats"\nfiles = ["a.tif"]\n', ["series[1].kind", '"flats"', "'flat'", "'dark'"]),
        ('[[series]]\nkind = "flat"\nfiles = ["a.tif"]\nexposure = 1\n', ["series[1].exposure", "exposure_s"]),
        ('[[series]]\nkind = "flat"\nfiles = ["a.tif"]\niso = "100"\n', ["series[1].iso", '"100"', "number"]),
        ('[[series]]\nkind = "flat"\nfiles = ["a.tif"]\nexposure_s = -1\n', ["exposure_s", "-1", "greater than 0"]),
        ('[[series]]\nkind = "flat"\nfiles = ["none*.tif"]\n', ["series[1].files", "none*.tif", "no file"]),
        ('[[series]]\nkind = "flat"\nfiles = ["/a.tif"]\n', ["relative"]),
        ('[camera]\ncfa = "RGBG"\n[[series]]\nkind = "flat"\nfiles = ["a.tif"]\n', ["camera.cfa", "RGGB", "mono"]),
        ('[camera]\niso = 5\n[[series]]\nkind = "flat"\nfiles = ["a.tif"]\n', ["camera.iso", "base_iso"]),
        ('[[serie]]\nkind = "flat"\n', ["serie", "[[series]]"]),
        (f'[camera]\nblack_level = [1, "x"]\n{_ONE}', ["camera.black_level[2]", '"x"', "should be a number"]),
        (f"[camera]\nblack_level = []\n{_ONE}", ["camera.black_level = []", "at least 1 item"]),
        (f"[camera]\nblack_level = -1\n{_ONE}", ["camera.black_level = -1", "greater than or equal to 0"]),
        (f"[camera]\nblack_level = nan\n{_ONE}", ["camera.black_level = nan"]),
        (f"[camera]\nwhite_level = inf\n{_ONE}", ["camera.white_level = inf", "less than or equal to 65535"]),
        (
            '[[series]]\nkind = "flat"\nfiles = []\n',
            ["series[1].files = [] is not allowed: it should have at least 1 item."],
        ),
        ("[camera]\nbit_depth = 8.5\n" + _ONE, ["camera.bit_depth = 8.5 is not allowed: it should be an integer."]),
        ('[[series]]\nkind = "dark"\nfiles = ["a.tif"]\nphotons = 9.0\n', ["series[1] is dark", "no light"]),
        ('[[series]]\nkind = "bias"\nfiles = ["a.tif"]\nirradiance_uw_cm2 = 1.0\n', ["series[1] is bias", "no light"]),
        ("[camera\n", ["TOML"]),
    ],
)
def test_a_refusal_names_key_value_and_what_is_allowed(
    tmp_path: Path, make_tiff: MakeFrame, text: str, words: list[str]
) -> None:
    make_tiff(tmp_path / "a.tif")
    path = written(tmp_path, text)
    with pytest.raises(UsageError) as caught:
        read_manifest(path)
    for word in (*words, str(path)):
        assert word in str(caught.value)


def test_a_level_that_is_no_number_is_refused_in_one_sentence(tmp_path: Path) -> None:
    path = written(tmp_path, f'[camera]\nblack_level = "x"\n{_ONE}')
    with pytest.raises(UsageError) as caught:
        read_manifest(path)
    assert str(caught.value) == f'{path}: camera.black_level = "x" is not allowed: it should be a number.'


def test_a_mark_of_byte_order_is_no_part_of_it(tmp_path: Path, make_tiff: MakeFrame) -> None:
    make_tiff(tmp_path / "a.tif")
    path = written(tmp_path, "\ufeff" + _ONE)
    assert len(read_manifest(path).candidates) == 1


def test_a_file_belongs_to_one_series(tmp_path: Path, make_tiff: MakeFrame) -> None:
    make_tiff(tmp_path / "a.tif")
    entry = '[[series]]\nkind = "{}"\nfiles = ["a.tif"]\n'
    with pytest.raises(UsageError, match=r"a\.tif is listed in series\[1\] and in series\[2\]"):
        read_manifest(written(tmp_path, entry.format("flat") + entry.format("dark")))


def test_flats_of_different_photons_are_series_of_their_own(tmp_path: Path, make_dng: MakeFrame) -> None:
    make_dng(tmp_path / "a.dng")
    make_dng(tmp_path / "b.dng")
    entry = '[[series]]\nkind = "flat"\nfiles = ["{}.dng"]\nphotons = {}\n'
    study = load_study(written(tmp_path, entry.format("a", 1) + entry.format("b", 2)), Selection())
    assert [series.photons for series in study.series] == [1.0, 2.0]


def test_irradiance_gives_photons_by_the_time_of_light(tmp_path: Path, make_dng: MakeFrame) -> None:
    for name in "abc":
        make_dng(tmp_path / f"{name}.dng")
    head = "[camera]\npixel_area_um2 = 11.9\n[light]\nwavelength_nm = 530.0\nirradiance_uw_cm2 = 1.5\n"
    entry = '[[series]]\nkind = "flat"\nfiles = ["{}.dng"]\nexposure_s = {}\n'
    series = entry.format("a", 0.002) + entry.format("b", 0.004) + "pulse_s = 0.001\n"
    series += entry.format("c", 0.004) + "irradiance_uw_cm2 = 3.0\n"
    study = load_study(written(tmp_path, head + series), Selection())
    photons = [one.photons for one in study.series]
    assert photons == pytest.approx([952.504426727, 952.504426727 / 2, 4 * 952.504426727], rel=1e-9)


def test_an_untouched_manifest_measures_the_same_frames_as_its_folder(tmp_path: Path, make_dng: MakeFrame) -> None:
    for iso in (55, 99):
        for us in (10_000, 20_000):
            for n in range(3):
                make_dng(tmp_path / f"PRNU_DSNU/ISO_{iso}/IMG_{us}_{n}.dng", iso=iso, exposure_us=us)
    make_dng(tmp_path / "ReadNoise/one.dng", iso=55, exposure_us=None)
    (tmp_path / "ReadNoise" / "fake.dng").write_text("no raw file", encoding="utf-8")
    folder = index_folder(tmp_path, Selection())
    text = write_manifest(folder)
    assert 'files = ["PRNU_DSNU/ISO_55/IMG_10000_*.dng"]' in text
    assert "# ReadNoise/fake.dng:" in text
    again = load_study(written(tmp_path, text), Selection())
    assert essence(again) == essence(folder)
    assert (again.black_level, again.white_level, again.cfa) == (folder.black_level, folder.white_level, folder.cfa)


def test_a_pattern_never_takes_in_a_frame_of_another_series(tmp_path: Path, make_dng: MakeFrame) -> None:
    for n in range(4):
        make_dng(tmp_path / f"flat/IMG_{n}.dng", exposure_us=1000 * (1 + n % 2))
    folder = index_folder(tmp_path, Selection())
    assert essence(load_study(written(tmp_path, write_manifest(folder)), Selection())) == essence(folder)


def test_a_manifest_may_stand_elsewhere(tmp_path: Path, make_dng: MakeFrame) -> None:
    make_dng(tmp_path / "study" / "flat" / "a.dng")
    make_dng(tmp_path / "study" / "flat" / "b.dng")
    elsewhere = tmp_path / "manifests"
    elsewhere.mkdir()
    text = write_manifest(index_folder(tmp_path / "study", Selection()), folder=elsewhere)
    study = load_study(written(elsewhere, text), Selection())
    assert [frame.name for frame in study.series[0].frames] == ["../study/flat/a.dng", "../study/flat/b.dng"]
