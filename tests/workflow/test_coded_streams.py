"""Frames of lossless JPEG decoded strip by strip come to what their mosaics do, whatever is wrong with some."""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from xxhash import xxh3_128

from fullwell.frames.selection import Selection
from fullwell.frames.series import Frame, Kind, Study
from fullwell.frames.study import load_study
from fullwell.raw.lossless_jpeg import LosslessLines
from fullwell.raw.lossless_jpeg_writing import encode_lossless
from fullwell.raw.segments import Layout
from fullwell.raw.write import write_dng
from fullwell.workflow.coded_stream import decodes
from fullwell.workflow.reduce import Reduction, reduce_study

SHAPE = (70, 90)


def written(folder: Path, *, compression: str, cfa: str = "RGGB", tile: tuple[int, int] | None = None) -> Study:
    """Return a study of two series of seven frames; the same mosaics however they are stored."""
    rng = np.random.default_rng(17)
    for kind, level in (("dark", 60), ("flat", 600)):
        for frame in range(7):
            path = folder / kind / f"{frame}.dng"
            path.parent.mkdir(parents=True, exist_ok=True)
            write_dng(
                path,
                rng.poisson(level, SHAPE).astype(np.uint16),
                cfa=cfa,
                iso=100,
                exposure_s=0.01,
                black_level=(60,) * (1 if cfa == "mono" else 4),
                white_level=1023,
                bit_depth=10,
                compression=compression,
                tile=tile,
            )
    return load_study(folder, Selection())


def reduced(study: Study, *, workers: int = 2, tile: int = 10) -> Reduction:
    return reduce_study(study, workers=workers, tile=tile, keep=tuple(Kind))


def same(one: Reduction, other: Reduction, *, parts: Sequence[str] = ("statistics", "first")) -> bool:
    """Tell whether two studies come to the same sums and the same besides."""
    pixels = all(np.array_equal(one.sums[key], other.sums[key]) for key in other.sums)
    return pixels and all(repr(getattr(one, part)) == repr(getattr(other, part)) for part in parts)


@pytest.mark.parametrize("workers", [1, 2, 7])
@pytest.mark.parametrize(("cfa", "tile"), [("RGGB", None), ("mono", None), ("RGGB", (48, 64)), ("mono", (16, 16))])
def test_coded_frames_come_to_what_plain_ones_do(
    tmp_path: Path, workers: int, cfa: str, tile: tuple[int, int] | None
) -> None:
    plain = written(tmp_path / "plain", compression="none", cfa=cfa)
    coded = written(tmp_path / "coded", compression="lossless-jpeg", cfa=cfa, tile=tile)
    assert all(decodes(frame) for one in coded.series for frame in one.frames)
    assert not any(decodes(frame) for one in plain.series for frame in one.frames)
    assert same(reduced(coded, workers=workers), reduced(plain))


def test_lines_of_two_rows_come_to_the_same_where_tiles_are_an_odd_number_of_rows(tmp_path: Path) -> None:
    written(tmp_path / "plain", compression="none")
    written(tmp_path / "coded", compression="lossless-jpeg")
    plain, coded = (load_study(tmp_path / name, Selection(cfa="mono")) for name in ("plain", "coded"))
    assert same(reduced(coded, tile=5), reduced(plain, tile=5))


@pytest.mark.parametrize("tile", [None, (32, 48)])
@pytest.mark.parametrize("workers", [1, 2])
@pytest.mark.parametrize("broken", ["cut", "impossible"])
def test_a_frame_that_fails_on_its_way_is_left_out(
    tmp_path: Path, broken: str, workers: int, tile: tuple[int, int] | None
) -> None:
    study = written(tmp_path / "study", compression="lossless-jpeg", tile=tile)
    damaged = [tmp_path / "study" / name for name in ("dark/1.dng", "flat/4.dng")]
    for path in damaged:
        whole = bytearray(path.read_bytes())
        if broken == "cut":
            path.write_bytes(whole[: len(whole) - 2000])
        else:
            whole[-2000:] = b"\xff\x00" * 1000
            path.write_bytes(whole)
    found = reduced(study, workers=workers)
    assert [one.name for one in found.excluded] == ["dark/1.dng", "flat/4.dng"]
    contents = {one.name: (tmp_path / "study" / one.name).read_bytes() for one in found.excluded}
    assert all(found.hashes[name] == xxh3_128(content).hexdigest() for name, content in contents.items())
    for path in damaged:
        path.unlink()
    assert same(found, reduced(load_study(tmp_path / "study", Selection())), parts=("statistics",))


def test_rows_of_segments_may_lie_in_any_order(tmp_path: Path) -> None:
    study = written(tmp_path / "study", compression="lossless-jpeg", tile=(32, 48))
    expected = reduced(study)
    turned = replace(
        study, series=tuple(replace(one, frames=tuple(map(_upside_down, one.frames))) for one in study.series)
    )
    assert same(reduced(turned), expected)


def _upside_down(frame: Frame) -> Frame:
    """Lay the segments of a file behind it, the last one first."""
    header, layout = frame.header, frame.header.layout
    assert isinstance(layout, Layout)
    content, offsets = header.path.read_bytes(), []
    for offset, count in reversed(list(zip(layout.offsets, layout.counts, strict=True))):
        offsets.insert(0, len(content))
        content += content[offset : offset + count]
    header.path.write_bytes(content)
    return replace(frame, header=replace(header, layout=replace(layout, offsets=tuple(offsets))), size=len(content))


def test_a_segment_of_another_shape_is_decoded_as_a_whole(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    study = written(tmp_path / "study", compression="lossless-jpeg")
    expected = reduced(study)
    original = LosslessLines.__init__

    def misfits(self: LosslessLines, stream: memoryview, shape: tuple[int, int]) -> None:
        original(self, stream, shape)
        self.rows = 0

    monkeypatch.setattr(LosslessLines, "__init__", misfits)
    assert same(reduced(study), expected)


@pytest.mark.parametrize("predictor", [1, 7])
@pytest.mark.parametrize("steps", [(1, 2, 40), (43,), (20, 23)])
def test_lines_are_those_of_the_whole_scan(steps: tuple[int, ...], predictor: int) -> None:
    mosaic = np.random.default_rng(3).integers(0, 4096, (43, 60)).astype(np.uint16)
    stream = memoryview(encode_lossless(mosaic[..., np.newaxis], precision=12, predictor=predictor))
    lines = LosslessLines(stream, mosaic.shape)
    assert lines.rows == 1
    found = np.zeros((44, 60), np.uint16)
    at = 0
    for rows in steps:
        lines.read(found[at : at + rows + 1] if at else found[1 : rows + 1], above=at > 0)
        at += rows
    np.testing.assert_array_equal(found[1:], mosaic)


@pytest.mark.parametrize("compression", ["none", "lossless-jpeg"])
def test_a_plain_or_coded_file_that_is_empty_is_left_out(tmp_path: Path, compression: str) -> None:
    study = written(tmp_path / "study", compression=compression)
    (tmp_path / "study" / "flat" / "2.dng").write_bytes(b"")
    assert [one.code for one in reduced(study).excluded] == ["file-truncated"]
