import zlib
from itertools import product
from pathlib import Path

import imagecodecs
import numpy as np
import pytest
import tifffile
from hypothesis import given
from hypothesis import strategies as st

from fullwell.errors import UnreadableFileError, UnsuitableFileError
from fullwell.raw.directory import read_directories
from fullwell.raw.dng import mosaic_cfa
from fullwell.raw.open import decode, read_header, read_raw


def codes(height: int, width: int, dtype: type, seed: int = 5) -> np.ndarray:
    return np.random.default_rng(seed).integers(0, np.iinfo(dtype).max, (height, width), dtype=dtype, endpoint=True)


@pytest.mark.parametrize(
    ("compression", "predictor"),
    [(None, None), ("packbits", None), *product(("deflate", "adobe_deflate", "lzw"), (None, "horizontal"))],
)
@pytest.mark.parametrize("storage", [{"rowsperstrip": 8}, {"tile": (16, 32)}, {"byteorder": ">", "rowsperstrip": 40}])
@pytest.mark.parametrize("dtype", [np.uint8, np.uint16])
def test_every_tiff_that_tifffile_writes(
    tmp_path: Path, dtype: type, storage: dict, compression: str | None, predictor: str | None
) -> None:
    path = tmp_path / "frame.tif"
    pixels = codes(37, 50, dtype)
    tifffile.imwrite(path, pixels, compression=compression, predictor=predictor, **storage)
    image = read_raw(path)
    assert image.mosaic.dtype == np.uint16
    np.testing.assert_array_equal(image.mosaic, pixels)
    header = image.header
    assert (header.format, header.cfa, header.bit_depth) == ("tiff", None, 8 * pixels.itemsize)
    assert (header.black_level, header.white_level, header.exposure_s) == (None, None, None)


@given(height=st.integers(1, 40), width=st.integers(1, 40), rows=st.integers(1, 40))
def test_every_size_and_strip(tmp_path_factory: pytest.TempPathFactory, height: int, width: int, rows: int) -> None:
    path = tmp_path_factory.getbasetemp() / "sized.tif"
    pixels = codes(height, width, np.uint16)
    tifffile.imwrite(path, pixels, photometric="minisblack", planarconfig="contig", rowsperstrip=rows)
    np.testing.assert_array_equal(read_raw(path).mosaic, pixels)


def test_big_tiff(tmp_path: Path) -> None:
    path = tmp_path / "frame.tif"
    tifffile.imwrite(path, codes(9, 9, np.uint16), bigtiff=True)
    np.testing.assert_array_equal(read_raw(path).mosaic, codes(9, 9, np.uint16))


def test_a_mosaic_tiff_says_its_order_by_its_tags(tmp_path: Path) -> None:
    path = tmp_path / "frame.tif"
    tags = [(33421, 3, 2, (2, 2), True), (33422, 1, 4, bytes((1, 2, 0, 1)), True)]
    tifffile.imwrite(path, codes(8, 8, np.uint16), photometric="cfa", extratags=tags)
    assert read_header(path).cfa == "GBRG"


def test_frames_alike_byte_for_byte_are_parsed_once_and_any_other_anew(tmp_path: Path) -> None:
    def written(name: str, seed: int, order: tuple[int, ...]) -> Path:
        tags = [(33421, 3, 2, (2, 2), True), (33422, 1, 4, bytes(order), True)]
        tifffile.imwrite(tmp_path / name, codes(8, 8, np.uint16, seed), photometric="cfa", extratags=tags)
        return tmp_path / name

    paths = [written("a.tif", 1, (1, 2, 0, 1)), written("b.tif", 2, (1, 2, 0, 1)), written("c.tif", 3, (0, 1, 1, 2))]
    assert len({path.stat().st_size for path in paths}) == 1
    a, b, c = map(read_directories, paths)
    assert a is b
    assert [mosaic_cfa(one.first) for one in (b, c)] == ["GBRG", "RGGB"]
    np.testing.assert_array_equal(read_raw(paths[1]).mosaic, codes(8, 8, np.uint16, 2))
    paths[1].write_bytes(paths[1].read_bytes()[:-1])
    with pytest.raises(UnreadableFileError):
        read_header(paths[1])


@pytest.mark.parametrize(
    ("pixels", "options", "code"),
    [
        (np.zeros((8, 8, 3), np.uint8), {"photometric": "rgb"}, "processed-rgb"),
        (np.zeros((8, 8), np.uint8), {"photometric": "miniswhite"}, "processed-rgb"),
        (np.zeros((8, 8), np.float32), {}, "unsupported-sample-format"),
        (np.zeros((8, 8), np.int16), {}, "unsupported-sample-format"),
        (np.zeros((16, 16), np.uint8), {"compression": "jpeg"}, "lossy-compression"),
        (np.zeros((16, 16), np.uint8), {"compression": "zstd"}, "unsupported-compression"),
        (np.zeros((8, 8), np.uint16), {"photometric": "cfa"}, "unsupported-cfa"),
    ],
)
def test_tiff_that_is_no_mosaic_is_refused(tmp_path: Path, pixels: np.ndarray, options: dict, code: str) -> None:
    path = tmp_path / "frame.tif"
    tifffile.imwrite(path, pixels, **options)
    with pytest.raises(UnsuitableFileError) as caught:
        read_header(path)
    assert caught.value.code == code


@pytest.mark.parametrize("dtype", [np.uint8, np.uint16])
def test_grey_png(tmp_path: Path, dtype: type) -> None:
    path = tmp_path / "frame.png"
    pixels = codes(37, 50, dtype)
    path.write_bytes(imagecodecs.png_encode(pixels))
    image = read_raw(path)
    assert image.mosaic.dtype == np.uint16
    np.testing.assert_array_equal(image.mosaic, pixels)
    assert (image.header.format, image.header.cfa, image.header.bit_depth) == ("png", None, 8 * pixels.itemsize)
    assert (image.header.width, image.header.height) == (50, 37)


@pytest.mark.parametrize("dtype", [np.uint8, np.uint16])
def test_an_interlaced_png_is_read(tmp_path: Path, dtype: type) -> None:
    path, pixels = tmp_path / "frame.png", codes(1, 1, dtype)
    whole = bytearray(imagecodecs.png_encode(pixels))
    whole[28] = 1  # a single pixel is interlaced as it is not
    whole[29:33] = zlib.crc32(whole[12:29]).to_bytes(4, "big")
    path.write_bytes(whole)
    np.testing.assert_array_equal(read_raw(path).mosaic, pixels)


def test_a_png_whose_pixels_are_damaged_under_a_right_checksum_is_told(tmp_path: Path) -> None:
    path = tmp_path / "frame.png"
    whole = imagecodecs.png_encode(codes(9, 9, np.uint16))
    at = whole.index(b"IDAT")
    size = int.from_bytes(whole[at - 4 : at], "big")
    for packed in (zlib.compress(b"\5" * 9 * 19), zlib.compress(b"\0" * 9 * 18), zlib.compress(b"\0" * 9 * 20), b"no"):
        part = b"IDAT" + packed
        told = len(packed).to_bytes(4, "big") + part + zlib.crc32(part).to_bytes(4, "big")
        path.write_bytes(whole[: at - 4] + told + whole[at + size + 8 :])
        with pytest.raises(UnreadableFileError, match="pixels are damaged") as caught:
            read_raw(path)
        assert caught.value.code == "file-damaged"


@pytest.mark.parametrize("samples", [2, 3, 4])
def test_png_in_colour_or_with_alpha_is_refused(tmp_path: Path, samples: int) -> None:
    path = tmp_path / "frame.png"
    path.write_bytes(imagecodecs.png_encode(np.zeros((4, 4, samples), np.uint8)))
    with pytest.raises(UnsuitableFileError) as caught:
        read_header(path)
    assert caught.value.code == "processed-rgb"


def test_a_truncated_or_damaged_png_is_told(tmp_path: Path) -> None:
    path = tmp_path / "frame.png"
    whole = imagecodecs.png_encode(codes(100, 100, np.uint16))
    path.write_bytes(whole)
    header = read_header(path)
    with pytest.raises(UnreadableFileError) as caught:
        decode(header, whole[: len(whole) // 2])
    assert caught.value.code == "file-truncated"
    flipped = bytearray(whole)
    flipped[len(whole) // 2] ^= 1
    with pytest.raises(UnreadableFileError, match="checksum"):
        decode(header, bytes(flipped))
    path.write_bytes(whole[:20])
    with pytest.raises(UnreadableFileError) as caught:
        read_header(path)
    assert caught.value.code == "file-truncated"
