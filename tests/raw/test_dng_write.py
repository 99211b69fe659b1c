import os
import tempfile
from pathlib import Path

import numpy as np
import pytest
import tifffile
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from fullwell.raw.cfa import BAYER, MONO, shifted
from fullwell.raw.image import Area
from fullwell.raw.open import read_header, read_raw
from fullwell.raw.write import DngExtras, write_dng
from libraw_oracle import read_with_libraw

COMPRESSIONS = ("none", "lossless-jpeg")


def codes(height: int, width: int, *, bits: int, seed: int = 1) -> np.ndarray:
    mosaic = np.random.default_rng(seed).integers(0, 1 << bits, (height, width), dtype=np.uint16)
    mosaic[0, :2] = 0, (1 << bits) - 1
    return mosaic


@pytest.mark.parametrize("compression", COMPRESSIONS)
@pytest.mark.parametrize("bits", [8, 10, 12, 14, 16])
@pytest.mark.parametrize("cfa", [*BAYER, MONO])
def test_libraw_and_fullwell_read_back_what_was_written(tmp_path: Path, cfa: str, bits: int, compression: str) -> None:
    path = tmp_path / "frame.dng"
    mosaic = codes(62, 94, bits=bits)
    black = (9.0,) if cfa == MONO else (9.0, 10.0, 11.0, 12.0)
    white = (1 << bits) - 5
    write_dng(
        path,
        mosaic,
        cfa=cfa,
        black_level=black,
        white_level=white,
        bit_depth=bits,
        iso=320,
        exposure_s=1 / 128,
        compression=compression,
    )
    ours, theirs = read_raw(path), read_with_libraw(path)
    np.testing.assert_array_equal(ours.mosaic, mosaic)
    np.testing.assert_array_equal(theirs.mosaic, mosaic)
    header = ours.header
    assert (header.cfa, header.iso, header.exposure_s) == (cfa, 320.0, 1 / 128)
    assert (theirs.cfa, theirs.iso, theirs.exposure_s) == (cfa, 320.0, 1 / 128)
    assert header.black_level.values == black == theirs.black_level
    assert header.white_level.values == (float(white),) * len(black)
    assert theirs.white_level == white
    assert (header.black_level.source, header.white_level.source) == ("metadata", "metadata")
    assert header.compression == compression


@pytest.mark.parametrize("compression", COMPRESSIONS)
@pytest.mark.parametrize("shape", [(600, 530), (512, 512), (513, 1025)])
def test_libraw_reads_tiles_whose_edges_are_padded(tmp_path: Path, shape: tuple[int, int], compression: str) -> None:
    path = tmp_path / "frame.dng"
    mosaic = codes(*shape, bits=12)
    options = {"cfa": "GBRG", "black_level": (256,), "white_level": 4095, "bit_depth": 12, "tile": (256, 512)}
    write_dng(path, mosaic, compression=compression, **options)
    np.testing.assert_array_equal(read_raw(path).mosaic, mosaic)
    np.testing.assert_array_equal(read_with_libraw(path).mosaic, mosaic)


@pytest.mark.parametrize("compression", COMPRESSIONS)
def test_libraw_agrees_within_an_even_active_area(tmp_path: Path, compression: str) -> None:
    path = tmp_path / "frame.dng"
    mosaic = codes(70, 90, bits=14)
    extras = DngExtras(active_area=Area(4, 6, 66, 88))
    options = {"cfa": "GRBG", "black_level": (1, 2, 3, 4), "white_level": 16000, "bit_depth": 14}
    write_dng(path, mosaic, compression=compression, extras=extras, **options)
    ours, theirs = read_raw(path), read_with_libraw(path)
    np.testing.assert_array_equal(ours.mosaic, mosaic[4:66, 6:88])
    np.testing.assert_array_equal(theirs.mosaic, ours.mosaic)
    assert ours.header.cfa == theirs.cfa == "GRBG"
    assert ours.header.black_level.values == theirs.black_level == (1.0, 2.0, 3.0, 4.0)
    assert (ours.header.raw_height, ours.header.raw_width) == (70, 90)


@pytest.mark.parametrize("cfa", BAYER)
@pytest.mark.parametrize("origin", [(0, 1), (1, 0), (1, 1), (3, 5)])
def test_patterns_count_from_the_active_area_as_libraw_counts_them(
    tmp_path: Path, cfa: str, origin: tuple[int, int]
) -> None:
    path = tmp_path / "frame.dng"
    mosaic = codes(70, 90, bits=14)
    extras = DngExtras(active_area=Area(*origin, 66, 86))
    write_dng(path, mosaic, cfa=cfa, black_level=(512,), white_level=16000, extras=extras)
    ours, theirs = read_raw(path), read_with_libraw(path)
    moved = (origin[0] % 2, origin[1] % 2)  # LibRaw begins at the next even row and column
    np.testing.assert_array_equal(theirs.mosaic, ours.mosaic[moved[0] :, moved[1] :])
    assert ours.header.cfa == cfa
    assert theirs.cfa == shifted(cfa, rows=moved[0], columns=moved[1])


@st.composite
def frames(draw: st.DrawFn) -> dict[str, object]:
    height, width = draw(st.integers(1, 40)), draw(st.integers(1, 40))
    top, left = draw(st.integers(0, height - 1)), draw(st.integers(0, width - 1))
    bottom, right = draw(st.integers(top + 1, height)), draw(st.integers(left + 1, width))
    cfa = draw(st.sampled_from((*BAYER, MONO)))
    return {
        "shape": (height, width),
        "area": Area(top, left, bottom, right),
        "cfa": cfa,
        "bits": draw(st.integers(8, 16)),
        "black": draw(
            st.lists(st.integers(0, 2**20).map(lambda n: n / 256), min_size=(n := 1 if cfa == MONO else 4), max_size=n)
        ),
        "compression": draw(st.sampled_from(COMPRESSIONS)),
        "seed": draw(st.integers(0, 2**32 - 1)),
        "flat": draw(st.booleans()),
    }


@settings(suppress_health_check=[HealthCheck.too_slow], max_examples=150)
@given(frame=frames())
def test_every_size_depth_order_and_area_round_trips(frame: dict) -> None:
    mosaic = (
        codes(*frame["shape"], bits=frame["bits"], seed=frame["seed"])
        if all(side > 1 for side in frame["shape"])
        else np.ones(frame["shape"], np.uint16)
    )
    if frame["flat"]:
        mosaic[...] = 3
    area = frame["area"]
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "frame.dng"
        write_dng(
            path,
            mosaic,
            cfa=frame["cfa"],
            black_level=frame["black"],
            white_level=(1 << frame["bits"]) - 1,
            bit_depth=frame["bits"],
            compression=frame["compression"],
            extras=DngExtras(active_area=area),
        )
        image = read_raw(path)
    np.testing.assert_array_equal(image.mosaic, mosaic[area.top : area.bottom, area.left : area.right])
    assert image.mosaic.flags.c_contiguous
    assert not image.mosaic.flags.writeable
    assert image.header.cfa == frame["cfa"]
    assert image.header.black_level.values == tuple(frame["black"])


def test_every_extra_comes_back(tmp_path: Path) -> None:
    path = tmp_path / "frame.dng"
    extras = DngExtras(
        noise_profile=((1e-5, 2e-8), (3e-5, 4e-8), (5e-5, 6e-8)),
        masked_areas=(Area(0, 0, 8, 2),),
        linearization_table=tuple(range(4096)),
        orientation=6,
        temperature_c=-12.5,
    )
    write_dng(
        path,
        codes(8, 8, bits=12),
        cfa="RGGB",
        black_level=(64,),
        white_level=4095,
        make="Ours",
        model="A",
        extras=extras,
    )
    header = read_header(path)
    assert (header.noise_profile, header.masked_areas) == (extras.noise_profile, extras.masked_areas)
    assert (header.orientation, header.temperature_c, header.make, header.model) == (6, -12.5, "Ours", "A")
    assert (header.iso, header.exposure_s) == (None, None)


def test_tifffile_reads_what_was_written(tmp_path: Path) -> None:
    path = tmp_path / "frame.dng"
    mosaic = codes(33, 47, bits=16)
    write_dng(path, mosaic, cfa="BGGR", black_level=(1.5, 2.5, 3.5, 4.5), white_level=65535, exposure_s=0.002867)
    with tifffile.TiffFile(path) as tiff:
        page = tiff.pages.first
        np.testing.assert_array_equal(page.asarray(), mosaic)
        assert page.tags["BlackLevel"].value == (3, 2, 5, 2, 7, 2, 9, 2)
        assert page.tags["ExifTag"].value["ExposureTime"] == (2867, 1_000_000)


def test_a_failed_write_leaves_the_old_file_and_nothing_else(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "frame.dng"
    path.write_bytes(b"old")

    def fail(*_: object) -> None:
        raise OSError("disk full")

    monkeypatch.setattr(os, "replace", fail)
    monkeypatch.setattr(Path, "replace", fail)
    with pytest.raises(OSError, match="disk full"):
        write_dng(path, codes(4, 4, bits=8), cfa="RGGB", black_level=(0,), white_level=255)
    assert [entry.name for entry in tmp_path.iterdir()] == ["frame.dng"]
    assert path.read_bytes() == b"old"


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"cfa": "RGBG"}, "cfa must be one of"),
        ({"black_level": (1, 2)}, "2 black levels"),
        ({"bit_depth": 10}, "do not fit 10 bits"),
        ({"tile": (16, 24)}, "multiples of 16"),
        ({"tile": (32, 16)}, "multiples of 16 within the mosaic"),
        ({"iso": 100.5}, "whole ISO speeds"),
    ],
)
def test_contradictions_are_refused(tmp_path: Path, changes: dict, message: str) -> None:
    options = {"cfa": "RGGB", "black_level": (0,), "white_level": 4095, "bit_depth": 12} | changes
    with pytest.raises(ValueError, match=message):
        write_dng(tmp_path / "frame.dng", codes(20, 20, bits=12), **options)
    assert not any(tmp_path.iterdir())
