import struct
from pathlib import Path

import imagecodecs
import numpy as np
import pytest
from dng_builder import (
    ASCII,
    BYTE,
    DOUBLE,
    LONG,
    RATIONAL,
    SHORT,
    SRATIONAL,
    Image,
    dng_bytes,
    dng_fields,
    lossless_jpeg,
    mosaic_fields,
    packed,
    tiff_bytes,
)

from fullwell.errors import UnreadableFileError, UnsuitableFileError
from fullwell.findings import Severity
from fullwell.raw.cfa import BAYER, shifted
from fullwell.raw.image import Area, RawHeader, RawImage
from fullwell.raw.open import decode, read_header, read_raw, require_measurable
from libraw_oracle import read_with_libraw


@pytest.fixture
def save(tmp_path: Path):
    def write(data: bytes) -> Path:
        path = tmp_path / "frame.dng"
        path.write_bytes(data)
        return path

    return write


def codes(height: int, width: int, *, bits: int = 16, seed: int = 2) -> np.ndarray:
    return np.random.default_rng(seed).integers(0, 1 << bits, (height, width), dtype=np.uint16)


def codes_of(header: RawHeader) -> list[str]:
    return [finding.code for finding in header.findings]


@pytest.mark.parametrize("order", ["<", ">"])
@pytest.mark.parametrize("bits", [8, 9, 10, 11, 12, 13, 14, 15, 16])
def test_packed_strips(save, bits: int, order: str) -> None:
    mosaic = codes(11, 13, bits=bits)
    stored = packed(mosaic, bits) if bits < 16 else mosaic.astype(f"{order}u2").tobytes()
    row_bytes = (13 * bits + 7) // 8
    strips = [stored[start : start + 4 * row_bytes] for start in range(0, len(stored), 4 * row_bytes)]
    fields = mosaic_fields(13, 11, bits=bits, rows_per_strip=4) | dng_fields()
    image = read_raw(save(tiff_bytes(Image(fields=fields, segments=strips), order=order)))
    np.testing.assert_array_equal(image.mosaic, mosaic)
    assert image.header.bit_depth == bits
    assert image.header.white_level.values == (float(2**bits - 1),) * 4
    assert image.header.white_level.source == "default"
    assert image.header.black_level.values == (0.0,) * 4
    assert image.header.black_level.source == "default"


@pytest.mark.parametrize("bits", [10, 12, 14])
def test_packed_samples_with_margins_as_libraw_reads_them(save, bits: int) -> None:
    mosaic = codes(40, 54, bits=bits)
    fields = mosaic_fields(54, 40, bits=bits) | dng_fields() | {50829: (LONG, (2, 4, 38, 50))}
    path = save(tiff_bytes(Image(fields=fields, segments=[packed(mosaic, bits)])))
    np.testing.assert_array_equal(read_raw(path).mosaic, mosaic[2:38, 4:50])
    np.testing.assert_array_equal(read_with_libraw(path).mosaic, mosaic[2:38, 4:50])


def test_twelve_bits_in_words_are_recognised_by_their_size(save) -> None:
    mosaic = codes(6, 8, bits=12)
    fields = mosaic_fields(8, 6, bits=12) | dng_fields()
    image = read_raw(save(tiff_bytes(Image(fields=fields, segments=[mosaic.astype("<u2").tobytes()]))))
    np.testing.assert_array_equal(image.mosaic, mosaic)
    assert image.header.bit_depth == 12


def tiles_of(mosaic: np.ndarray, tile: int) -> list[np.ndarray]:
    padded = np.pad(mosaic, [(0, -side % tile) for side in mosaic.shape], constant_values=7)
    return [
        padded[top : top + tile, left : left + tile]
        for top in range(0, padded.shape[0], tile)
        for left in range(0, padded.shape[1], tile)
    ]


@pytest.mark.parametrize("area", [None, (0, 0, 37, 45), (1, 3, 36, 44), (17, 16, 32, 33)])
@pytest.mark.parametrize("kind", ["words", "packed", "one component", "two components", "deflate"])
def test_tiles_with_padded_edges(save, kind: str, area: tuple | None) -> None:
    mosaic = codes(37, 45, bits=12)
    encode = {
        "words": lambda tile: tile.astype("<u2").tobytes(),
        "packed": lambda tile: packed(tile, 12),
        "one component": lambda tile: lossless_jpeg(tile[:, :, None], precision=12, predictor=6),
        "two components": lambda tile: lossless_jpeg(tile.reshape(16, 8, 2), precision=12, predictor=1),
        "deflate": lambda tile: imagecodecs.zlib_encode(tile.astype("<u2").tobytes()),
    }[kind]
    compression = {"words": 1, "packed": 1, "deflate": 8}.get(kind, 7)
    bits = 16 if kind in {"words", "deflate"} else 12
    fields = mosaic_fields(45, 37, bits=bits, compression=compression) | dng_fields()
    del fields[278]
    fields |= {322: (LONG, (16,)), 323: (LONG, (16,))}
    if area:
        fields[50829] = (LONG, area)
    segments = [encode(np.ascontiguousarray(tile)) for tile in tiles_of(mosaic, 16)]
    image = read_raw(save(tiff_bytes(Image(fields=fields, segments=segments, tiled=True))))
    top, left, bottom, right = area or (0, 0, 37, 45)
    np.testing.assert_array_equal(image.mosaic, mosaic[top:bottom, left:right])
    assert image.header.active_area == Area(top, left, bottom, right)


@pytest.mark.parametrize("predictor", range(1, 8))
def test_libraw_agrees_on_two_component_lossless_jpeg(save, predictor: int) -> None:
    mosaic = codes(24, 32, bits=14)
    stream = lossless_jpeg(mosaic.reshape(24, 16, 2), precision=14, predictor=predictor)
    fields = mosaic_fields(32, 24, bits=14, compression=7, cfa="GBRG") | dng_fields()
    path = save(tiff_bytes(Image(fields=fields, segments=[stream])))
    np.testing.assert_array_equal(read_raw(path).mosaic, mosaic)
    np.testing.assert_array_equal(read_with_libraw(path).mosaic, mosaic)


def test_jpeg_of_another_shape_is_taken_sample_by_sample(save) -> None:
    mosaic = codes(24, 32, bits=14)
    stream = lossless_jpeg(mosaic.reshape(12, 64, 1), precision=14, predictor=6)
    fields = mosaic_fields(32, 24, bits=14, compression=7) | dng_fields()
    np.testing.assert_array_equal(read_raw(save(tiff_bytes(Image(fields=fields, segments=[stream])))).mosaic, mosaic)


@pytest.mark.parametrize("bits", [8, 16])
def test_lossless_jpeg_xl(save, bits: int) -> None:
    mosaic = codes(24, 32, bits=bits)
    dtype = np.uint8 if bits == 8 else np.uint16
    stream = imagecodecs.jpegxl_encode(mosaic.astype(dtype), lossless=True)
    fields = mosaic_fields(32, 24, bits=bits, compression=52546) | dng_fields()
    lossless = tiff_bytes(Image(fields=fields | {52553: (RATIONAL, ((0, 1),))}, segments=[stream]))
    np.testing.assert_array_equal(read_raw(save(lossless)).mosaic, mosaic)
    unsaid = read_header(save(tiff_bytes(Image(fields=fields, segments=[stream]))))
    assert unsaid.compression == "lossy-jpeg-xl"
    assert "lossy-compression" in codes_of(unsaid)


@pytest.mark.parametrize("cfa", BAYER)
def test_the_mosaic_in_a_sub_directory_is_found(save, cfa: str) -> None:
    mosaic = codes(30, 42)
    preview = {254: (LONG, (1,)), 256: (LONG, (4,)), 257: (LONG, (4,)), 258: (SHORT, (8, 8, 8)), 262: (SHORT, (2,))}
    preview |= {259: (SHORT, (1,)), 277: (SHORT, (3,)), 278: (LONG, (4,))}
    root = Image(
        fields=preview | dng_fields() | {271: (ASCII, tuple(b"Maker\0")), 274: (SHORT, (8,))},
        segments=[bytes(48)],
        subs=[
            Image(
                fields=preview | {256: (LONG, (40,)), 257: (LONG, (40,)), 278: (LONG, (40,))}, segments=[bytes(4800)]
            ),
            Image(fields=mosaic_fields(42, 30, cfa=cfa), segments=[mosaic.astype("<u2").tobytes()]),
        ],
        exif={33434: (RATIONAL, ((1, 250),)), 34855: (SHORT, (640,))},
    )
    path = save(tiff_bytes(root))
    image = read_raw(path)
    np.testing.assert_array_equal(image.mosaic, mosaic)
    assert (image.header.cfa, image.header.iso, image.header.exposure_s) == (cfa, 640.0, 0.004)
    assert (image.header.make, image.header.model, image.header.orientation) == ("Maker", "Built for tests", 8)
    assert read_with_libraw(path).cfa == cfa


def test_an_uncompressed_frame_is_not_copied(save) -> None:
    path = save(dng_bytes(codes(10, 12)))
    data = path.read_bytes()
    mosaic = decode(read_header(path), data)
    assert np.shares_memory(mosaic, np.frombuffer(data, dtype=np.uint8))


def test_adjacent_strips_are_not_copied_and_separate_ones_are(save) -> None:
    mosaic = codes(10, 12)
    fields = mosaic_fields(12, 10, rows_per_strip=5) | dng_fields()
    halves = [mosaic[:5].tobytes(), mosaic[5:].tobytes()]
    for gap, shared in ((b"", True), (b"gap!", False)):
        path = save(tiff_bytes(Image(fields=fields, segments=[halves[0] + gap, halves[1]])))
        data = path.read_bytes()
        decoded = decode(read_header(path), data)
        np.testing.assert_array_equal(decoded, mosaic)
        assert np.shares_memory(decoded, np.frombuffer(data, dtype=np.uint8)) is shared


@pytest.mark.parametrize("buffer", [bytes, bytearray, memoryview])
def test_any_buffer_is_decoded_read_only(save, buffer: type) -> None:
    mosaic = codes(10, 12)
    path = save(dng_bytes(mosaic))
    decoded = decode(read_header(path), buffer(path.read_bytes()))
    np.testing.assert_array_equal(decoded, mosaic)
    assert not decoded.flags.writeable


def test_black_level_by_site(save) -> None:
    extra = {50713: (SHORT, (2, 2)), 50714: (RATIONAL, ((129, 2), (65, 1), (66, 1), (1, 3)))}
    header = read_header(save(dng_bytes(codes(6, 6), extra=extra | {50717: (SHORT, (1023,))})))
    assert header.black_level.values == (64.5, 65.0, 66.0, 1 / 3)
    assert header.black_level.tag == "BlackLevel"
    assert header.white_level.values == (1023.0,) * 4
    assert dict(header.level_tags) == {"BlackLevel": (64.5, 65.0, 66.0, 1 / 3), "WhiteLevel": (1023.0,)}


@pytest.mark.parametrize(
    ("repeat", "values", "expected", "averaged"),
    [
        ((1, 1), (10,), (10, 10, 10, 10), False),
        ((1, 2), (10, 20), (10, 20, 10, 20), False),
        ((2, 1), (10, 20), (10, 10, 20, 20), False),
        ((1, 4), (10, 20, 30, 40), (20, 30, 20, 30), True),
        ((3, 1), (10, 20, 60), (30, 30, 30, 30), True),
    ],
)
def test_black_level_patterns_of_any_size(save, repeat, values, expected, averaged) -> None:
    header = read_header(save(dng_bytes(codes(6, 6), extra={50713: (SHORT, repeat), 50714: (SHORT, values)})))
    assert header.black_level.values == tuple(map(float, expected))
    assert ("black-level-averaged" in codes_of(header)) is averaged


@pytest.mark.parametrize("origin", [(0, 0), (1, 0), (0, 1), (1, 1)])
def test_patterns_count_from_the_active_area(save, origin: tuple[int, int]) -> None:
    mosaic = codes(12, 14)
    extra = {50829: (LONG, (*origin, 11, 13)), 50713: (SHORT, (2, 2)), 50714: (SHORT, (1, 2, 3, 4))}
    header = read_header(save(dng_bytes(mosaic, extra=extra, cfa="GRBG")))
    assert header.cfa == "GRBG"
    assert header.black_level.values == (1.0, 2.0, 3.0, 4.0)
    stored = shifted(header.cfa, rows=-origin[0], columns=-origin[1])
    assert shifted(stored, rows=origin[0], columns=origin[1]) == "GRBG"


def test_black_level_deltas_are_averaged_by_site_and_told(save) -> None:
    columns = tuple((value, 4) for value in (0, 4, 2, 8, 4, 12))  # even columns 0, 0.5, 1; odd 1, 2, 3
    rows = tuple((value, 1) for value in (1, -1, 1, -1))
    extra = {50714: (SHORT, (64,)), 50715: (SRATIONAL, columns), 50716: (SRATIONAL, rows)}
    header = read_header(save(dng_bytes(codes(4, 6), extra=extra)))
    assert header.black_level.values == (65.5, 67.0, 63.5, 65.0)
    told = [finding for finding in header.findings if finding.code == "black-level-delta-averaged"]
    assert [finding.severity for finding in told] == [Severity.INFO] * 2
    assert "from 0 to 3 DN" in told[0].message


def test_level_tags_that_make_no_sense_are_told_and_not_used(save) -> None:
    bad_black = read_header(save(dng_bytes(codes(4, 6), extra={50713: (SHORT, (2, 2)), 50714: (SHORT, (1, 2, 3))})))
    assert bad_black.black_level is None
    bad_delta = read_header(save(dng_bytes(codes(4, 6), extra={50715: (SRATIONAL, ((1, 1), (2, 1)))})))
    assert bad_delta.black_level.values == (0.0,) * 4
    assert codes_of(bad_black) == codes_of(bad_delta) == ["black-level-tag-damaged"]


def test_linearization_table_is_applied_and_clamped(save) -> None:
    table = tuple(int(value) for value in np.linspace(3, 900, 200).round())
    mosaic = codes(32, 40, bits=8)
    fields = mosaic_fields(40, 32, bits=8) | dng_fields() | {50712: (SHORT, table), 50717: (SHORT, (900,))}
    path = save(tiff_bytes(Image(fields=fields, segments=[mosaic.astype(np.uint8).tobytes()])))
    expected = np.asarray(table, dtype=np.uint16)[np.minimum(mosaic, 199)]
    np.testing.assert_array_equal(read_raw(path).mosaic, expected)
    np.testing.assert_array_equal(read_with_libraw(path).mosaic, expected)


def test_interleaved_rows_and_columns_are_put_in_order(save) -> None:
    mosaic = codes(7, 9)
    rows = [row for field in range(2) for row in range(field, 7, 2)]
    columns = [column for field in range(3) for column in range(field, 9, 3)]
    extra = {50975: (SHORT, (2,)), 52547: (SHORT, (3,)), 50829: (LONG, (1, 1, 6, 8))}
    image = read_raw(save(dng_bytes(mosaic[np.ix_(rows, columns)], extra=extra)))
    np.testing.assert_array_equal(image.mosaic, mosaic[1:6, 1:8])


def test_iso_exposure_and_temperature(save) -> None:
    exif = {
        33434: (RATIONAL, ((0, 1),)),
        34855: (SHORT, (65535,)),
        34867: (LONG, (102400,)),
        37888: (SRATIONAL, ((-25, 10),)),
    }
    fields = mosaic_fields(4, 4) | dng_fields()
    header = read_header(save(tiff_bytes(Image(fields=fields, segments=[bytes(32)], exif=exif))))
    assert (header.iso, header.exposure_s, header.temperature_c) == (102400.0, None, -2.5)
    in_first = fields | {34855: (SHORT, (0,)), 33434: (RATIONAL, ((1, 0),))}
    exif = {34855: (SHORT, (55,)), 33434: (RATIONAL, ((1, 8),))}
    header = read_header(save(tiff_bytes(Image(fields=in_first, segments=[bytes(32)], exif=exif))))
    assert (header.iso, header.exposure_s) == (55.0, 0.125)


def test_noise_profile_and_masked_areas(save) -> None:
    extra = {51041: (DOUBLE, (1e-5, 2e-9)), 50830: (LONG, (0, 0, 4, 1, 0, 7, 4, 8))}
    header = read_header(save(dng_bytes(codes(4, 8), extra=extra)))
    assert header.noise_profile == ((1e-5, 2e-9),)
    assert header.masked_areas == (Area(0, 0, 4, 1), Area(0, 7, 4, 8))
    outside = read_header(save(dng_bytes(codes(4, 8), extra={50830: (LONG, (0, 0, 4, 9))})))
    assert (outside.masked_areas, codes_of(outside)) == ((), ["masked-areas-damaged"])


LINEAR = mosaic_fields(4, 4, cfa="mono") | dng_fields() | {277: (SHORT, (3,)), 258: (SHORT, (16, 16, 16))}
XTRANS = mosaic_fields(4, 4) | dng_fields() | {33421: (SHORT, (6, 6)), 33422: (BYTE, (1,) * 36)}
QUAD = mosaic_fields(4, 4) | dng_fields() | {33422: (BYTE, (0, 1, 1, 1))}
VC5 = mosaic_fields(4, 4, compression=9) | dng_fields()
DCT = mosaic_fields(4, 4, compression=7, bits=8) | dng_fields()


@pytest.mark.parametrize(
    ("fields", "segment", "code"),
    [
        (LINEAR, bytes(96), "linear-dng"),
        (XTRANS, bytes(32), "unsupported-cfa"),
        (QUAD, bytes(32), "unsupported-cfa"),
        (VC5, bytes(32), "unsupported-compression"),
        (DCT, imagecodecs.jpeg8_encode(np.zeros((4, 4), np.uint8)), "lossy-compression"),
        (mosaic_fields(4, 4, compression=34892, bits=8) | dng_fields(), bytes(16), "lossy-compression"),
    ],
)
def test_what_must_not_be_measured_has_a_header_that_says_why(save, fields: dict, segment: bytes, code: str) -> None:
    path = save(tiff_bytes(Image(fields=fields, segments=[segment])))
    header = read_header(path)
    assert (header.width, header.height) == (4, 4)
    assert codes_of(header) == [code]
    for refuse in (lambda: require_measurable(header), lambda: decode(header, path.read_bytes())):
        with pytest.raises(UnsuitableFileError) as caught:
            refuse()
        assert caught.value.code == code


@pytest.mark.parametrize(
    "changes", [{258: (SHORT, (32,))}, {339: (SHORT, (3,))}, {266: (SHORT, (2,)), 258: (SHORT, (12,))}]
)
def test_samples_that_are_no_small_integers_are_unsuitable(save, changes: dict) -> None:
    fields = mosaic_fields(4, 4) | dng_fields() | changes
    with pytest.raises(UnsuitableFileError) as caught:
        read_header(save(tiff_bytes(Image(fields=fields, segments=[bytes(64)]))))
    assert caught.value.code == "unsupported-sample-format"


def test_a_truncated_file_is_told_from_its_header(save) -> None:
    whole = dng_bytes(codes(64, 64))
    fields = mosaic_fields(64, 64) | dng_fields()
    fields |= {273: (LONG, (len(whole),)), 279: (LONG, (8192,))}
    with pytest.raises(UnreadableFileError, match="bytes before its pixels do") as caught:
        read_header(save(tiff_bytes(Image(fields=fields))))
    assert caught.value.code == "file-truncated"


def test_a_file_truncated_after_its_header_was_read(save) -> None:
    path = save(dng_bytes(codes(64, 64)))
    header = read_header(path)
    with pytest.raises(UnreadableFileError) as caught:
        decode(header, path.read_bytes()[:4000])
    assert caught.value.code == "file-truncated"


def test_a_level_beyond_the_end_of_the_file_is_damage_not_a_default(save) -> None:
    data = bytearray(dng_bytes(codes(4, 4), extra={50714: (RATIONAL, ((64, 1),))}))
    entry = data.index(struct.pack("<HHI", 50714, RATIONAL, 1))
    data[entry + 8 : entry + 12] = struct.pack("<I", len(data) - 4)
    with pytest.raises(UnreadableFileError, match="BLACK_LEVEL") as caught:
        read_header(save(bytes(data)))
    assert caught.value.code == "file-damaged"


@pytest.mark.parametrize(
    "changes",
    [
        {256: (LONG, (0,))},
        {256: (LONG, (2**31,)), 257: (LONG, (2**31,))},
        {257: (LONG, (2**20,)), 256: (LONG, (500,)), 278: (LONG, (2**20,))},
        {278: (LONG, (1,))},
        {50829: (LONG, (0, 0, 5, 4))},
        {50829: (LONG, (2, 0, 2, 4))},
        {50829: (LONG, (0, 0))},
        {50975: (SHORT, (0,))},
    ],
)
def test_sizes_that_contradict_each_other_are_damage(save, changes: dict) -> None:
    with pytest.raises(UnreadableFileError) as caught:
        read_header(save(dng_bytes(codes(4, 4), extra=changes)))
    assert caught.value.code in {"file-damaged", "file-truncated"}


def test_a_raw_image_holds_header_and_mosaic(save) -> None:
    image = read_raw(save(dng_bytes(codes(6, 8))))
    assert isinstance(image, RawImage)
    assert image.mosaic.shape == (image.header.height, image.header.width)
