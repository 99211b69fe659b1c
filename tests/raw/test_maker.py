"""Raw files in their makers' own formats, read through LibRaw."""

import sys
from collections.abc import Callable
from pathlib import Path

import imagecodecs
import numpy as np
import pytest
from maker_builder import arw, nef, nef_with_compression, raf

from fullwell.errors import RawFileError, UnreadableFileError, UnsuitableFileError
from fullwell.raw import isolation
from fullwell.raw.embedded import ciff_names, fuji_is_rotated, wavelet_levels
from fullwell.raw.open import read_header, read_raw, require_measurable
from libraw_oracle import read_with_libraw


@pytest.mark.parametrize("name", ["CRW_0101.CRW", "CRW_0119.CRW"])
def test_a_powershot_is_what_its_readme_says(name: str, shared_data: Callable[[str], Path]) -> None:
    path = shared_data("makers") / name
    image = read_raw(path)
    header = image.header
    assert (header.width, header.height, header.cfa, header.bit_depth) == (2312, 1720, "RGGB", 10)
    assert header.black_level is not None
    assert header.white_level is not None
    assert (set(header.black_level.values), set(header.white_level.values)) == ({32.0}, {1023.0})
    assert header.iso == 50.0
    np.testing.assert_array_equal(image.mosaic, read_with_libraw(path).mosaic)
    assert not image.mosaic.flags.writeable
    assert all(0 <= area.top < area.bottom <= header.raw_height for area in header.masked_areas)
    assert header.masked_areas


def test_companded_codes_are_refused(shared_data: Callable[[str], Path]) -> None:
    header = read_header(shared_data("makers") / "P003908.KDC")
    assert (header.make, header.cfa, header.iso) == ("Eastman Kodak Company", "GRBG", 160.0)
    with pytest.raises(UnsuitableFileError) as caught:
        require_measurable(header)
    assert caught.value.code == "companded"


MOSAIC = np.random.default_rng(2).normal(600, 80, (240, 320)).round().astype(np.uint16)


def written(path: Path, data: bytes) -> Path:
    path.write_bytes(data)
    return path


@pytest.mark.parametrize("name", ["a.nef", "nef-by-another-name.bin"])
def test_a_built_nef_is_read_and_says_how_it_was_taken(name: str, tmp_path: Path) -> None:
    image = read_raw(written(tmp_path / name, nef(MOSAIC)))
    np.testing.assert_array_equal(image.mosaic, MOSAIC)
    header = image.header
    assert (header.make, header.model) == ("NIKON CORPORATION", "NIKON D9999")
    assert (header.cfa, header.iso, header.exposure_s, header.orientation) == ("RGGB", 400.0, 1 / 250, 6)


@pytest.mark.parametrize(
    ("data", "compression", "code"),
    [
        (nef_with_compression(MOSAIC, 3), "nikon-lossless", None),
        (nef_with_compression(MOSAIC, 4), "nikon-lossy", "lossy-compression"),
        (nef_with_compression(MOSAIC, 13), "nikon-high-efficiency", "lossy-compression"),
        (nef_with_compression(MOSAIC, 8), "nikon-small", "processed-rgb"),
        (arw(MOSAIC, file_type=0), "none", None),
        (arw(MOSAIC, file_type=3), "sony-lossless", None),
        (arw(MOSAIC, file_type=2), "sony-lossy", "lossy-compression"),
    ],
)
def test_what_coding_does_to_noise_is_told(data: bytes, compression: str, code: str | None, tmp_path: Path) -> None:
    header = read_header(written(tmp_path / ("a.nef" if data[:2] == b"MM" else "a.arw"), data))
    assert header.compression == compression
    assert [finding.code for finding in header.findings] == ([] if code is None else [code])
    if code is None:
        np.testing.assert_array_equal(read_raw(header.path).mosaic, MOSAIC)


def test_a_file_cut_short_is_named_so_even_where_libraw_goes_on(tmp_path: Path) -> None:
    for name, data in (("a.nef", nef(MOSAIC)), ("a.arw", arw(MOSAIC, file_type=0))):
        start = data.index(MOSAIC.astype(">u2" if name == "a.nef" else "<u2").tobytes()[:64])
        whole = bytearray(data)
        cut = whole[: start + 40_000]
        directories = whole[start + 2 * MOSAIC.size :]
        path = written(tmp_path / name, bytes(cut + directories))
        with pytest.raises(UnreadableFileError):
            read_raw(path)


def test_structures_of_other_makers_are_understood() -> None:
    assert fuji_is_rotated(raf(MOSAIC, rotated=True))
    assert not fuji_is_rotated(raf(MOSAIC))
    assert not fuji_is_rotated(nef(MOSAIC))
    cmp1 = b"CMP1" + bytes(26)
    assert [wavelet_levels(b"\0\0\0\x18ftypcrx " + cmp1 + bytes([levels])) for levels in (0, 3)] == [0, 3]
    assert ciff_names(b"II\x1a\0\0\0HEAPCCDR" + bytes(20) + b"Canon\0Canon EOS D30\0") == ("Canon", "Canon EOS D30")


@pytest.mark.parametrize(
    ("program", "said"),
    [
        ("import os; os._exit(3)", "it crashed"),
        ("while True: pass", "it took more than"),
        ("print('no JSON')", "crash"),
    ],
)
def test_a_decoder_that_dies_or_hangs_takes_nothing_with_it(
    program: str, said: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = written(tmp_path / "a.nef", nef(MOSAIC))
    (tmp_path / "hostile_decoder.py").write_text(f"{program}\n")
    with monkeypatch.context() as patched:
        patched.setattr(isolation, "_PROGRAM", "hostile_decoder")
        patched.setattr(isolation, "_idle", [])
        patched.setattr(isolation, "_BASE_S", 0.3)
        patched.setattr(isolation, "_S_PER_MB", 0.0)
        patched.syspath_prepend(tmp_path)
        with pytest.raises(UnreadableFileError, match=said) as caught:
            read_header(path)
    assert caught.value.code == "decoder-failed"
    assert read_header(path).model == "NIKON D9999"


@pytest.mark.skipif(sys.platform == "win32", reason="there are no process groups")
def test_an_interruption_from_the_terminal_does_not_reach_a_decoder(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """It goes to the group of the command; a decoder that dies of it would leave a good frame out."""
    reply = "{'alone': os.getpgrp() == os.getpid()}"
    (tmp_path / "telling.py").write_text(f"import json, os\ninput()\nprint(json.dumps({reply}), flush=True)\n")
    monkeypatch.setattr(isolation, "_PROGRAM", "telling")
    monkeypatch.setattr(isolation, "_idle", [])
    monkeypatch.setattr(isolation, "_MOST_FILES", 1)
    monkeypatch.syspath_prepend(tmp_path)
    assert isolation.ask("anything", b"") == {"alone": True}


def test_processor_time_is_limited_where_the_system_can(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    if sys.platform == "win32":
        pytest.skip("Windows limits no processor time: the clock does")
    (tmp_path / "endless.py").write_text(
        "from fullwell.raw import decoder_process\n"
        "def turn(data):\n    while True: pass\n"
        "decoder_process.TASKS = {'turn': turn}\ndecoder_process.main()\n"
    )
    monkeypatch.setattr(isolation, "_PROGRAM", "endless")
    monkeypatch.setattr(isolation, "_idle", [])
    monkeypatch.setattr(isolation, "_BASE_S", 0.5)
    monkeypatch.setattr(isolation, "_PATIENCE", 1000.0)
    monkeypatch.syspath_prepend(tmp_path)
    with pytest.raises(UnreadableFileError, match="it took more than"):
        isolation.ask("turn", b"")


def test_memory_that_a_file_asks_for_is_bounded() -> None:
    with pytest.raises(UnreadableFileError):
        isolation.ask("png", imagecodecs.png_encode(np.zeros((8, 8), np.uint16)), shape=[8, 9])
    bomb = imagecodecs.png_encode(np.zeros((10_000, 10_000), np.uint16), level=1)
    with pytest.raises(UnreadableFileError, match=r"claims more pixels|it crashed"):
        isolation.ask("png", bomb, shape=[10_000, 10_000], out=np.empty((1, 1), np.uint16))


def test_text_by_the_name_of_a_raw_file_is_named_damaged(tmp_path: Path) -> None:
    (tmp_path / "a.nef").write_text("not a photograph\n" * 100)
    with pytest.raises(RawFileError):
        read_header(tmp_path / "a.nef")
