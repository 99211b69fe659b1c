"""Hostile files made of honest ones: bytes flipped, ends cut off, tags rewritten."""

import struct
from collections.abc import Callable

import numpy as np

HOSTILE = (0, 1, 2, 3, 7, 255, 256, 32767, 65535, 65536, 100_000, 2**24, 2**31 - 1, 2**31, 2**32 - 1)
_TEXTS = (b"-1", b"0", b"99999", b"100000", b"4294967296", b"1e308", b"NaN", b"-99999999", b"''", b"T")


def flipped(data: bytes, rng: np.random.Generator) -> bytes:
    """Change a few bytes, most of them near the start, where headers are."""
    damaged = bytearray(data)
    for _ in range(int(rng.integers(1, 12))):
        reach = len(damaged) if rng.random() < 0.3 else min(len(damaged), 4096)
        damaged[int(rng.integers(0, reach))] = int(rng.choice([0, 1, 0x7F, 0x80, 0xFF, int(rng.integers(0, 256))]))
    return bytes(damaged)


def truncated(data: bytes, rng: np.random.Generator) -> bytes:
    """Cut the end off, at times after a change."""
    kept = data[: int(rng.integers(0, len(data)))]
    return flipped(kept, rng) if kept and rng.random() < 0.3 else kept


def zeroed(data: bytes, rng: np.random.Generator) -> bytes:
    """Overwrite a stretch with zeros, ones or noise."""
    damaged = bytearray(data)
    length = int(rng.integers(1, min(len(data), 4096) + 1))
    start = int(rng.integers(0, len(data) - length + 1))
    noise = rng.integers(0, 256, length, dtype=np.uint8).tobytes()
    damaged[start : start + length] = (bytes(length), b"\xff" * length, noise)[int(rng.integers(0, 3))]
    return bytes(damaged)


def retagged(data: bytes, rng: np.random.Generator) -> bytes:
    """Rewrite entries of TIFF directories, or numbers of text headers, or any words near the start."""
    if data[:2] in {b"II", b"MM"}:
        return _tiff_retagged(data, rng)
    if data[:6] in {b"SIMPLE", b"\x93NUMPY"} or data[:1] == b"P":
        return _text_retagged(data, rng)
    return _words_retagged(data, rng)


def _tiff_retagged(data: bytes, rng: np.random.Generator) -> bytes:
    order = "<" if data[:2] == b"II" else ">"
    damaged = bytearray(data)
    entries = _entries(data, order)
    for _ in range(int(rng.integers(1, 5)) if entries else 0):
        at = entries[int(rng.integers(0, len(entries)))]
        kind = int(rng.integers(0, 3))
        if kind == 0:
            struct.pack_into(f"{order}H", damaged, at + 2, int(rng.integers(0, 18)))
        else:
            struct.pack_into(f"{order}I", damaged, at + 4 * kind, int(rng.choice(HOSTILE)))
    return bytes(damaged) if entries else _words_retagged(data, rng)


def _entries(data: bytes, order: str) -> list[int]:
    """Return where the entries of all directories of a classic TIFF stand that can be reached."""
    found: list[int] = []
    waiting, seen = [struct.unpack_from(f"{order}I", data, 4)[0] if len(data) >= 8 else 0], set[int]()
    while waiting:
        at = waiting.pop()
        if at in seen or not 8 <= at <= len(data) - 2:
            continue
        seen.add(at)
        (count,) = struct.unpack_from(f"{order}H", data, at)
        for entry in range(at + 2, min(at + 2 + 12 * count, len(data) - 12), 12):
            found.append(entry)
            tag, _kind, values, value = struct.unpack_from(f"{order}HHII", data, entry)
            if tag in {330, 34665}:
                near = value + 4 * values <= len(data) and values > 1
                waiting += struct.unpack_from(f"{order}{values}I", data, value) if near else [value]
        if at + 2 + 12 * count + 4 <= len(data):
            waiting += struct.unpack_from(f"{order}I", data, at + 2 + 12 * count)
    return found


def _text_retagged(data: bytes, rng: np.random.Generator) -> bytes:
    head = bytearray(data[:2880])
    digits = [index for index, byte in enumerate(head) if 48 <= byte <= 57]
    for _ in range(int(rng.integers(1, 4)) if digits else 0):
        at = digits[int(rng.integers(0, len(digits)))]
        text = _TEXTS[int(rng.integers(0, len(_TEXTS)))]
        head[at : at + len(text)] = text[: len(head) - at]
    return bytes(head) + data[2880:]


def _words_retagged(data: bytes, rng: np.random.Generator) -> bytes:
    damaged = bytearray(data)
    for _ in range(int(rng.integers(1, 6)) if len(data) >= 8 else 0):
        at = int(rng.integers(0, min(len(data), 2048) - 3))
        struct.pack_into(rng.choice(["<I", ">I"]), damaged, at, int(rng.choice(HOSTILE)))
    return bytes(damaged)


MUTATIONS: tuple[Callable[[bytes, np.random.Generator], bytes], ...] = (flipped, truncated, zeroed, retagged)


def mutant(data: bytes, rng: np.random.Generator) -> bytes:
    """Return a damaged copy of a file."""
    return MUTATIONS[int(rng.integers(0, len(MUTATIONS)))](data, rng)
