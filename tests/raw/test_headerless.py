import re
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from headerless_writer import GROUPS, stored
from hypothesis import given, settings
from hypothesis import strategies as st

from fullwell.errors import UnreadableFileError, UsageError
from fullwell.kernels.unpacking_lsb import unpack_lsb_rows, unpack_lsb_rows_plain
from fullwell.kernels.unpacking_mipi import mipi_row_bytes, unpack_mipi_rows, unpack_mipi_rows_plain
from fullwell.raw.headerless import decode_headerless, read_headerless_header
from fullwell.raw.headerless_format import CONTAINERS, MIPI_SAMPLES, HeaderlessFormat, parse_format
from fullwell.raw.open import decode, read_header, read_raw

SharedData = Callable[[str], Path]


@st.composite
def containers(draw: st.DrawFn) -> tuple[str, int]:
    """Draw a container and the bits of a sample that it can hold."""
    container = draw(st.sampled_from(CONTAINERS))
    if container == "packed-mipi":
        return container, draw(st.sampled_from(sorted(GROUPS)))
    return container, draw(st.integers(1, 8 if container == "8" else 16))


@settings(max_examples=300)  # the first example waits for the compiler
@given(
    kind=containers(),
    shape=st.tuples(st.integers(1, 5), st.integers(1, 40)),
    byte_order=st.sampled_from(["little", "big"]),
    around=st.tuples(st.binary(max_size=9), st.binary(max_size=9)),
    padding=st.tuples(st.integers(0, 9), st.booleans()),
)
def test_every_container_and_depth_gives_back_what_was_stored(
    kind: tuple[str, int],
    shape: tuple[int, int],
    byte_order: str,
    around: tuple[bytes, bytes],
    padding: tuple[int, bool],
) -> None:
    (container, bits), (rows, columns), (before, after), (pad, last_too) = kind, shape, around, padding
    mosaic = np.random.default_rng(rows * columns).integers(0, 1 << bits, shape, dtype=np.uint16)
    whole = stored(mosaic, bits=bits, container=container, byte_order=byte_order, padding=pad, before=before)
    pixels = len(whole) - len(before)
    data = whole[: None if last_too or not pad else -pad] + after
    stated = HeaderlessFormat(
        width=columns,
        height=rows,
        bits=bits,
        container=container,
        byte_order=byte_order,
        offset=len(before),
        row_stride=pixels // rows if pad else 0,
        trailer=len(after),
    )
    assert len(data) in stated.file_sizes
    for out in (None, np.zeros((rows, columns), np.uint16)):
        np.testing.assert_array_equal(decode_headerless(stated, memoryview(data), out=out), mosaic)


@given(bits=st.sampled_from(sorted(GROUPS)), rows=st.integers(1, 4), columns=st.integers(1, 30), more=st.integers(0, 3))
def test_mipi_kernel_and_twin_are_equal_on_any_bytes(bits: int, rows: int, columns: int, more: int) -> None:
    row_bytes = mipi_row_bytes(columns, bits=bits) + more
    packed = np.random.default_rng(columns).integers(0, 256, rows * row_bytes, dtype=np.uint8)
    ours, plain = (np.zeros((rows, columns), np.uint16) for _ in range(2))
    unpack_mipi_rows(packed, ours, bits=bits, row_bytes=row_bytes)
    unpack_mipi_rows_plain(packed, plain, bits=bits, row_bytes=row_bytes)
    np.testing.assert_array_equal(ours, plain)


@given(bits=st.integers(1, 16), rows=st.integers(1, 4), columns=st.integers(1, 30), more=st.integers(0, 3))
def test_lsb_kernel_and_twin_are_equal_on_any_bytes(bits: int, rows: int, columns: int, more: int) -> None:
    row_bytes = (columns * bits + 7) // 8 + more
    packed = np.random.default_rng(columns).integers(0, 256, rows * row_bytes, dtype=np.uint8)
    ours, plain = (np.zeros((rows, columns), np.uint16) for _ in range(2))
    unpack_lsb_rows(packed, ours, bits=bits, row_bytes=row_bytes)
    unpack_lsb_rows_plain(packed, plain, bits=bits, row_bytes=row_bytes)
    np.testing.assert_array_equal(ours, plain)


def test_groups_of_mipi_stand_in_one_order_everywhere() -> None:
    assert dict(MIPI_SAMPLES) == GROUPS
    raw12 = np.zeros((1, 2), np.uint16)
    unpack_mipi_rows(np.array([0xAB, 0xDE, 0xFC], np.uint8), raw12, bits=12, row_bytes=3)
    assert [hex(int(code)) for code in raw12[0]] == ["0xabc", "0xdef"]


@pytest.mark.parametrize("unpack", [unpack_mipi_rows, unpack_mipi_rows_plain, unpack_lsb_rows, unpack_lsb_rows_plain])
def test_nothing_is_read_beyond_the_bytes(unpack: Callable[..., None]) -> None:
    out = np.zeros((2, 4), dtype=np.uint16)
    with pytest.raises(ValueError, match="11 bytes do not hold 2 rows"):
        unpack(np.zeros(11, dtype=np.uint8), out, bits=12, row_bytes=6)
    with pytest.raises(ValueError, match="do not hold 4 samples of 12 bits"):
        unpack(np.zeros(99, dtype=np.uint8), out, bits=12, row_bytes=5)


def test_words_in_our_order_are_not_copied(tmp_path: Path) -> None:
    data = np.arange(12, dtype="<u2").tobytes()
    path = tmp_path / "a.bin"
    path.write_bytes(data)
    header = read_header(path, headerless=parse_format("width=4,height=3,bits=16"))
    assert np.shares_memory(decode(header, data), np.frombuffer(data, np.uint8))
    assert not decode(header, data).flags.writeable


@st.composite
def formats(draw: st.DrawFn) -> HeaderlessFormat:
    container, bits = draw(containers())
    plain = HeaderlessFormat(
        width=draw(st.integers(1, 9999)),
        height=draw(st.integers(1, 9999)),
        bits=bits,
        container=container,
        byte_order=draw(st.sampled_from(["little", "big"])) if container == "16" else "little",
        offset=draw(st.integers(0, 9999)),
        trailer=draw(st.integers(0, 9999)),
        cfa=draw(st.sampled_from([None, "RGGB", "GRBG", "GBRG", "BGGR", "mono"])),
    )
    stride = draw(st.sampled_from([0, plain.row_bytes, plain.row_bytes + 7]))
    values = {name: getattr(plain, name) for name in plain.__dataclass_fields__}
    return HeaderlessFormat(**{**values, "row_stride": stride})


@given(stated=formats())
def test_a_format_reads_as_it_is_written(stated: HeaderlessFormat) -> None:
    assert parse_format(str(stated)) == stated


def test_the_option_of_the_contract() -> None:
    text = "width=1920,height=1080,bits=12,container=16,byte_order=little,offset=0,row_stride=0,cfa=BGGR"
    assert parse_format(text) == HeaderlessFormat(width=1920, height=1080, bits=12, cfa="BGGR")


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("", "width is missing"),
        ("width=8", "height is missing"),
        ("width=8,height", "'height' is not of the form key=value"),
        ("width=8,height=x", "height=x is not a whole number"),
        ("width=0,height=8", "0 x 8 pixels cannot be right"),
        ("width=8,height=8,depth=3", "depth is not known; the keys are width, height, bits"),
        ("width=8,width=9,height=8", "width is given twice"),
        ("width=8,height=8,bits=17", "bits=17 does not go with container=16; give 1 to 16"),
        ("width=8,height=8,bits=12,container=8", "bits=12 does not go with container=8; give 1 to 8"),
        ("width=8,height=8,bits=12,container=24", "container=24 is not known; give one of 8, 16, packed-mipi"),
        ("width=8,height=8,bits=13,container=packed-mipi", "give 10, 12, 14"),
        ("width=8,height=8,container=packed-lsb", "bits is missing"),
        ("width=8,height=8,byte_order=middle", "give little or big"),
        ("width=8,height=8,cfa=RGBG", "cfa=RGBG is not known; give one of RGGB"),
        ("width=8,height=8,row_stride=15", "row_stride=15 is too short: a row takes 16 bytes"),
        ("width=8,height=8,offset=-1", "offset=-1 cannot be right"),
    ],
)
def test_what_a_format_may_not_say(text: str, words: str) -> None:
    with pytest.raises(UsageError, match=re.escape(words)):
        parse_format(text)


def written(path: Path, size: int) -> Path:
    path.write_bytes(bytes(size))
    return path


@pytest.mark.parametrize(
    ("size", "text", "words"),
    [
        (1920 * 1080 * 2, "width=1920,height=1081,bits=12", "What fits: height=1080"),
        (1920 * 1080 * 2, "width=1910,height=1080,bits=12", "What fits: width=1920; row_stride=3840"),
        (1920 * 1080 * 3 // 2, "width=1920,height=1080,bits=12", "container=packed-mipi"),
        (1920 * 1080, "width=1920,height=1080,bits=12", "container=8,bits=8"),
        (1920 * 1080 * 2 + 512, "width=1920,height=1080,bits=12", "offset=512 if"),
        (1920 * 1080 * 6, "width=1920,height=1080,bits=12", "3 frames of this geometry in one file"),
        (2592 * 1944 * 5 // 4, "width=640,height=480,bits=12", "width=2592,height=1944,container=packed-mipi,bits=10"),
        (1000, "width=1920,height=1080,bits=12", "or the file is cut short"),
    ],
)
def test_a_wrong_geometry_is_called_wrong_with_what_fits(tmp_path: Path, size: int, text: str, words: str) -> None:
    path = written(tmp_path / "a.bin", size)
    with pytest.raises(UnreadableFileError) as caught:
        read_header(path, headerless=parse_format(text))
    assert caught.value.code == "geometry-mismatch"
    assert "the geometry is wrong" in caught.value.message
    assert f"the file has {size} " in caught.value.message
    assert words in caught.value.message


@given(size=st.integers(1, 5000), stated=formats())
def test_any_size_is_the_formats_or_refused(size: int, stated: HeaderlessFormat) -> None:
    if size in stated.file_sizes:
        assert read_headerless_header(Path("a"), stated, size=size, source="us").layout == stated
    else:
        with pytest.raises(UnreadableFileError, match=f"the file has {size} "):
            read_headerless_header(Path("a"), stated, size=size, source="us")


@pytest.mark.parametrize(
    ("codes", "text", "words"),
    [
        (np.array([1, 2, 0x0305], ">u2"), "width=3,height=1,bits=10", "With byte_order=big all codes fit"),
        (np.array([16, 4080, 65520], "<u2"), "width=3,height=1,bits=12", "multiple of 16"),
        (np.array([1, 2, 5000], "<u2"), "width=3,height=1,bits=12", "Give bits=13"),
        (np.array([1, 2, 255], "u1"), "width=3,height=1,bits=6,container=8", "Give bits=8"),
    ],
)
def test_codes_beyond_their_bits_are_called_wrong(tmp_path: Path, codes: np.ndarray, text: str, words: str) -> None:
    path = tmp_path / "a.bin"
    path.write_bytes(codes.tobytes())
    with pytest.raises(UnreadableFileError) as caught:
        read_raw(path, headerless=parse_format(text))
    assert (caught.value.code, words in caught.value.message) == ("geometry-wrong", True)


def test_a_file_with_a_header_is_read_by_it(tmp_path: Path) -> None:
    path = tmp_path / "a.npy"
    np.save(path, np.arange(16, dtype=np.uint16).reshape(4, 4))
    assert read_header(path, headerless=parse_format("width=9,height=9")).format == "npy"


def test_a_file_that_nobody_describes(tmp_path: Path) -> None:
    with pytest.raises(UnreadableFileError, match="--headerless width=") as caught:
        read_header(written(tmp_path / "a.bin", 100))
    assert caught.value.code == "not-a-raw-file"


def test_one_scene_in_four_orders_is_equal_plane_by_plane(shared_data: SharedData) -> None:
    planes = {}
    for cfa in ("RGGB", "GRBG", "GBRG", "BGGR"):
        path = shared_data(f"headerless/DSC_1339_768x512_{cfa.lower()}.raw")
        image = read_raw(path, headerless=parse_format(f"width=768,height=512,bits=14,cfa={cfa}"))
        assert (image.header.cfa, image.header.bit_depth, image.header.format) == (cfa, 14, "headerless")
        for site, letter in enumerate(cfa):
            channel = f"{letter}{cfa[:site].count(letter)}"  # the files hold the greens in the order they are met
            planes[cfa, channel] = image.mosaic[site // 2 :: 2, site % 2 :: 2]
    for (_cfa, channel), plane in planes.items():
        np.testing.assert_array_equal(plane, planes["RGGB", channel])
    assert (planes["RGGB", "R0"] != planes["RGGB", "B0"]).mean() > 0.9


@pytest.mark.parametrize(
    ("name", "text", "minimum", "maximum"),
    [
        ("Indoor1_2592x1536_8bit_GRBG.raw", "width=2592,height=1536,bits=8,container=8,cfa=GRBG", None, 255),
        ("BlackImage_1920x1080_12bits_BGGR.raw", "width=1920,height=1080,bits=12,cfa=BGGR", 0, None),
        ("openisp_1920x1080_10bit.raw", "width=1920,height=1080,bits=10", None, 1020),
    ],
)
def test_real_files(shared_data: SharedData, name: str, text: str, minimum: int | None, maximum: int | None) -> None:
    path = shared_data(f"headerless/{name}")
    stated = parse_format(text)
    mosaic = read_raw(path, headerless=stated).mosaic
    expected = np.fromfile(path, np.uint8 if stated.container == "8" else "<u2").reshape(stated.height, stated.width)
    np.testing.assert_array_equal(mosaic, expected)
    assert minimum is None or mosaic.min() == minimum
    assert maximum is None or mosaic.max() == maximum


def test_the_dark_frame_is_clipped_and_lacks_codes(shared_data: SharedData) -> None:
    path = shared_data("headerless/BlackImage_1920x1080_12bits_BGGR.raw")
    mosaic = read_raw(path, headerless=parse_format("width=1920,height=1080,bits=12,cfa=BGGR")).mosaic
    assert round(100.0 * np.mean(mosaic == 0), 2) == 31.65
    assert np.count_nonzero(mosaic > 50) == 772
    assert set(range(8)) - set(np.unique(mosaic)) == {1, 2, 3, 6, 7}
