import struct
from pathlib import Path

import numpy as np
import pytest
import tifffile
from dng_builder import BYTE, LONG, UNDEFINED, Image, dng_bytes, dng_fields, mosaic_fields, tiff_bytes
from hypothesis import given
from hypothesis import strategies as st

from fullwell.errors import UnreadableFileError, UnsuitableFileError
from fullwell.raw.cfa import BAYER, MONO, cell
from fullwell.raw.image import Area
from fullwell.raw.opcodes import (
    GainMap,
    Opcode,
    OpcodeList,
    gain_map_places,
    mosaic_gain_maps,
    opcode_bytes,
    parse_opcodes,
)
from fullwell.raw.open import read_raw
from fullwell.raw.rewriting import copy_with_gain_maps, read_opcodes
from fullwell.raw.write import DngExtras, write_dng
from libraw_oracle import read_with_libraw

UNKNOWN = {65000: (UNDEFINED, tuple(range(23))), 65001: (LONG, (7,))}
WARP = Opcode(id=1, version=0x01030000, flags=0, data=bytes(range(60)))


def maps(cfa: str, *, size: tuple[int, int], points: tuple[int, int] = (5, 7)) -> tuple[GainMap, ...]:
    values = np.random.default_rng(2).uniform(1.0, 3.0, (cell(cfa) ** 2, *points))
    return mosaic_gain_maps(values, cfa=cfa, size=size)


def same(ours: GainMap, theirs: GainMap) -> bool:
    return opcode_bytes([ours]) == opcode_bytes([theirs]) and bool(np.array_equal(ours.values, theirs.values))


def codes(shape: tuple[int, int] = (38, 46)) -> np.ndarray:
    return np.random.default_rng(1).integers(0, 1024, shape, dtype=np.uint16)


def test_a_gain_map_has_the_layout_of_the_specification() -> None:
    values = np.arange(6, dtype=np.float32).reshape(2, 3, 1)
    one = GainMap(
        top=1, left=0, bottom=40, right=60, row_pitch=2, column_pitch=2, spacing_v=1.0, spacing_h=0.5, values=values
    )
    parameters = struct.pack(">10I4dI6f", 1, 0, 40, 60, 0, 1, 2, 2, 2, 3, 1.0, 0.5, 0.0, 0.0, 1, *range(6))
    assert opcode_bytes([one]) == struct.pack(">5I", 1, 9, 0x01030000, 1, len(parameters)) + parameters
    assert parse_opcodes(opcode_bytes([])) == parse_opcodes(b"") == ()


opcodes = st.builds(
    Opcode,
    id=st.integers(0, 2**32 - 1).filter(lambda number: number != 9),
    version=st.integers(0, 2**32 - 1),
    flags=st.integers(0, 3),
    data=st.binary(max_size=40),
)
gain_maps = st.builds(
    lambda shape, seed, plane, flags: GainMap(
        top=0,
        left=1,
        bottom=9,
        right=9,
        plane=plane,
        spacing_v=0.25,
        spacing_h=0.5,
        origin_v=-0.1,
        values=np.random.default_rng(seed).normal(size=shape).astype(np.float32),
        flags=flags,
    ),
    shape=st.tuples(st.integers(1, 4), st.integers(1, 4), st.integers(1, 3)),
    seed=st.integers(0, 99),
    plane=st.integers(0, 2),
    flags=st.integers(0, 3),
)


@given(listed=st.lists(opcodes | gain_maps, max_size=4))
def test_a_list_comes_back_and_a_cut_one_is_refused(listed: list[Opcode | GainMap]) -> None:
    data = opcode_bytes(listed)
    again = parse_opcodes(data)
    assert opcode_bytes(again) == data
    assert [type(one) for one in again] == [type(one) for one in listed]
    for length in {1, len(data) // 2, len(data) - 1} - {0}:
        if listed:
            with pytest.raises(UnreadableFileError, match="opcode list"):
                parse_opcodes(data[:length])


@pytest.mark.parametrize("field", ["row_pitch", "spacing_v", "map_points"])
def test_a_gain_map_that_cannot_be_is_refused(field: str) -> None:
    data = bytearray(opcode_bytes(maps("RGGB", size=(40, 60))[:1]))
    offset = {"row_pitch": 24, "map_points": 32, "spacing_v": 40}[field]
    data[20 + offset : 20 + offset + 4] = {"row_pitch": b"\0\0\0\0", "map_points": b"\0\0\0\1"}.get(field, b"\xff" * 4)
    with pytest.raises(UnreadableFileError, match="opcode list"):
        parse_opcodes(bytes(data))


@given(down=st.integers(1, 9), across=st.integers(2, 9), height=st.integers(8, 60), width=st.integers(8, 60))
def test_a_grid_of_a_plane_is_that_plane_everywhere(down: int, across: int, height: int, width: int) -> None:
    """Linear interpolation leaves a linear surface as it is: factors at pixels are those of the surface."""
    rows, columns = gain_map_places(down, height), gain_map_places(across, width)
    slope = 0.0 if down == 1 else 0.02
    surface = 1.0 + slope * rows[:, None] - 0.01 * columns[None, :]
    one = mosaic_gain_maps(surface[np.newaxis], cfa=MONO, size=(height, width))[0]
    at_rows, at_columns = np.arange(height), np.arange(width)
    truth = 1.0 + slope * at_rows[:, None] - 0.01 * at_columns[None, :]
    found = one.at(at_rows, at_columns, size=(height, width))[:, :, 0]
    np.testing.assert_allclose(found, truth, rtol=0.0, atol=4.0 * np.finfo(np.float32).eps * np.abs(surface).max())


@pytest.mark.parametrize("compression", ["none", "lossless-jpeg"])
@pytest.mark.parametrize("cfa", [*BAYER, MONO])
def test_written_gain_maps_are_read_back(tmp_path: Path, cfa: str, compression: str) -> None:
    path, mosaic = tmp_path / "frame.dng", codes()
    written = maps(cfa, size=mosaic.shape)
    extras = DngExtras(gain_maps=written, as_shot_neutral=(0.5, 1.0, 0.75))
    options = {"cfa": cfa, "black_level": (64,), "white_level": 1023, "bit_depth": 10, "compression": compression}
    write_dng(path, mosaic, extras=extras, **options)
    lists = read_opcodes(path)
    assert lists[OpcodeList.OPCODE_LIST_1] == lists[OpcodeList.OPCODE_LIST_3] == ()
    assert all(map(same, lists[OpcodeList.OPCODE_LIST_2], written))
    assert len(lists[OpcodeList.OPCODE_LIST_2]) == cell(cfa) ** 2
    image = read_raw(path)
    np.testing.assert_array_equal(image.mosaic, mosaic)
    np.testing.assert_array_equal(read_with_libraw(path).mosaic, mosaic)
    assert image.header.as_shot_neutral == (() if cfa == MONO else (0.5, 1.0, 0.75))


def tags_of(path: Path) -> list[dict[int, tuple[object, ...]]]:
    """Return every tag of every directory as another library reads it."""
    with tifffile.TiffFile(path) as opened:
        pages = [opened.pages.first, *(opened.pages.first.pages or ())]
        return [
            {tag.code: (int(tag.dtype), tag.count, np.asarray(tag.value).tobytes()) for tag in page.tags}
            for page in pages
        ]


def sources(folder: Path) -> dict[str, Path]:
    """Return DNG files of every shape, with tags that nobody knows."""
    mosaic = codes()
    built = {}
    for order in "<>":
        built[f"first{order}"] = dng_bytes(mosaic, order=order, extra=UNKNOWN)
        preview = mosaic_fields(4, 4, bits=8, cfa="mono") | dng_fields() | {254: (LONG, (1,))} | UNKNOWN
        raw = Image(
            fields=mosaic_fields(46, 38) | {51008: (UNDEFINED, tuple(opcode_bytes([WARP])))},
            segments=[mosaic.astype(f"{order}u2").tobytes()],
        )
        small = Image(fields=mosaic_fields(4, 4, bits=8, cfa="mono") | {254: (LONG, (1,))}, segments=[bytes(16)])
        for name, subs in (("one", [raw]), ("two", [small, raw])):
            whole = Image(fields=preview, segments=[bytes(16)], subs=subs)
            built[f"{name} below{order}"] = tiff_bytes(whole, order=order)
    built["odd length"] = dng_bytes(mosaic, extra=UNKNOWN) + b"\0"
    paths = {}
    for index, (name, data) in enumerate(built.items()):
        paths[name] = folder / f"{index}.dng"
        paths[name].write_bytes(data)
    return paths


def test_a_copy_with_gain_maps_keeps_every_tag_and_pixel(tmp_path: Path) -> None:
    added = maps("RGGB", size=(38, 46))
    for name, source in sources(tmp_path).items():
        target = tmp_path / "copy.dng"
        before = source.read_bytes()
        assert copy_with_gain_maps(source, target, added) == 0, name
        assert source.read_bytes() == before
        lists = read_opcodes(target)
        assert len(lists[OpcodeList.OPCODE_LIST_2]) == 4, name
        assert all(map(same, lists[OpcodeList.OPCODE_LIST_2], added))
        assert lists[OpcodeList.OPCODE_LIST_1] == read_opcodes(source)[OpcodeList.OPCODE_LIST_1]
        ours, former = tags_of(target), tags_of(source)
        moved = {51009, 330}
        assert [{k: v for k, v in one.items() if k not in moved} for one in ours] == [
            {k: v for k, v in one.items() if k not in moved} for one in former
        ], name
        assert sum(51009 in one for one in ours) == 1
        np.testing.assert_array_equal(read_raw(target).mosaic, codes(), err_msg=name)
        np.testing.assert_array_equal(read_with_libraw(target).mosaic, codes(), err_msg=name)


def test_gain_maps_take_the_place_of_gain_maps_and_nothing_else(tmp_path: Path) -> None:
    source, target, again = (tmp_path / f"{name}.dng" for name in ("source", "target", "again"))
    phone = [WARP, *maps("RGGB", size=(38, 46), points=(2, 2)), WARP]
    source.write_bytes(dng_bytes(codes(), extra={51009: (BYTE, tuple(opcode_bytes(phone)))}))
    added = maps("RGGB", size=(38, 46))
    assert copy_with_gain_maps(source, target, added) == 4
    kept = read_opcodes(target)[OpcodeList.OPCODE_LIST_2]
    assert kept[:2] == (WARP, WARP)
    assert all(map(same, kept[2:], added))
    assert copy_with_gain_maps(target, again, added) == 4
    assert read_opcodes(again)[OpcodeList.OPCODE_LIST_2][:2] == (WARP, WARP)


def test_margins_stay_in_a_copy(tmp_path: Path) -> None:
    source, target, mosaic = tmp_path / "source.dng", tmp_path / "target.dng", codes()
    extras = DngExtras(active_area=Area(2, 4, 36, 44), masked_areas=(Area(0, 0, 2, 46),))
    options = {"cfa": "BGGR", "black_level": (64,), "white_level": 1023, "bit_depth": 10, "extras": extras}
    write_dng(source, mosaic, compression="lossless-jpeg", **options)
    copy_with_gain_maps(source, target, maps("BGGR", size=(34, 40)))
    np.testing.assert_array_equal(read_raw(target).mosaic, mosaic[2:36, 4:44])
    assert read_raw(target).header.masked_areas == extras.masked_areas


@pytest.mark.parametrize(
    ("data", "refusal"),
    [
        (b"II+\0" + bytes(60), UnsuitableFileError),
        (b"no TIFF at all", UnreadableFileError),
        (b"II*\0\x08\0\0\0\xff\xff", UnreadableFileError),
        (dng_bytes(codes(), extra={51009: (UNDEFINED, tuple(b"\0\0\0\1\0\0\0\x09"))}), UnreadableFileError),
    ],
)
def test_what_cannot_be_rewritten_is_refused(tmp_path: Path, data: bytes, refusal: type[Exception]) -> None:
    source, target = tmp_path / "source.dng", tmp_path / "target.dng"
    source.write_bytes(data)
    with pytest.raises(refusal):
        copy_with_gain_maps(source, target, maps("RGGB", size=(38, 46)))
    assert not target.exists()
