from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from headerless_writer import scene, stored

from fullwell.raw.guess import better_geometry, guess_formats
from fullwell.raw.headerless_format import HeaderlessFormat, parse_format
from fullwell.raw.name_hints import hints_in
from fullwell.raw.periodicity import row_periods

SharedData = Callable[[str], Path]

REAL = {
    "Indoor1_2592x1536_8bit_GRBG.raw": ("width=2592,height=1536,bits=8,container=8", ("GRBG", "GBRG")),
    "BlackImage_1920x1080_12bits_BGGR.raw": ("width=1920,height=1080,bits=12", None),
    "openisp_1920x1080_10bit.raw": ("width=1920,height=1080,bits=10", ("RGGB", "BGGR")),
    "DSC_1339_768x512_rggb.raw": ("width=768,height=512,bits=14", ("RGGB", "BGGR")),
    "DSC_1339_768x512_grbg.raw": ("width=768,height=512,bits=14", ("GRBG", "GBRG")),
}


@pytest.mark.parametrize("name", REAL)
def test_real_files_are_found_without_their_names(shared_data: SharedData, name: str) -> None:
    text, greens = REAL[name]
    best, *others = guess_formats(shared_data(f"headerless/{name}").read_bytes())
    assert best.stated == parse_format(text)
    assert all(best.score < other.score for other in others)
    assert "neighbours leave" in best.reason
    if greens is not None:
        assert f"the CFA is {greens[0]} or {greens[1]}" in best.reason


def test_a_name_tells_what_content_cannot(shared_data: SharedData) -> None:
    path = shared_data("headerless/BlackImage_1920x1080_12bits_BGGR.raw")
    best = guess_formats(path.read_bytes(), name=path.name)[0]
    assert best.stated == parse_format("width=1920,height=1080,bits=12,cfa=BGGR")
    assert {"the name says this size", "the name says 12 bits", "the name says the CFA"} <= set(best.reason.split("; "))


def test_a_lying_name_is_not_believed() -> None:
    data = stored(scene(240, 320, bits=12, mono=True, seed=3), bits=12, container="16")
    best = guess_formats(data, name="frame_240x320_10bit.raw")[0]
    assert (best.stated.width, best.stated.height, best.stated.bits) == (320, 240, 12)


CASES = [
    ("8", 8, "little", {}),
    *(("16", bits, order, {}) for bits in (10, 12, 14, 16) for order in ("little", "big")),
    *(("packed-mipi", bits, "little", {}) for bits in (10, 12, 14)),
    *(("packed-lsb", bits, "little", {}) for bits in (10, 12)),
    *(("packed-msb", bits, "little", {}) for bits in (10, 12, 14)),
    ("16", 12, "little", {"before": bytes(range(256)) * 2}),
    ("16", 12, "little", {"after": bytes(range(256))}),
    ("packed-mipi", 10, "little", {"padding": 28}),
]


@pytest.mark.parametrize("mono", [False, True], ids=["bayer", "mono"])
@pytest.mark.parametrize(("container", "bits", "order", "around"), CASES)
def test_every_container_of_an_uncommon_size_is_found(container, bits, order, around, mono) -> None:
    width, height = 500, 376
    data = stored(
        scene(height, width, bits=bits, mono=mono, seed=bits),
        bits=bits,
        container=container,
        byte_order=order,
        **around,
    )
    best = guess_formats(data)[0].stated
    expected = HeaderlessFormat(
        width=width,
        height=height,
        bits=bits,
        container=container,
        byte_order=order,
        offset=len(around.get("before", b"")),
        trailer=len(around.get("after", b"")),
        row_stride=len(data) // height if "padding" in around else 0,
        cfa="mono" if mono else None,
    )
    assert best == expected


def test_left_aligned_words_are_called_so() -> None:
    mosaic = scene(240, 320, bits=12, mono=True, seed=4) << 4
    best = guess_formats(stored(mosaic, bits=16, container="16"))[0]
    assert (best.stated.width, best.stated.bits) == (320, 16)
    assert "every code is a multiple of 16: 12 bits in the high end of a word" in best.reason


def test_rows_repeat_after_a_row() -> None:
    data = stored(scene(400, 331, bits=8, mono=True, seed=5), bits=8, container="8")
    assert row_periods(np.frombuffer(data, np.uint8))[0].stride == 331


def test_noise_repeats_nowhere_and_is_guessed_all_the_same() -> None:
    data = np.random.default_rng(6).normal(64.0, 3.0, (480, 640)).round().astype("<u2").tobytes()
    assert all(period.strength < 15.0 for period in row_periods(np.frombuffer(data, np.uint8)))
    guesses = guess_formats(data)
    assert (guesses[0].stated.width, guesses[0].stated.height) in {(640, 480), (480, 640)}
    assert better_geometry(parse_format("width=480,height=640,bits=10"), data) is None


@pytest.mark.parametrize("size", [0, 1, 2, 3, 17, 100])
def test_hardly_any_bytes_hold_no_picture(size: int) -> None:
    assert all(sum(guess.stated.file_sizes) > 0 for guess in guess_formats(bytes(size)))


@pytest.mark.parametrize("shape", [(1, 1), (1, 500), (500, 1), (2, 16), (3, 40)])
def test_the_smallest_pictures_are_not_doubted(shape: tuple[int, int]) -> None:
    stated = HeaderlessFormat(height=shape[0], width=shape[1], bits=16)
    assert better_geometry(stated, bytes(2 * shape[0] * shape[1])) is None


@pytest.mark.parametrize(
    ("wrong", "right"),
    [
        ("width=376,height=500,bits=16", "width=500,height=376"),
        ("width=500,height=376,bits=16,byte_order=big", "byte_order=little"),
        ("width=1000,height=376,bits=8,container=8", "container=16"),
    ],
)
def test_a_geometry_of_the_right_size_is_doubted_for_its_pixels(wrong: str, right: str) -> None:
    data = stored(scene(376, 500, bits=14, mono=False, seed=7), bits=14, container="16")
    better = better_geometry(parse_format(wrong), data)
    assert better is not None
    assert right in str(better.stated)
    assert better_geometry(parse_format("width=500,height=376,bits=14"), data) is None


@pytest.mark.parametrize(
    ("name", "size", "bits", "cfa"),
    [
        ("a_640x480_mono_10bit.raw", (640, 480), 10, "mono"),
        ("a-4056X3040-RGGB.bin", (4056, 3040), None, "RGGB"),
        ("monochrome_0x12.raw", None, None, None),
        ("64bits.raw", None, None, None),
    ],
)
def test_hints(name: str, size: tuple[int, int] | None, bits: int | None, cfa: str | None) -> None:
    hints = hints_in(name)
    assert (hints.size, hints.bits, hints.cfa) == (size, bits, cfa)
