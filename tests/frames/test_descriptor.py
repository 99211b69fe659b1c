"""Descriptor files of the emva1288 package: what they say, and what is wrong in which line."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from fullwell.errors import UsageError
from fullwell.frames.descriptor import is_descriptor, parse_descriptor, read_descriptor
from fullwell.frames.selection import Selection
from fullwell.frames.series import Kind
from fullwell.frames.study import load_study
from fullwell.raw.open import decode
from fullwell.workflow.descriptor import export_descriptors

Write = Callable[..., Path]

EXAMPLE = """\
# plane G1, operation point 1
v 4.0
n 12 24 20
b 10000000 950,5
i img\\s00_a.png
i img\\s00_b.png
b 10000000 1901.0
i img/s01_a.png
i img/s01_b.png

d 10000000
i img\\dk_a.png
i img\\dk_b.png
b 10000000 7600.0
i img\\p50_000.png
i img\\p50_001.png
i img\\p50_002.png
   # a remark
d 10000000
i img\\d50_000.png
i img\\d50_001.png
i img\\d50_002.png
"""


@pytest.fixture
def write(tmp_path: Path) -> Write:
    """Return a function that writes a descriptor and the images it names."""

    def writer(text: str, *, size: tuple[int, int] = (24, 20), skip: str = "") -> Path:
        path = tmp_path / "campaign.txt"
        path.write_text(text, encoding="utf-8")
        rng = np.random.default_rng(0)
        for line in text.splitlines():
            if line.startswith("i ") and len(line.split()) == 2 and line.split()[1] != skip:
                image = tmp_path / line.split()[1].replace("\\", "/")
                image.parent.mkdir(exist_ok=True)
                Image.fromarray(rng.integers(0, 99, size[::-1]).astype(np.uint16)).save(image)
        return path

    return writer


def test_reads_pairs_and_stacks(write: Write) -> None:
    path = write(EXAMPLE)
    assert is_descriptor(path)
    study = load_study(path, Selection())
    found = [(one.kind, one.exposure_s, one.photons, one.stack, len(one.frames)) for one in study.series]
    assert found == [
        (Kind.DARK, 0.01, None, False, 2),
        (Kind.DARK, 0.01, None, True, 3),
        (Kind.FLAT, 0.01, 950.5, False, 2),
        (Kind.FLAT, 0.01, 1901.0, False, 2),
        (Kind.FLAT, 0.01, 7600.0, True, 3),
    ]
    assert (study.cfa, study.bit_depth, study.width, study.height, study.descriptor) == ("mono", 12, 24, 20, True)


def test_the_file_beside_it_tells_camera_and_light(write: Write) -> None:
    path = write(EXAMPLE)
    path.with_suffix(".json").write_text(
        '{"camera": {"pixel_pitch_um": 3.45}, "light": {"wavelength_nm": 528.0, "nominal": true}, "iso": 100.0}'
    )
    study = load_study(path, Selection())
    assert study.camera.area_um2 == pytest.approx(3.45**2)
    assert (study.light.wavelength_nm, study.light.nominal, study.isos) == (528.0, True, (100.0,))


def test_close_exposures_stay_apart(write: Write) -> None:
    lines = [f"{head}\ni {name}a.png\ni {name}b.png" for head, name in (("d 1000000", "x"), ("d 1001000", "y"))]
    study = load_study(write("\n".join(lines) + "\n"), Selection())
    assert [one.exposure_s for one in study.series] == [0.001, 0.001001]


@pytest.mark.parametrize(
    ("old", "new", "line", "reason"),
    [
        ("v 4.0", "v", 2, "should be"),
        ("n 12 24 20", "n 12 24", 3, '"n bits width height"'),
        ("n 12 24 20", "n twelve 24 20", 3, "whole numbers"),
        ("n 12 24 20", "n 20 24 20", 3, "1 to 16 bits"),
        ("v 4.0", "n 12 24 20", 3, "only one"),
        ("b 10000000 950,5", "b 10000000", 4, '"b exposure_ns photons"'),
        ("b 10000000 950,5", "b 1e7ns 950", 4, 'the exposure "1e7ns"'),
        ("b 10000000 950,5", "b 10000000 -5", 4, "number of photons"),
        ("b 10000000 950,5", "b 10000000 1901", 7, "stands in line 4"),
        ("b 10000000 950,5\ni img\\s00_a.png\n", "b 10000000 950,5\n", 4, "only one image follows"),
        ("b 10000000 950,5\n", "v 4.1\n", 5, "must follow"),
        ("i img\\s00_a.png", "i my img\\s00_a.png", 5, "blanks in paths"),
        ("i img\\s00_a.png", "i img\\s00_b.png", 6, "listed twice"),
        ("d 10000000\ni img\\d50", "d 20000000\ni img\\d50", 14, "no dark images"),
    ],
)
def test_says_what_is_wrong_in_which_line(write: Write, old: str, new: str, line: int, reason: str) -> None:
    path = write(EXAMPLE.replace(old, new, 1) if "d50" not in old else EXAMPLE.replace(old, new))
    with pytest.raises(UsageError, match=f"line {line}") as caught:
        read_descriptor(path)
    assert reason in str(caught.value)


@pytest.mark.parametrize("mark", ['"', "'"])
def test_quotation_marks_are_no_part_of_a_path(tmp_path: Path, mark: str) -> None:
    path = tmp_path / "campaign.txt"
    path.write_text(EXAMPLE.replace("i img\\s00_a.png", f"i {mark}img\\s00_a.png{mark}"))
    with pytest.raises(UsageError, match=r"line 5: .* stands in quotation marks"):
        read_descriptor(path)


def test_a_missing_image_is_named_with_its_line(write: Write) -> None:
    path = write(EXAMPLE, skip="img\\p50_001.png")
    with pytest.raises(UsageError, match=r"line 16: the image img/p50_001.png does not exist"):
        read_descriptor(path)


def test_an_image_of_another_size_is_named_with_its_line(write: Write) -> None:
    path = write(EXAMPLE, size=(25, 20))
    with pytest.raises(UsageError, match=r"line 5: .* has 25 x 20 pixels, the n line says 24 x 20"):
        read_descriptor(path)


def test_photons_must_rise_with_the_exposure(write: Write) -> None:
    blocks = [(1000, 50.0), (2000, 100.0), (3000, 90.0)]
    text = "".join(f"b {t} {p}\ni b{t}a.png\ni b{t}b.png\nd {t}\ni d{t}a.png\ni d{t}b.png\n" for t, p in blocks)
    with pytest.raises(UsageError, match=r"line 13: 90 photons at 3000 ns are not more than the 100"):
        read_descriptor(write(text))


def test_a_dark_that_is_missing_is_read_off_the_others_and_named(write: Write) -> None:
    text = "".join(f"b {t} {t}\ni b{t}a.png\ni b{t}b.png\n" for t in (1000, 2000, 3000))
    text += "".join(f"d {t}\ni d{t}a.png\ni d{t}b.png\n" for t in (1000, 3000))
    (finding,) = read_descriptor(write(text)).findings
    assert (finding.code, finding.severity) == ("descriptor-no-dark", "error")
    assert "line 4: there are no dark images (d 2000)" in finding.message
    with pytest.raises(UsageError, match="line 4"):
        read_descriptor(write(text.replace("d 3000\ni d3000a.png\ni d3000b.png\n", "")))


def test_unknown_letters_are_passed_over_and_told(write: Write) -> None:
    source = read_descriptor(write(EXAMPLE + "l name value\n"))
    assert [one.code for one in source.findings] == ["descriptor-line-unknown"]
    assert "line 23" in source.findings[0].message


def test_other_files_are_no_descriptors(tmp_path: Path) -> None:
    for name, content in (("a.txt", b"notes of today\n"), ("b.txt", b""), ("c.bin", bytes(range(256)))):
        (tmp_path / name).write_bytes(content)
        assert not is_descriptor(tmp_path / name)
    (tmp_path / "d.txt").write_text("v 4.0\n")
    with pytest.raises(UsageError, match="names no images"):
        parse_descriptor(tmp_path / "d.txt")


def test_a_byte_order_mark_is_passed_over(write: Write) -> None:
    path = write("\ufeff" + EXAMPLE.lstrip())
    assert is_descriptor(path)
    assert len(parse_descriptor(path).blocks) == len(parse_descriptor(write(EXAMPLE)).blocks)


def test_what_is_written_is_read_again(write: Write, tmp_path: Path) -> None:
    path = write(EXAMPLE)
    path.with_suffix(".json").write_text('{"camera": {"pixel_pitch_um": 3.45}, "light": {"wavelength_nm": 528.0}}')
    (name,) = export_descriptors(path, tmp_path / "out", selection=Selection())
    first, second = (load_study(one, Selection()) for one in (path, tmp_path / "out" / name))
    assert [one.key for one in first.series] == [one.key for one in second.series]
    assert (first.camera.area_um2, first.light, first.bit_depth) == (
        second.camera.area_um2,
        second.light,
        second.bit_depth,
    )
    for one, other in zip(first.series, second.series, strict=True):
        for frame, copy in zip(one.frames, other.frames, strict=True):
            mosaics = [decode(each.header, each.header.path.read_bytes()) for each in (frame, copy)]
            assert np.array_equal(*mosaics)
            assert np.array_equal(np.asarray(Image.open(copy.header.path)), mosaics[0])


def test_each_site_of_a_mosaic_has_a_descriptor_of_its_own(write: Write, tmp_path: Path) -> None:
    path = write(EXAMPLE)
    names = export_descriptors(path, tmp_path / "out", selection=Selection(cfa="RGGB"))
    assert names == ("R.txt", "G1.txt", "G2.txt", "B.txt")
    study = load_study(tmp_path / "out" / "G2.txt", Selection())
    assert (study.width, study.height, study.cfa) == (12, 10, "mono")
    whole = load_study(path, Selection())
    original, plane = (
        decode(one.header, one.header.path.read_bytes())
        for one in (
            whole.series[0].frames[0],
            study.series[0].frames[0],
        )
    )
    assert np.array_equal(plane, original[1::2, 0::2])


def test_without_photons_nothing_is_written(tmp_path: Path) -> None:
    for kind in ("flat", "dark"):
        (tmp_path / "study" / kind).mkdir(parents=True)
        for number in range(2):
            image = np.full((20, 24), 100 + number, np.uint16)
            Image.fromarray(image).save(tmp_path / "study" / kind / f"exp100us_{number}.png")
    with pytest.raises(UsageError, match="photons of the flats"):
        export_descriptors(tmp_path / "study", tmp_path / "out", selection=Selection(cfa="mono"))
    assert not (tmp_path / "out").exists()
