"""TIFF and DNG files built byte by byte, without any code of Fullwell: what its reader is tested against."""

import struct
from dataclasses import dataclass, field

import numpy as np

BYTE, ASCII, SHORT, LONG, RATIONAL, UNDEFINED, SRATIONAL, DOUBLE = 1, 2, 3, 4, 5, 7, 10, 12
FORMATS = {1: "B", 2: "B", 3: "H", 4: "I", 5: "II", 7: "B", 10: "ii", 12: "d"}
CFA_CODES = {"RGGB": (0, 1, 1, 2), "GRBG": (1, 0, 2, 1), "GBRG": (1, 2, 0, 1), "BGGR": (2, 1, 1, 0)}

type_and_values = tuple[int, tuple]


@dataclass
class Image:
    """One directory: its fields, its pixels, and the directories below it."""

    fields: dict[int, type_and_values]
    segments: list[bytes] = field(default_factory=list)
    tiled: bool = False
    subs: list["Image"] = field(default_factory=list)
    exif: dict[int, type_and_values] = field(default_factory=dict)


def tiff_bytes(image: Image, *, order: str = "<") -> bytes:
    """Return a TIFF file: pixels first, directories behind them, IFD0 last."""
    body = bytearray(struct.pack(f"{order}2sHI", b"II" if order == "<" else b"MM", 42, 0))
    start = _append(body, image, order)
    body[4:8] = struct.pack(f"{order}I", start)
    return bytes(body)


def _append(body: bytearray, image: Image, order: str) -> int:
    fields = dict(image.fields)
    if image.subs:
        fields[330] = (LONG, tuple(_append(body, sub, order) for sub in image.subs))
    if image.exif:
        fields[34665] = (LONG, (_directory(body, image.exif, order),))
    offsets = []
    for segment in image.segments:
        body += b"\0" * (-len(body) % 2)
        offsets.append(len(body))
        body += segment
    if offsets:
        fields[324 if image.tiled else 273] = (LONG, tuple(offsets))
        fields[325 if image.tiled else 279] = (LONG, tuple(len(segment) for segment in image.segments))
    return _directory(body, fields, order)


def _directory(body: bytearray, fields: dict[int, type_and_values], order: str) -> int:
    entries = b""
    for tag in sorted(fields):
        kind, values = fields[tag]
        encoded = b"".join(
            struct.pack(order + FORMATS[kind], *(value if isinstance(value, tuple) else (value,))) for value in values
        )
        if len(encoded) > 4:
            body += b"\0" * (-len(body) % 2)
            place = struct.pack(f"{order}I", len(body))
            body += encoded
        else:
            place = encoded.ljust(4, b"\0")
        entries += struct.pack(f"{order}HHI", tag, kind, len(values)) + place
    body += b"\0" * (-len(body) % 2)
    start = len(body)
    body += struct.pack(f"{order}H", len(fields)) + entries + struct.pack(f"{order}I", 0)
    return start


def mosaic_fields(
    width: int,
    height: int,
    *,
    cfa: str = "RGGB",
    bits: int = 16,
    compression: int = 1,
    rows_per_strip: int | None = None,
) -> dict[int, type_and_values]:
    """Return the fields of a raw directory in strips."""
    fields = {
        254: (LONG, (0,)),
        256: (LONG, (width,)),
        257: (LONG, (height,)),
        258: (SHORT, (bits,)),
        259: (SHORT, (compression,)),
        262: (SHORT, (34892 if cfa == "mono" else 32803,)),
        277: (SHORT, (1,)),
        278: (LONG, (rows_per_strip or height,)),
    }
    if cfa != "mono":
        fields |= {33421: (SHORT, (2, 2)), 33422: (BYTE, CFA_CODES[cfa])}
    return fields


def dng_fields() -> dict[int, type_and_values]:
    """Return the fields that make IFD0 a DNG's."""
    return {50706: (BYTE, (1, 4, 0, 0)), 50708: (ASCII, tuple(b"Built for tests\0"))}


def dng_bytes(
    mosaic: np.ndarray, *, order: str = "<", extra: dict[int, type_and_values] | None = None, **options: object
) -> bytes:
    """Return a DNG with one uncompressed 16-bit strip and any extra fields."""
    height, width = mosaic.shape
    fields = mosaic_fields(width, height, **options) | dng_fields() | (extra or {})
    return tiff_bytes(Image(fields=fields, segments=[mosaic.astype(f"{order}u2").tobytes()]), order=order)


def packed(mosaic: np.ndarray, bits: int) -> bytes:
    """Pack rows of samples, first bit highest, each row to whole bytes, by arithmetic on one long integer a row."""
    rows = []
    for row in mosaic.tolist():
        number = 0
        for value in row:
            number = (number << bits) | value
        missing = -(bits * len(row)) % 8
        rows.append((number << missing).to_bytes((bits * len(row) + missing) // 8, "big"))
    return b"".join(rows)


FLAT_TABLE = ((0, 0, 0, 0, 17, *[0] * 11), tuple(range(17)))
"""Seventeen codes of five bits: every category there is."""
STEEP_TABLE = ((1,) * 16, tuple(range(16)))
"""One code of each length from 1 to 16 bits, so that codes longer than any fast look-up occur."""


def lossless_jpeg(
    samples: np.ndarray, *, precision: int, predictor: int, table: tuple[tuple, tuple] = FLAT_TABLE, shift: int = 0
) -> bytes:
    """Return lossless JPEG (T.81 process 14) of samples, shape (lines, columns, components), with one Huffman table."""
    tables = (table,) * samples.shape[2]
    return lossless_jpeg_of_tables(samples, precision=precision, predictor=predictor, tables=tables, shift=shift)


def lossless_jpeg_of_tables(
    samples: np.ndarray, *, precision: int, predictor: int, tables: tuple[tuple[tuple, tuple], ...], shift: int = 0
) -> bytes:
    """Return the same with a Huffman table for each component."""
    lines, columns, components = samples.shape
    shifted = samples.astype(np.int64) >> shift
    bits = "".join(_coded(shifted, 1 << (precision - shift - 1), predictor, tables))
    bits += "1" * (-len(bits) % 8)
    coded = int(bits or "0", 2).to_bytes(len(bits) // 8, "big").replace(b"\xff", b"\xff\0")
    identifiers = range(1, components + 1)
    return b"".join(
        (
            b"\xff\xd8",
            *(_marker(0xC4, bytes((place, *table[0], *table[1]))) for place, table in enumerate(tables)),
            _marker(
                0xC3,
                struct.pack(">BHHB", precision, lines, columns, components)
                + b"".join(bytes((index, 0x11, 0)) for index in identifiers),
            ),
            _marker(
                0xDA,
                bytes(
                    (
                        components,
                        *(value for index in identifiers for value in (index, (index - 1) << 4)),
                        predictor,
                        0,
                        shift,
                    )
                ),
            ),
            coded,
            b"\xff\xd9",
        )
    )


def _marker(code: int, payload: bytes) -> bytes:
    return struct.pack(">BBH", 0xFF, code, len(payload) + 2) + payload


def _codes(table: tuple[tuple, tuple]) -> dict[int, str]:
    codes = {}
    code, remaining = 0, list(table[1])
    for length, count in enumerate(table[0], start=1):
        for _ in range(count):
            codes[remaining.pop(0)] = format(code, f"0{length}b")
            code += 1
        code <<= 1
    return codes


def _coded(samples: np.ndarray, first: int, predictor: int, tables: tuple[tuple[tuple, tuple], ...]) -> list[str]:
    all_codes = [_codes(table) for table in tables]
    coded = []
    lines, columns, components = samples.shape
    for line in range(lines):
        for column in range(columns):
            for component in range(components):
                plane, codes = samples[:, :, component], all_codes[component]
                predicted = _predicted(plane, line, column, first, predictor)
                difference = (int(plane[line, column]) - predicted + 32768) % 65536 - 32768
                if difference == -32768:
                    coded.append(codes[16])
                    continue
                category = abs(difference).bit_length()
                coded.append(codes[category])
                if category:
                    positive = difference if difference > 0 else difference + (1 << category) - 1
                    coded.append(format(positive, f"0{category}b"))
    return coded


def _predicted(plane: np.ndarray, line: int, column: int, first: int, predictor: int) -> int:
    if line == 0:
        return first if column == 0 else int(plane[0, column - 1])
    b = int(plane[line - 1, column])
    if column == 0:
        return b
    a, c = int(plane[line, column - 1]), int(plane[line - 1, column - 1])
    return {1: a, 2: b, 3: c, 4: a + b - c, 5: a + ((b - c) >> 1), 6: b + ((a - c) >> 1), 7: (a + b) >> 1}[predictor]
