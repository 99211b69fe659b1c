"""FITS, PGM and NumPy arrays: every stored form gives the same mosaic, damage is named, nothing else is measured."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from astropy.io import fits
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from fullwell.errors import UnreadableFileError, UnsuitableFileError
from fullwell.raw.open import read_header, read_raw

MOSAICS = arrays(np.uint16, st.tuples(st.integers(1, 9), st.integers(1, 9)))
QUICK = settings(max_examples=25, suppress_health_check=[HealthCheck.function_scoped_fixture], deadline=None)


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
