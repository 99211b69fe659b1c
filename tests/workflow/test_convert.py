"""What is converted reads back with equal mosaic, levels and CFA, by LibRaw and by Fullwell; what is lost is said."""

import os
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
import tifffile
from astropy.io import fits
from PIL import Image

from fullwell.errors import UsageError
from fullwell.frames.headerless import read_stated
from fullwell.frames.selection import Selection
from fullwell.raw.cfa import BAYER, MONO
from fullwell.raw.headerless_format import parse_format
from fullwell.raw.image import Area, ColourMatrix, RawHeader
from fullwell.raw.opcodes import mosaic_gain_maps
from fullwell.raw.open import decode, read_header, read_raw
from fullwell.raw.write import DngExtras, write_dng
from fullwell.workflow.convert.convert import ConvertOutcome, convert
from fullwell.workflow.convert.settings import Conversion
from fullwell.workflow.options import Options
from libraw_oracle import read_with_libraw

Shared = Callable[[str], Path]
PLAIN = Conversion()


def codes(height: int, width: int, *, bits: int, seed: int = 1) -> np.ndarray:
    mosaic = np.random.default_rng(seed).integers(0, 1 << bits, (height, width), dtype=np.uint16)
    mosaic[0, :2] = 0, (1 << bits) - 1
    return mosaic


def run(paths: Path | list[Path], out: Path, conversion: Conversion = PLAIN, **given: object) -> ConvertOutcome:
    options = Options(selection=Selection(**given), workers=2)
    return convert(paths if isinstance(paths, list) else [paths], out, options=options, conversion=conversion)


def told(outcome: ConvertOutcome) -> set[str]:
    return {one.code for one in outcome.findings}


def levels(header: RawHeader) -> tuple[object, ...]:
    return header.black_level and header.black_level.values, header.white_level and header.white_level.values


@pytest.mark.parametrize("compression", ["none", "lossless-jpeg"])
@pytest.mark.parametrize("bits", range(8, 17))
@pytest.mark.parametrize("cfa", [*BAYER, MONO])
def test_a_dng_comes_out_as_it_went_in(tmp_path: Path, cfa: str, bits: int, compression: str) -> None:
    mosaic = codes(61, 87, bits=bits)
    black = (9.0,) if cfa == MONO else (9.0, 10.0, 11.0, 12.0)
    extras = DngExtras(
        active_area=Area(4, 6, 61, 85),
        masked_areas=(Area(4, 0, 61, 6),),
        noise_profile=((1e-5, 2e-8),),
        orientation=6,
        temperature_c=-12.5,
        as_shot_neutral=() if cfa == MONO else (0.5, 1.0, 0.75),
        colour_matrix=None if cfa == MONO else ColourMatrix((1.0, 0.25, 0.0, 0.0, 1.0, 0.0, 0.0, 0.125, 1.0), 17),
    )
    options = {"bit_depth": bits, "iso": 320, "exposure_s": 1 / 128, "make": "Ours", "model": "A", "extras": extras}
    white = (1 << bits) - 5
    write_dng(tmp_path / "in.dng", mosaic, cfa=cfa, black_level=black, white_level=white, **options)
    outcome = run(tmp_path / "in.dng", tmp_path / "out.dng", Conversion(compression=compression))
    before, after = read_raw(tmp_path / "in.dng"), read_raw(tmp_path / "out.dng")
    np.testing.assert_array_equal(after.mosaic, before.mosaic)
    for name in ("cfa", "black_level", "white_level", "iso", "exposure_s", "temperature_c", "orientation", "make"):
        assert getattr(after.header, name) == getattr(before.header, name)
    for name in ("active_area", "masked_areas", "noise_profile", "as_shot_neutral", "colour_matrix", "model"):
        assert getattr(after.header, name) == getattr(before.header, name)
    whole = Area(0, 0, 61, 87)
    stored = decode(RawHeader(**fields(after.header, active_area=whole)), (tmp_path / "out.dng").read_bytes())
    np.testing.assert_array_equal(stored, mosaic)
    theirs, original = read_with_libraw(tmp_path / "out.dng"), read_with_libraw(tmp_path / "in.dng")
    np.testing.assert_array_equal(theirs.mosaic, mosaic[4:61, 6:85])
    assert (theirs.cfa, theirs.white_level, theirs.black_level) == (cfa, white, original.black_level)
    assert outcome.findings == ()


def fields(header: RawHeader, **changes: object) -> dict[str, object]:
    return {name: getattr(header, name) for name in header.__slots__} | changes


@pytest.mark.parametrize("cfa", BAYER)
@pytest.mark.parametrize("origin", [(0, 1), (1, 0), (3, 5)])
def test_an_odd_margin_loses_a_line_so_that_libraw_reads_levels_and_cfa(
    tmp_path: Path, cfa: str, origin: tuple[int, int]
) -> None:
    mosaic = codes(60, 80, bits=12)
    extras = DngExtras(active_area=Area(*origin, 55, 73))
    write_dng(
        tmp_path / "in.dng", mosaic, cfa=cfa, black_level=(1, 2, 3, 4), white_level=4000, bit_depth=12, extras=extras
    )
    assert told(run(tmp_path / "in.dng", tmp_path / "out.dng")) == {"margin-trimmed"}
    ours, theirs = read_raw(tmp_path / "out.dng"), read_with_libraw(tmp_path / "out.dng")
    visible = mosaic[origin[0] : 55, origin[1] : 73]
    np.testing.assert_array_equal(ours.mosaic, visible)
    np.testing.assert_array_equal(theirs.mosaic, visible)
    assert (theirs.cfa, theirs.black_level, theirs.white_level) == (cfa, (1.0, 2.0, 3.0, 4.0), 4000.0)
    assert (ours.header.raw_height, ours.header.raw_width) == (60 - origin[0] % 2, 80 - origin[1] % 2)


def sources(folder: Path, mosaic: np.ndarray) -> dict[str, Path]:
    """Write a mosaic of 12 bits in every format that has no levels."""
    paths = {name: folder / f"{name}.{name}" for name in ("tif", "png", "pgm", "npy", "fits", "bin")}
    tifffile.imwrite(paths["tif"], mosaic, photometric="minisblack", metadata=None)
    Image.fromarray(mosaic).save(paths["png"])
    np.save(paths["npy"], mosaic)
    height, width = mosaic.shape
    paths["pgm"].write_bytes(f"P5\n{width} {height}\n4095\n".encode() + mosaic.astype(">u2").tobytes())
    card = fits.PrimaryHDU(mosaic)
    card.header["EXPTIME"] = 0.125
    card.writeto(paths["fits"])
    paths["bin"].write_bytes(mosaic.astype("<u2").tobytes())
    return paths


@pytest.mark.parametrize("ending", ["dng", "tiff"])
@pytest.mark.parametrize("shape", [(31, 47), (32, 46)])
@pytest.mark.parametrize("cfa", ["GBRG", MONO])
def test_every_format_becomes_dng_and_tiff(tmp_path: Path, cfa: str, shape: tuple[int, int], ending: str) -> None:
    mosaic = codes(*shape, bits=12)
    black = (7.0,) if cfa == MONO else (7.0, 8.0, 9.0, 10.5)
    for name, path in sources(tmp_path, mosaic).items():
        out = tmp_path / f"{name}-out.{ending}"
        stated = parse_format(f"width={shape[1]},height={shape[0]},bits=12")
        run(path, out, cfa=cfa, black_level=black, white_level=4000.0, headerless=stated)
        header = read_stated(out, headerless=None)
        np.testing.assert_array_equal(decode(header, out.read_bytes()), mosaic)
        assert (header.cfa, *levels(header)) == (cfa, black, (4000.0,) * len(black))
        assert header.exposure_s == (0.125 if name == "fits" else None)
        if ending == "dng":
            theirs = read_with_libraw(out)
            np.testing.assert_array_equal(theirs.mosaic, mosaic)
            assert (theirs.cfa, theirs.white_level) == (cfa, 4000.0)
            assert theirs.black_level == tuple(float(int(level)) for level in black)
        else:
            np.testing.assert_array_equal(tifffile.imread(out), mosaic)


def test_a_tiff_and_its_sidecar_say_what_the_dng_said(tmp_path: Path) -> None:
    extras = DngExtras(noise_profile=((1e-5, 2e-8),) * 3, orientation=3, temperature_c=4.5, as_shot_neutral=(0.5, 1, 1))
    write_dng(
        tmp_path / "in.dng",
        codes(20, 30, bits=10),
        cfa="BGGR",
        black_level=(64, 65, 66, 67.25),
        white_level=1020,
        bit_depth=10,
        iso=102400,
        exposure_s=0.002867,
        make="Ours",
        model="A",
        compression="lossless-jpeg",
        extras=extras,
    )
    outcome = run(tmp_path / "in.dng", tmp_path / "out.tif")
    before, after = (read_stated(tmp_path / name, headerless=None) for name in ("in.dng", "out.tif"))
    assert levels(after) == levels(before)
    for name in ("cfa", "bit_depth", "iso", "temperature_c", "make", "model", "orientation", "noise_profile"):
        assert getattr(after, name) == getattr(before, name), name
    assert after.as_shot_neutral == before.as_shot_neutral
    assert after.exposure_s == pytest.approx(before.exposure_s, rel=1e-12)
    assert told(outcome) == {"colour-matrix-left-out"}
    assert read_header(tmp_path / "out.tif").cfa == "BGGR"


def test_linearized_codes_end_at_black_and_white(tmp_path: Path) -> None:
    black, white = (100.0, 101.5, 102.0, 103.0), 3000
    mosaic = codes(40, 50, bits=12)
    write_dng(tmp_path / "in.dng", mosaic, cfa="RGGB", black_level=black, white_level=white, bit_depth=12)
    outcome = run(tmp_path / "in.dng", tmp_path / "out.dng", Conversion(linearize=True))
    per_pixel = np.tile(np.reshape(black, (2, 2)), (20, 25))
    expected = np.rint(((mosaic - per_pixel) * (65535 / (white - per_pixel))).clip(0, 65535)).astype(np.uint16)
    image = read_raw(tmp_path / "out.dng")
    np.testing.assert_array_equal(image.mosaic, expected)
    assert levels(image.header) == ((0.0,) * 4, (65535.0,) * 4)
    (said,) = outcome.document["files"]
    below, above = int((mosaic < per_pixel).sum()), int((mosaic > white).sum())
    assert (said["clipped_below_black"], said["clipped_above_white"]) == (below, above)
    (clipped,) = (one for one in outcome.findings if one.code == "clipped-at-black")
    assert clipped.message.startswith(f"{below} of 2000 ")


@pytest.mark.parametrize("bits", [-4, -2, 2, 4])
def test_shifted_codes_keep_their_levels(tmp_path: Path, bits: int) -> None:
    mosaic = codes(20, 30, bits=8) << 4
    write_dng(tmp_path / "in.dng", mosaic, cfa="RGGB", black_level=(256,), white_level=4080, bit_depth=12)
    outcome = run(tmp_path / "in.dng", tmp_path / "out.dng", Conversion(bit_shift=bits, compression="lossless-jpeg"))
    image = read_raw(tmp_path / "out.dng")
    np.testing.assert_array_equal(image.mosaic, mosaic * 2**bits if bits > 0 else mosaic >> -bits)
    assert levels(image.header) == ((256.0 * 2.0**bits,) * 4, (4080.0 * 2.0**bits,) * 4)
    assert outcome.findings == ()


def test_bits_that_are_lost_are_counted_and_bits_that_do_not_fit_refused(tmp_path: Path) -> None:
    mosaic = codes(20, 30, bits=12)
    write_dng(
        tmp_path / "in.dng",
        mosaic,
        cfa="RGGB",
        black_level=(0,),
        white_level=4095,
        bit_depth=12,
        compression="lossless-jpeg",
    )
    outcome = run(tmp_path / "in.dng", tmp_path / "out.dng", Conversion(bit_shift=-3))
    (said,) = outcome.document["files"]
    assert said["codes_shifted_out"] == int((mosaic & 7 != 0).sum())
    assert said["white_level"] == 511.0
    assert told(outcome) == {"bits-shifted-out"}
    for shift in (5, -12):
        with pytest.raises(UsageError, match="12 bits"):
            run(tmp_path / "in.dng", tmp_path / "other.dng", Conversion(bit_shift=shift))
    assert not (tmp_path / "other.dng").exists()


def test_pictures_are_refused_for_measuring(tmp_path: Path) -> None:
    neutral = (0.5, 1.0, 0.8)
    grey = np.array([[0.5, 1.0], [1.0, 0.8]]) * 2000 + 100
    mosaic = np.tile(grey, (16, 16)).astype(np.uint16)
    extras = DngExtras(as_shot_neutral=neutral, noise_profile=((1e-5, 2e-8),))
    write_dng(tmp_path / "in.dng", mosaic, cfa="RGGB", black_level=(100,), white_level=4095, extras=extras)
    balanced = Conversion(demosaic=True, white_balance=True)
    for name in ("out.dng", "out.tif"):
        outcome = run(tmp_path / "in.dng", tmp_path / name, balanced)
        assert {"demosaicked", "white-balanced", "noise-profile-left-out"} <= told(outcome)
        rgb = tifffile.imread(tmp_path / name)
        assert rgb.shape == (32, 32, 3)
        np.testing.assert_allclose(rgb, 65535 * 2000 / 3995, atol=1)
    (finding,) = read_header(tmp_path / "out.dng").findings
    assert finding.code == "linear-dng"
    mosaic_only = run(tmp_path / "in.dng", tmp_path / "mosaic.dng", Conversion(white_balance=True))
    np.testing.assert_allclose(read_raw(tmp_path / "mosaic.dng").mosaic, 65535 * 2000 / 3995, atol=1)
    assert "white-balanced" in told(mosaic_only)
    assert read_header(tmp_path / "mosaic.dng").as_shot_neutral == (1.0, 1.0, 1.0)


def test_what_is_needed_and_missing_is_named(tmp_path: Path) -> None:
    path = sources(tmp_path, codes(20, 30, bits=12))["npy"]
    with pytest.raises(UsageError, match="--cfa"):
        run(path, tmp_path / "a.dng")
    with pytest.raises(UsageError, match="--black"):
        run(path, tmp_path / "a.dng", Conversion(linearize=True), cfa="RGGB")
    with pytest.raises(UsageError, match="no colours"):
        run(path, tmp_path / "a.dng", Conversion(demosaic=True), cfa=MONO, black_level=(1.0,))
    with pytest.raises(UsageError, match="not below its white level"):
        run(path, tmp_path / "a.dng", Conversion(linearize=True), cfa=MONO, black_level=(50.0,), white_level=50.0)
    assert told(run(path, tmp_path / "a.dng", cfa="RGGB")) == {"white-level-assumed", "black-level-unknown"}
    header = read_header(tmp_path / "a.dng")
    assert (header.black_level.source, header.white_level.values[0]) == ("default", 65535.0)


def test_what_has_no_place_is_said(tmp_path: Path) -> None:
    values = np.ones((4, 2, 2))
    values[0, 0, 0] = 1.5
    extras = DngExtras(
        linearization_table=tuple(range(0, 8192, 2)),
        gain_maps=mosaic_gain_maps(values, cfa="RGGB", size=(20, 30)),
    )
    mosaic = codes(20, 30, bits=12)
    options = {"cfa": "RGGB", "black_level": (0,), "white_level": 8190, "bit_depth": 12, "extras": extras}
    write_dng(tmp_path / "in.dng", mosaic, compression="lossless-jpeg", **options)
    outcome = run(tmp_path / "in.dng", tmp_path / "out.dng", Conversion(compression="lossless-jpeg"))
    assert told(outcome) == {"linearization-applied", "opcodes-left-out"}
    np.testing.assert_array_equal(read_raw(tmp_path / "out.dng").mosaic, 2 * mosaic)
    assert read_header(tmp_path / "out.dng").bit_depth == 13


def test_a_folder_keeps_its_structure_and_twins_keep_their_endings(tmp_path: Path) -> None:
    study = tmp_path / "study"
    for name in ("flat/a.dng", "dark/a.dng", "dark/b.dng"):
        (study / name).parent.mkdir(parents=True, exist_ok=True)
        write_dng(study / name, codes(8, 8, bits=8), cfa="RGGB", black_level=(1,), white_level=255, bit_depth=8)
    tifffile.imwrite(study / "dark/B.tif", codes(8, 8, bits=8), photometric="minisblack")
    (study / "dark/bad.dng").write_bytes(b"II*\0nothing")
    outcome = run([study], study / "out", cfa="RGGB")
    written = {path.relative_to(study / "out").as_posix() for path in (study / "out").rglob("*.*")}
    assert written == {"flat/a.dng", "dark/a.dng", "dark/b.dng.dng", "dark/B.tif.dng"}
    assert any(one.severity == "error" and one.files == (str(study / "dark/bad.dng"),) for one in outcome.findings)
    with pytest.raises(UsageError, match="exists already"):
        run([study], study / "out", cfa="RGGB")
    run([study], study / "out", Conversion(overwrite=True), cfa="RGGB")
    assert {path.relative_to(study / "out").as_posix() for path in (study / "out").rglob("*.*")} == written


def test_nothing_that_is_read_is_ever_written(tmp_path: Path) -> None:
    path = tmp_path / "a.dng"
    write_dng(path, codes(8, 8, bits=8), cfa="RGGB", black_level=(1,), white_level=255, bit_depth=8)
    content = path.read_bytes()
    (tmp_path / "a.json").write_text("{}", encoding="utf-8")
    (tmp_path / "link.dng").symlink_to(path)
    for target in ("a.dng", "link.dng", "a.tif"):
        with pytest.raises(UsageError, match="is read by this conversion"):
            run(path, tmp_path / target, Conversion(overwrite=True))
    (tmp_path / "b.dng").write_bytes(b"mine")
    with pytest.raises(UsageError, match="exists already"):
        run(path, tmp_path / "b.dng")
    with pytest.raises(UsageError, match="names one file"):
        run([path, tmp_path / "b.dng"], tmp_path / "c.dng")
    with pytest.raises(UsageError, match=r"\.dng, \.tif or \.tiff"):
        run(path, tmp_path / "c.png")
    assert ((tmp_path / "b.dng").read_bytes(), path.read_bytes()) == (b"mine", content)


def test_a_failed_write_leaves_nothing(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "in/a.dng"
    path.parent.mkdir()
    write_dng(path, codes(8, 8, bits=8), cfa="RGGB", black_level=(1,), white_level=255, bit_depth=8)
    replace = os.replace

    def fail(source: object, target: object) -> None:
        if str(target).endswith(".tif"):
            raise OSError("disk full")
        replace(source, target)

    monkeypatch.setattr(Path, "replace", fail)
    with pytest.raises(OSError, match="disk full"):
        run(path, tmp_path / "out.tif")
    assert [one.name for one in tmp_path.iterdir()] == ["in"]


@pytest.mark.parametrize("name", ["CRW_0101.CRW", "CRW_0119.CRW"])
def test_a_makers_raw_file_keeps_margins_and_levels(tmp_path: Path, shared_data: Shared, name: str) -> None:
    path = shared_data(f"makers/{name}")
    run(path, tmp_path / "out.dng", Conversion(compression="lossless-jpeg"))
    before, after = read_raw(path), read_raw(tmp_path / "out.dng")
    np.testing.assert_array_equal(after.mosaic, before.mosaic)
    assert (after.header.cfa, *levels(after.header)) == (before.header.cfa, *levels(before.header))
    assert (after.header.iso, after.header.exposure_s) == (before.header.iso, pytest.approx(before.header.exposure_s))
    theirs, original = read_with_libraw(tmp_path / "out.dng"), read_with_libraw(path)
    np.testing.assert_array_equal(theirs.mosaic, original.mosaic)
    assert (theirs.cfa, theirs.black_level, theirs.white_level) == (
        original.cfa,
        original.black_level,
        original.white_level,
    )


def test_a_powershot_keeps_its_neutral_and_its_colours_in_a_dng(
    tmp_path: Path, shared_data: Callable[[str], Path]
) -> None:
    source = read_header(shared_data("makers/CRW_0101.CRW"))
    assert source.as_shot_neutral == pytest.approx((1043 / 1690, 1.0, 1043 / 1622))
    assert source.colour_matrix is not None
    assert source.colour_matrix.values == pytest.approx(
        (0.8606, -0.2573, -0.0949, -0.8237, 1.5489, 0.2974, -0.2649, 0.3076, 0.91), abs=1e-6
    )
    run(source.path, tmp_path / "a.dng")
    written = read_header(tmp_path / "a.dng")
    assert written.as_shot_neutral == pytest.approx(source.as_shot_neutral)
    assert written.colour_matrix == source.colour_matrix
