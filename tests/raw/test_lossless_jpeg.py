import struct
from collections.abc import Callable

import imagecodecs
import numpy as np
import pytest
from dng_builder import FLAT_TABLE, STEEP_TABLE, lossless_jpeg, lossless_jpeg_of_tables
from hypothesis import given
from hypothesis import strategies as st

from fullwell.errors import UnreadableFileError, UnsuitableFileError
from fullwell.kernels.lossless_jpeg_encoding import count_categories, encode_scan, encode_scan_plain
from fullwell.kernels.lossless_jpeg_reference import decode_scan_plain
from fullwell.raw.lossless_jpeg import decode_lossless, decode_lossless_pair, parse_scan
from fullwell.raw.lossless_jpeg_writing import code_lengths, encode_lossless


def samples_of(*, lines: int, columns: int, components: int, precision: int, seed: int) -> np.ndarray:
    rng = np.random.default_rng(seed)
    steep = rng.integers(0, 1 << precision, (lines, columns, components))
    gentle = rng.normal(1 << (precision - 1), 3, (lines, columns, components)).round()
    return np.where(rng.random((lines, columns, components)) < 0.5, steep, gentle).astype(np.uint16)


@pytest.mark.parametrize("table", [FLAT_TABLE, STEEP_TABLE], ids=["flat", "steep"])
@pytest.mark.parametrize("components", [1, 2, 3])
@pytest.mark.parametrize("predictor", range(1, 8))
def test_kernel_and_twin_recover_what_was_coded(predictor: int, components: int, table: tuple) -> None:
    samples = samples_of(lines=7, columns=9, components=components, precision=14, seed=predictor)
    stream = lossless_jpeg(samples, precision=14, predictor=predictor, table=table)
    scan = parse_scan(memoryview(stream))
    assert (scan.width, scan.height, scan.predictor, len(scan.tables)) == (9, 7, predictor, components)
    parameters = {"width": 9, "height": 7, "start_value": 1 << 13, "predictor": predictor, "shift": 0}
    fast = decode_lossless(memoryview(stream), samples=samples.size)
    plain = decode_scan_plain(stream[scan.start : -2], (table,) * components, **parameters)
    np.testing.assert_array_equal(fast, samples.ravel())
    np.testing.assert_array_equal(plain, samples.reshape(7, -1))


@pytest.mark.parametrize("predictor", range(1, 8))
def test_agrees_with_an_independent_decoder(predictor: int) -> None:
    samples = samples_of(lines=16, columns=24, components=1, precision=12, seed=predictor)
    stream = lossless_jpeg(samples, precision=12, predictor=predictor)
    ours = decode_lossless(memoryview(stream), samples=16 * 24)
    np.testing.assert_array_equal(ours, imagecodecs.ljpeg_decode(stream).ravel())


@pytest.mark.parametrize("bits", [8, 10, 12, 14, 16])
def test_decodes_an_independent_encoder(bits: int) -> None:
    samples = np.random.default_rng(bits).integers(0, 1 << bits, (40, 64), dtype=np.uint16)
    stream = bytes(imagecodecs.ljpeg_encode(samples, bitspersample=bits))
    np.testing.assert_array_equal(decode_lossless(memoryview(stream), samples=samples.size), samples.ravel())


@pytest.mark.parametrize("predictor", range(1, 8))
@pytest.mark.parametrize("components", [1, 2, 3, 4])
def test_two_segments_decode_as_each_does(components: int, predictor: int) -> None:
    samples = [
        samples_of(lines=30, columns=53, components=components, precision=14, seed=10 * predictor + index)
        for index in range(2)
    ]
    tables = (FLAT_TABLE, STEEP_TABLE, FLAT_TABLE, STEEP_TABLE)[:components]
    streams = [
        memoryview(lossless_jpeg_of_tables(each, precision=14, predictor=predictor, tables=tables)) for each in samples
    ]
    decoded = decode_lossless_pair(streams, samples=[samples[0].size] * 2)
    for found, stream, each in zip(decoded, streams, samples, strict=True):
        np.testing.assert_array_equal(found, each.ravel())
        np.testing.assert_array_equal(found, decode_lossless(stream, samples=each.size))


@pytest.mark.parametrize("unlike", ["lines", "columns", "precision", "predictor", "shift", "components", "table"])
def test_two_unlike_segments_decode_too(unlike: str) -> None:
    kinds = {"lines": 9, "columns": 12, "components": 2, "precision": 12, "predictor": 1, "shift": 0}
    others = kinds | {"lines": 6, "columns": 5, "components": 1, "precision": 14, "predictor": 7, "shift": 2}
    second = kinds | ({unlike: others[unlike]} if unlike != "table" else {})
    streams, expected = [], []
    for kind, table in ((kinds, FLAT_TABLE), (second, STEEP_TABLE if unlike == "table" else FLAT_TABLE)):
        shape = {name: kind[name] for name in ("lines", "columns", "components")}
        samples = samples_of(**shape, precision=10, seed=1) << kind["shift"]
        options = {name: kind[name] for name in ("precision", "predictor", "shift")}
        streams.append(memoryview(lossless_jpeg(samples, **options, table=table)))
        expected.append(samples.ravel())
    for found, wanted in zip(
        decode_lossless_pair(streams, samples=[each.size for each in expected]), expected, strict=True
    ):
        np.testing.assert_array_equal(found, wanted)


@pytest.mark.parametrize("cut", [0, 1])
def test_either_of_two_segments_may_be_damaged(cut: int) -> None:
    samples = samples_of(lines=20, columns=20, components=2, precision=12, seed=1)
    streams = [lossless_jpeg(samples, precision=12, predictor=1) for _ in range(2)]
    streams[cut] = streams[cut][: len(streams[cut]) // 2]
    with pytest.raises(UnreadableFileError, match=r"ends early|impossible code"):
        decode_lossless_pair([memoryview(stream) for stream in streams], samples=[samples.size] * 2)


@given(
    seed=st.integers(0, 2**32 - 1), size=st.integers(0, 400), components=st.integers(1, 4), predictor=st.integers(1, 7)
)
def test_whatever_the_bytes_are_two_segments_end_as_each_does(
    *, seed: int, size: int, components: int, predictor: int
) -> None:
    rng = np.random.default_rng(seed)
    samples = samples_of(lines=9, columns=8, components=components, precision=12, seed=seed)
    stream = lossless_jpeg(samples, precision=12, predictor=predictor)
    start = parse_scan(memoryview(stream)).start
    noise = rng.choice(np.array([0, 1, 0x55, 0xAA, 0xFE, 0xFF], np.uint8), (2, size)).astype(np.uint8)
    streams = [memoryview(stream[:start] + bytes(each) + b"\xff\xd9") for each in noise]
    alone = [_outcome(lambda each=each: [decode_lossless(each, samples=samples.size)]) for each in streams]
    together = _outcome(lambda: decode_lossless_pair(streams, samples=[samples.size] * 2))
    if all(isinstance(each, list) for each in alone):
        np.testing.assert_array_equal(together, [each[0] for each in alone])
    else:
        assert together in alone


def _outcome(decode: Callable[[], list[np.ndarray]]) -> list[np.ndarray] | str:
    try:
        return decode()
    except UnreadableFileError as error:
        return str(error)


def test_difference_of_32768_has_no_additional_bits() -> None:
    samples = np.array([[[0], [32768], [0], [65535], [32767]]], dtype=np.uint16)
    stream = lossless_jpeg(samples, precision=16, predictor=1)
    np.testing.assert_array_equal(decode_lossless(memoryview(stream), samples=5), samples.ravel())


def test_point_transform_is_undone() -> None:
    samples = (np.arange(24, dtype=np.uint16).reshape(4, 6, 1)) << 2
    stream = lossless_jpeg(samples, precision=12, predictor=4, shift=2)
    np.testing.assert_array_equal(decode_lossless(memoryview(stream), samples=24), samples.ravel())


def test_a_stream_that_ends_early_is_damaged() -> None:
    samples = samples_of(lines=20, columns=20, components=1, precision=12, seed=1)
    stream = lossless_jpeg(samples, precision=12, predictor=1)
    with pytest.raises(UnreadableFileError, match="ends early") as caught:
        decode_lossless(memoryview(stream[: len(stream) // 2]), samples=400)
    assert caught.value.code == "file-damaged"


def test_a_stream_of_too_few_samples_is_damaged() -> None:
    stream = lossless_jpeg(np.zeros((4, 4, 1), np.uint16), precision=12, predictor=1)
    with pytest.raises(UnreadableFileError, match="16 pixels of 17"):
        decode_lossless(memoryview(stream), samples=17)


def test_an_impossible_code_is_damaged() -> None:
    samples = np.zeros((4, 100, 1), np.uint16)
    stream = bytearray(lossless_jpeg(samples, precision=12, predictor=1))
    stream[-4:-2] = b"\xef\xef"  # 11101 is none of the seventeen codes of five bits
    with pytest.raises(UnreadableFileError, match="impossible code"):
        decode_lossless(memoryview(bytes(stream)), samples=400)


@pytest.mark.parametrize("marker", [0xC0, 0xC1, 0xC2])
def test_cosine_transform_is_lossy(marker: int) -> None:
    stream = bytearray(lossless_jpeg(np.zeros((4, 4, 1), np.uint16), precision=12, predictor=1))
    stream[stream.index(b"\xff\xc3") + 1] = marker
    with pytest.raises(UnsuitableFileError) as caught:
        parse_scan(memoryview(bytes(stream)))
    assert caught.value.code == "lossy-compression"


def test_restart_intervals_are_refused() -> None:
    stream = lossless_jpeg(np.zeros((4, 4, 1), np.uint16), precision=12, predictor=1)
    with_restart = stream[:2] + struct.pack(">BBHH", 0xFF, 0xDD, 4, 8) + stream[2:]
    with pytest.raises(UnsuitableFileError, match="restart") as caught:
        parse_scan(memoryview(with_restart))
    assert caught.value.code == "unsupported-compression"


@pytest.mark.parametrize("predictor", [1, 7])
@pytest.mark.parametrize("components", [1, 2])
def test_encoding_kernel_equals_its_twin(components: int, predictor: int) -> None:
    samples = samples_of(lines=9, columns=11, components=components, precision=16, seed=predictor)
    codes, lengths = np.arange(17), np.full(17, 5)
    counts = count_categories(samples, start_value=1 << 15, predictor=predictor)
    size = int((counts * (lengths + np.arange(17) % 16)).sum())
    options = {"codes": codes, "lengths": lengths, "start_value": 1 << 15, "predictor": predictor}
    assert encode_scan(samples, size_bits=size, **options) == encode_scan_plain(samples, **options)


@given(
    lines=st.integers(1, 20),
    columns=st.integers(1, 20),
    components=st.integers(1, 2),
    precision=st.integers(8, 16),
    predictor=st.sampled_from((1, 7)),
    spread=st.floats(0, 5e4),
    seed=st.integers(0, 2**32 - 1),
)
def test_what_is_encoded_decodes_here_and_elsewhere(
    *, lines: int, columns: int, components: int, precision: int, predictor: int, spread: float, seed: int
) -> None:
    noise = np.random.default_rng(seed).normal(0, spread, (lines, columns, components)).astype(np.int64)
    samples = ((noise + 300) % (1 << precision)).astype(np.uint16)
    stream = encode_lossless(samples, precision=precision, predictor=predictor)
    np.testing.assert_array_equal(decode_lossless(memoryview(stream), samples=samples.size), samples.ravel())
    np.testing.assert_array_equal(imagecodecs.ljpeg_decode(stream).ravel(), samples.ravel())


def test_codes_are_short_enough_however_rare_their_categories() -> None:
    fibonacci = [1, 1]
    while len(fibonacci) < 17:
        fibonacci.append(fibonacci[-1] + fibonacci[-2])
    for counts in (fibonacci, fibonacci[::-1], [1] * 16 + [10**9], [0] * 5 + [7] + [0] * 11):
        lengths = code_lengths(counts)
        assert all(1 <= length <= 16 for count, length in zip(counts, lengths, strict=True) if count)
        assert sum(2.0**-length for length in lengths if length) < 1.0  # the code of ones alone stays free


@pytest.mark.parametrize("fewer", [0, 6])
def test_whole_streams_are_decoded_where_they_are_wanted(fewer: int) -> None:
    samples = (np.arange(24, dtype=np.uint16).reshape(4, 6, 1)) << 2
    stream = lossless_jpeg(samples, precision=12, predictor=4, shift=2)
    out = np.zeros((4, 6), np.uint16) if not fewer else np.zeros((3, 6), np.uint16)
    found = decode_lossless(memoryview(stream), samples=out.size, out=out)
    np.testing.assert_array_equal(found[: out.size], samples.ravel()[: out.size])
    assert np.may_share_memory(found, out) is (not fewer)
