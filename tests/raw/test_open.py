import re
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import imagecodecs
import numpy as np
import pytest
from dng_builder import (
    LONG,
    SHORT,
    Image,
    dng_bytes,
    dng_fields,
    lossless_jpeg,
    mosaic_fields,
    packed,
    tiff_bytes,
)

from fullwell.errors import RawFileError, UnreadableFileError, UnsuitableFileError
from fullwell.raw.image import Area
from fullwell.raw.open import decode, read_header, read_raw, require_measurable
from fullwell.raw.write import write_dng
from libraw_oracle import read_with_libraw


@pytest.mark.parametrize(
    ("content", "error", "code"),
    [
        (b"this is text, whatever its name says\n" * 99, UnreadableFileError, "not-a-raw-file"),
        (b"", UnreadableFileError, "file-truncated"),
        (b"II*\0", UnreadableFileError, "file-damaged"),
        (b"II*\0\xff\xff\0\0", UnreadableFileError, "file-truncated"),
        (b"MM\0+\0\x08\0\0\0\0\0\0\0\0\1\0", UnreadableFileError, "file-truncated"),
        (imagecodecs.jpeg8_encode(np.zeros((8, 8), np.uint8)), UnsuitableFileError, "lossy-compression"),
    ],
    ids=["text", "empty", "four bytes", "directory beyond the end", "the same, BigTIFF", "jpeg"],
)
def test_what_is_no_raw_file_is_told_by_its_content(
    tmp_path: Path, content: bytes, error: type[RawFileError], code: str
) -> None:
    path = tmp_path / "frame.dng"
    path.write_bytes(content)
    with pytest.raises(error) as caught:
        read_header(path)
    assert caught.value.code == code


def test_a_missing_file_and_a_folder(tmp_path: Path) -> None:
    for path, code in ((tmp_path / "missing.dng", "file-missing"), (tmp_path, "file-unreadable")):
        with pytest.raises(UnreadableFileError) as caught:
            read_header(path)
        assert caught.value.code == code


def test_the_name_of_a_file_does_not_matter(tmp_path: Path) -> None:
    path = tmp_path / "frame.jpg"
    mosaic = np.arange(48, dtype=np.uint16).reshape(6, 8)
    path.write_bytes(dng_bytes(mosaic))
    np.testing.assert_array_equal(read_raw(path).mosaic, mosaic)


def test_threads_decode_alike(tmp_path: Path) -> None:
    path = tmp_path / "frame.dng"
    mosaic = np.random.default_rng(8).integers(0, 1 << 12, (600, 700), dtype=np.uint16)
    options = {"cfa": "RGGB", "black_level": (64,), "white_level": 4095, "bit_depth": 12}
    write_dng(path, mosaic, compression="lossless-jpeg", **options)
    header, data = read_header(path), path.read_bytes()
    with ThreadPoolExecutor(max_workers=4) as pool:
        for decoded in pool.map(lambda _: decode(header, data), range(16)):
            np.testing.assert_array_equal(decoded, mosaic)


SharedData = Callable[[str], Path]


def test_the_colour_chart_of_a_canon_550d(shared_data: SharedData) -> None:
    path = shared_data("colorchecker-550d/colorchart.dng")
    image, theirs = read_raw(path), read_with_libraw(path)
    header = image.header
    assert (header.width, header.height, header.raw_width, header.raw_height) == (1734, 1156, 1888, 1182)
    assert (header.active_area, header.cfa, header.bit_depth) == (Area(26, 152, 1182, 1886), "RGGB", 14)
    assert header.black_level.values == (2056.0,) * 4 == theirs.black_level
    assert header.white_level.values == (15000.0,) * 4
    assert (header.iso, header.exposure_s, header.model) == (None, None, "Canon EOS Kiss X4")
    np.testing.assert_array_equal(image.mosaic, theirs.mosaic)
    assert theirs.cfa == header.cfa


def test_two_component_lossless_jpeg_as_phones_write_it(shared_data: SharedData) -> None:
    image = read_raw(shared_data("synthetic/lj92_2comp_1344x1008.dng"))
    np.testing.assert_array_equal(image.mosaic, np.load(shared_data("synthetic/lj92_2comp_1344x1008.npy")))
    header = image.header
    assert (header.cfa, header.iso, header.exposure_s) == ("BGGR", 55.0, 0.01)
    assert header.black_level.values == (64.0,) * 4
    assert header.white_level.values == (1023.0,) * 4


def test_a_lossy_dng_is_refused_and_its_noise_profile_known(shared_data: SharedData) -> None:
    path = shared_data("lossy-6d/canon_eos_6d.dng")
    header = read_header(path)
    assert header.compression == "lossy-jpeg"
    assert {"lossy-compression", "linear-dng"} <= {finding.code for finding in header.findings}
    expected = [(3.31406676e-5, 9.2130e-8), (3.27799e-5, 9.2808e-8), (3.25789e-5, 9.3749e-8)]
    np.testing.assert_allclose(header.noise_profile, expected, rtol=1e-5)  # as printed, six digits at most
    assert (header.iso, header.exposure_s, header.model) == (1000.0, 1 / 60, "Canon EOS 6D")
    with pytest.raises(UnsuitableFileError) as caught:
        require_measurable(header)
    assert caught.value.code == "lossy-compression"
    with pytest.raises(UnsuitableFileError):
        decode(header, path.read_bytes())


def test_machine_vision_tiff(shared_data: SharedData) -> None:
    image = read_raw(shared_data("imx541/bright/exp000002867us_n00.tiff"))
    assert image.mosaic.shape == (1128, 1128)
    assert (image.header.cfa, image.header.bit_depth, image.header.black_level) == (None, 16, None)
    assert image.mosaic.max() < 4096


BASES = {
    "words": dng_bytes,
    "packed": lambda m: tiff_bytes(dng_image(m, packed(m, 12), bits=12, compression=1)),
    "lossless": lambda m: tiff_bytes(
        dng_image(m, lossless_jpeg(m.reshape(24, 16, 2), precision=12, predictor=1), bits=12, compression=7)
    ),
    "deflate": lambda m: tiff_bytes(dng_image(m, imagecodecs.zlib_encode(m.tobytes()), bits=16, compression=8)),
    "lzw": lambda m: tiff_bytes(tiff_image(m, imagecodecs.lzw_encode(m.tobytes()), compression=5)),
    "packbits": lambda m: tiff_bytes(tiff_image(m, imagecodecs.packbits_encode(m.tobytes()), compression=32773)),
    "png": imagecodecs.png_encode,
}


def dng_image(mosaic: np.ndarray, segment: bytes, *, bits: int, compression: int) -> Image:
    fields = mosaic_fields(mosaic.shape[1], mosaic.shape[0], bits=bits, compression=compression) | dng_fields()
    fields |= {50713: (SHORT, (2, 2)), 50714: (SHORT, (1, 2, 3, 4)), 50829: (LONG, (0, 2, 22, 30))}
    return Image(fields=fields, segments=[segment], exif={34855: (SHORT, (100,))})


def tiff_image(mosaic: np.ndarray, segment: bytes, *, compression: int) -> Image:
    fields = mosaic_fields(mosaic.shape[1], mosaic.shape[0], cfa="mono", compression=compression)
    return Image(fields=fields | {262: (SHORT, (1,))}, segments=[segment])


def mutated(data: bytes, rng: np.random.Generator) -> bytes:
    damaged = bytearray(data)
    for _ in range(int(rng.integers(1, 5))):
        where = int(rng.integers(0, len(damaged)))
        if rng.random() < 0.2:
            where = len(damaged) - 1 - int(rng.integers(0, min(len(damaged), 300)))
        damaged[where] = int(rng.choice([0, 1, 0x7F, 0x80, 0xFF, int(rng.integers(0, 256))]))
    return bytes(damaged[: int(rng.integers(0, len(damaged)))] if rng.random() < 0.15 else damaged)


@pytest.mark.parametrize("base", BASES)
def test_a_damaged_file_is_read_or_refused_and_nothing_else(tmp_path: Path, base: str) -> None:
    rng = np.random.default_rng(len(base))
    mosaic = rng.normal(600, 80, (24, 32)).round().astype(np.uint16)
    whole = bytes(BASES[base](mosaic))
    path = tmp_path / "frame.dng"
    path.write_bytes(whole)
    shape = read_raw(path).mosaic.shape
    assert shape in {(24, 32), (22, 28)}
    refused: list[RawFileError] = []
    for _ in range(150):
        path.write_bytes(mutated(whole, rng))
        try:
            image = read_raw(path)
        except RawFileError as error:
            refused.append(error)
        else:
            assert image.mosaic.shape == (image.header.height, image.header.width)
    assert len(refused) > 10
    assert all(re.fullmatch(r"[a-z]+(-[a-z]+)+", error.code) and error.message for error in refused)
