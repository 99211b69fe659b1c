"""Makers' raw files built byte by byte, small and honest enough for LibRaw: no camera's picture is needed."""

import struct

import numpy as np
from dng_builder import ASCII, BYTE, LONG, RATIONAL, SHORT, UNDEFINED, Image, mosaic_fields, tiff_bytes


def _text(value: str) -> tuple[int, tuple[int, ...]]:
    return (ASCII, tuple(value.encode() + b"\0"))


def _first(make: str, model: str, sub: Image) -> Image:
    """Return a first directory with a thumbnail of no size and the raw picture below it."""
    fields = {254: (LONG, (1,)), 271: _text(make), 272: _text(model), 274: (SHORT, (6,))}
    exif = {33434: (RATIONAL, ((1, 250),)), 34855: (SHORT, (400,))}
    return Image(fields=fields, subs=[sub], exif=exif)


def _raw(mosaic: np.ndarray, segment: bytes, *, compression: int, bits: int) -> Image:
    height, width = mosaic.shape
    fields = mosaic_fields(width, height, bits=bits, compression=compression, cfa="RGGB")
    fields |= {33421: (SHORT, (2, 2)), 33422: (BYTE, (0, 1, 1, 2)), 262: (SHORT, (32803,))}
    return Image(fields=fields, segments=[segment])


def nef(mosaic: np.ndarray) -> bytes:
    """Return an uncompressed NEF of 16-bit words, big-endian."""
    raw = _raw(mosaic, mosaic.astype(">u2").tobytes(), compression=1, bits=16)
    return tiff_bytes(_first("NIKON CORPORATION", "NIKON D9999", raw), order=">")


def nef_with_compression(mosaic: np.ndarray, number: int) -> bytes:
    """Return the same with a maker note whose NEFCompression is ``number``."""
    note = b"Nikon\0\x02\x10\0\0" + struct.pack(">2sHIHHHIHHI", b"MM", 42, 8, 1, 0x0093, 3, 1, number, 0, 0)
    image = _first(
        "NIKON CORPORATION", "NIKON D9999", _raw(mosaic, mosaic.astype(">u2").tobytes(), compression=1, bits=16)
    )
    image.exif[37500] = (UNDEFINED, tuple(note))
    return tiff_bytes(image, order=">")


def arw(mosaic: np.ndarray, *, file_type: int) -> bytes:
    """Return an uncompressed ARW of 14 bits that says which type it is."""
    raw = _raw(mosaic, mosaic.astype("<u2").tobytes(), compression=1, bits=14)
    raw.fields[0x7000] = (SHORT, (file_type,))
    return tiff_bytes(_first("SONY", "ILCE-9999", raw))


def raf(mosaic: np.ndarray, *, rotated: bool = False) -> bytes:
    """Return the head of a RAF file with its own directory; no pixels that LibRaw would find."""
    directory = struct.pack(">IHHBB", 1, 0x0130, 2, 0, 0 if rotated else 8)
    pixels = mosaic.astype("<u2").tobytes()
    head = b"FUJIFILMCCD-RAW 0201FF383501FinePix".ljust(84, b"\0")
    places = struct.pack(">IIIIII", 0, 0, 120, len(directory), 120 + len(directory), len(pixels))
    return (head + places).ljust(120, b"\0") + directory + pixels
