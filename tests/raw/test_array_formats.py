"""FITS, PGM and NumPy arrays: every stored form gives the same mosaic, damage is named, nothing else is measured."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
import tifffile
from astropy.io import fits
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from fullwell.errors import UnreadableFileError, UnsuitableFileError
from fullwell.raw.open import decode, read_bytes, read_header, read_headers, read_raw

MOSAICS = arrays(np.uint16, st.tuples(st.integers(1, 9), st.integers(1, 9)))
QUICK = settings(max_examples=25, suppress_health_check=[HealthCheck.function_scoped_fixture])


def write_fits(path: Path, values: np.ndarray, **cards: object) -> Path:
    part = fits.PrimaryHDU(values)
    for name, value in cards.items():
        part.header[name.replace("_", "-")] = value
    part.writeto(path, overwrite=True)
    return path


def write_pgm(path: Path, mosaic: np.ndarray, *, highest: int = 65535, comment: str = "") -> Path:
    height, width = mosaic.shape
    stored = mosaic.astype(">u2" if highest > 255 else "u1").tobytes()
    path.write_bytes(f"P5\n{comment}{width} {height}\n{highest}\n".encode() + stored)
    return path


def write_text_pgm(path: Path, mosaic: np.ndarray) -> Path:
    height, width = mosaic.shape
    rows = "\n".join(" ".join(map(str, row)) for row in mosaic)
    path.write_text(f"P2\n# made by a test\n{width} {height}\n65535\n# rows\n{rows}", encoding="ascii")
    return path


@QUICK
@given(mosaic=MOSAICS)
def test_every_form_gives_the_mosaic_back(mosaic: np.ndarray, tmp_path: Path) -> None:
    np.save(tmp_path / "a.npy", mosaic)
    files = [
        write_fits(tmp_path / "unsigned.fits", mosaic),
        write_fits(tmp_path / "long.fits", mosaic.astype(np.int32)),
        write_fits(tmp_path / "real.fits", mosaic.astype(np.float32)),
        write_pgm(tmp_path / "a.pgm", mosaic, comment="# made by a test\n"),
        tmp_path / "a.npy",
        write_text_pgm(tmp_path / "text.pgm", mosaic),
    ]
    for path in files:
        image = read_raw(path)
        np.testing.assert_array_equal(image.mosaic, mosaic, err_msg=path.name)
        assert (image.header.height, image.header.width) == mosaic.shape


def test_an_image_in_an_extension_is_found(tmp_path: Path) -> None:
    mosaic = np.arange(12, dtype=np.uint16).reshape(3, 4)
    parts = [fits.PrimaryHDU(), fits.ImageHDU(np.zeros((2, 3, 4), np.int16)), fits.ImageHDU(mosaic)]
    fits.HDUList(parts).writeto(tmp_path / "parts.fits")
    np.testing.assert_array_equal(read_raw(tmp_path / "parts.fits").mosaic, mosaic)


@pytest.mark.parametrize(("inherit", "exposure_s"), [({}, 3.0), ({"INHERIT": True}, 3.0), ({"INHERIT": False}, None)])
def test_an_image_in_an_extension_inherits_cards(
    inherit: dict[str, bool], exposure_s: float | None, tmp_path: Path
) -> None:
    primary, image = fits.PrimaryHDU(), fits.ImageHDU(np.arange(12, dtype=np.uint16).reshape(3, 4))
    primary.header["EXPTIME"], primary.header["EGAIN"], image.header["EGAIN"] = 3.0, 1.0, 0.5
    image.header.update(inherit)
    fits.HDUList([primary, image]).writeto(tmp_path / "parts.fits")
    read = read_raw(tmp_path / "parts.fits")
    assert (read.header.exposure_s, read.header.level_tags) == (exposure_s, (("EGAIN", (0.5,)),))
    assert int(read.mosaic.max()) == 11


@pytest.mark.parametrize(
    ("rest", "code"), [("1 2 3", "file-truncated"), ("1 2 3 4 5 x", "file-damaged"), ("1 2 3 4 5 999", "file-damaged")]
)
def test_damage_in_a_text_pgm_is_named(rest: str, code: str, tmp_path: Path) -> None:
    (tmp_path / "a.pgm").write_text(f"P2 3 2 255 {rest}", encoding="ascii")
    with pytest.raises(UnreadableFileError) as caught:
        read_raw(tmp_path / "a.pgm")
    assert caught.value.code == code


def test_more_images_in_a_pgm_are_told(tmp_path: Path) -> None:
    path = write_pgm(tmp_path / "a.pgm", np.arange(12, dtype=np.uint16).reshape(3, 4))
    assert read_header(path).findings == ()
    path.write_bytes(2 * path.read_bytes())
    assert [one.code for one in read_header(path).findings] == ["images-left-out"]


def test_cards_say_how_a_frame_was_taken(tmp_path: Path) -> None:
    mosaic = np.zeros((4, 6), np.uint16)
    cards = {"EXPTIME": 2.5, "GAIN": 120, "EGAIN": 0.8, "CCD_TEMP": -9.5, "INSTRUME": "ASI", "BAYERPAT": "RGGB"}
    header = read_header(write_fits(tmp_path / "a.fits", mosaic, **cards))
    assert (header.exposure_s, header.iso, header.temperature_c) == (2.5, 120.0, -9.5)
    assert (header.model, header.cfa, header.bit_depth) == ("ASI", "RGGB", 16)
    assert ("EGAIN", (0.8,)) in header.level_tags
    upside_down = write_fits(tmp_path / "b.fits", mosaic, BAYERPAT="RGGB", ROWORDER="BOTTOM-UP")
    assert read_header(upside_down).cfa == "GBRG"
    assert read_header(write_fits(tmp_path / "c.fits", mosaic, BAYERPAT="RGGB", XBAYROFF=1)).cfa == "GRBG"


@pytest.mark.parametrize(
    ("values", "code"),
    [
        (np.full((3, 3), 0.5, np.float32), "unsupported-sample-format"),
        (np.full((3, 3), -1, np.int32), "unsupported-sample-format"),
        (np.full((3, 3), 70000, np.int32), "unsupported-sample-format"),
        (np.full((3, 3), np.nan, np.float32), "unsupported-sample-format"),
        (np.zeros((3, 3, 3), np.int16), "processed-rgb"),
    ],
)
def test_calibrated_and_coloured_images_are_refused(values: np.ndarray, code: str, tmp_path: Path) -> None:
    with pytest.raises(UnsuitableFileError) as caught:
        read_raw(write_fits(tmp_path / "a.fits", values))
    assert caught.value.code == code


@pytest.mark.parametrize("name", ["a.fits", "a.pgm", "a.npy"])
def test_a_file_cut_short_is_named_so(name: str, tmp_path: Path) -> None:
    mosaic = np.ones((40, 40), np.uint16)
    path = tmp_path / name
    writers: dict[str, Callable[[], object]] = {
        "a.fits": lambda: write_fits(path, mosaic),
        "a.pgm": lambda: write_pgm(path, mosaic),
        "a.npy": lambda: np.save(path, mosaic),
    }
    writers[name]()
    path.write_bytes(path.read_bytes()[:3000])
    with pytest.raises(UnreadableFileError) as caught:
        read_raw(path)
    assert caught.value.code == "file-truncated"


def test_arrays_that_are_no_mosaics_are_refused(tmp_path: Path) -> None:
    for values in (np.zeros((3, 3)), np.zeros((3, 3), np.int16), np.zeros((2, 3, 3), np.uint16)):
        np.save(tmp_path / "a.npy", values)
        with pytest.raises(UnsuitableFileError):
            read_header(tmp_path / "a.npy")


def stacks(folder: Path, frames: np.ndarray) -> list[Path]:
    np.save(folder / "stack.npy", frames)
    tifffile.imwrite(folder / "pages.tif", frames, photometric="minisblack")
    tifffile.imwrite(folder / "deflated.tif", frames, photometric="minisblack", compression="zlib", tile=(16, 16))
    tifffile.imwrite(folder / "big.tif", frames, photometric="minisblack", bigtiff=True, byteorder=">")
    return [*(folder / name for name in ("stack.npy", "pages.tif", "deflated.tif", "big.tif")), cube(folder, frames)]


def cube(folder: Path, frames: np.ndarray) -> Path:
    return write_fits(folder / "cube.fits", frames, EXPTIME=0.5)


def test_every_frame_of_a_stack_is_read_from_its_own_bytes(tmp_path: Path) -> None:
    frames = np.random.default_rng(3).integers(0, 4096, (12, 18, 20), dtype=np.uint16)
    for path in stacks(tmp_path, frames):
        headers = read_headers(path)
        assert [header.page for header in headers] == list(range(1, 13)), path.name
        for header, frame in zip(headers, frames, strict=True):
            np.testing.assert_array_equal(decode(header, read_bytes(header)), frame, err_msg=path.name)
            np.testing.assert_array_equal(decode(header, path.read_bytes()), frame, err_msg=path.name)
            assert len(read_bytes(header)) <= frame.nbytes + 200 * (path.suffix == ".tif")
        assert "several-frames" in {finding.code for finding in read_header(path).findings}


def test_pages_that_are_no_frames_are_left_out_and_said(tmp_path: Path) -> None:
    path = tmp_path / "a.tif"
    frame = np.arange(12, dtype=np.uint16).reshape(3, 4)
    with tifffile.TiffWriter(path) as writer:
        writer.write(frame, photometric="minisblack")
        writer.write(np.zeros((6, 8), np.uint16), photometric="minisblack")
        writer.write(np.zeros((2, 2), np.uint16), photometric="minisblack", subfiletype=1)
    (header,) = read_headers(path)
    assert (header.page, [finding.code for finding in header.findings]) == (None, ["pages-left-out"])
    np.testing.assert_array_equal(read_raw(path).mosaic, frame)


def test_settings_of_a_camera_are_spelled(tmp_path: Path) -> None:
    path = write_fits(
        tmp_path / "a.fits", np.zeros((4, 6), np.uint16), EGAIN=10.83807, READOUTM="Low Gain", BLKLEVEL=64
    )
    header = read_header(path)
    assert header.settings == "EGAIN 10.84, BLKLEVEL 64, READOUTM Low Gain"
    assert header.black_level is not None
    assert header.black_level.values == (64.0,)


def test_a_pgm_that_claims_much_costs_nothing(tmp_path: Path) -> None:
    path = tmp_path / "a.pgm"
    for head in (b"P5\n100000 100000\n65535\n", b"P5\n" + b" " * 4000, b"P5\n#" + b"x" * 4000, b"P5\n0 5\n255\n"):
        path.write_bytes(head)
        with pytest.raises(UnreadableFileError):
            read_header(path)


def test_real_frames_have_the_conversion_factor_of_their_flats(shared_data: Callable[[str], Path]) -> None:
    """Two flats and a bias of an STC428M: 12.0 to 12.2 e-/DN by pair difference, as measured independently."""
    folder = shared_data("imx428")
    first, second, bias = (read_raw(folder / f"{name}.fit").mosaic.astype(float) for name in ("flat1", "flat2", "bias"))
    middle = (slice(400, 700), slice(600, 1000))
    first, second, bias = first[middle], second[middle], bias[middle]
    ratio = (first.mean() - bias.mean()) / (second.mean() - bias.mean())
    difference = (first - bias.mean()) - ratio * (second - bias.mean())
    variance = difference.var(ddof=1) / (1 + ratio**2)
    read = np.var(bias - bias.mean(axis=1, keepdims=True), ddof=1)
    signal = (first.mean() + second.mean()) / 2 - bias.mean()
    # 120 000 pixels: a relative error of sqrt(2 / 120 000) = 0.4 %, four of them about the independent 12.0 to 12.2
    assert 12.0 * (1 - 0.016) < signal / (variance - read) < 12.2 * (1 + 0.016)
