"""Headerless files by arithmetic on long integers, independent of the code under test."""

import numpy as np

GROUPS = {10: 4, 12: 2, 14: 4}


def stored(
    mosaic: np.ndarray,
    *,
    bits: int,
    container: str,
    byte_order: str = "little",
    padding: int = 0,
    before: bytes = b"",
    after: bytes = b"",
) -> bytes:
    """Return a mosaic as the bytes of a file, each row padded by so many bytes of 0xA5."""
    rows = [row_bytes(row, bits=bits, container=container, byte_order=byte_order) for row in mosaic.tolist()]
    return before + b"".join(row + b"\xa5" * padding for row in rows) + after


def row_bytes(row: list[int], *, bits: int, container: str, byte_order: str) -> bytes:
    if container == "8":
        return bytes(row)
    if container == "16":
        return b"".join(value.to_bytes(2, byte_order) for value in row)
    if container == "packed-mipi":
        return b"".join(mipi(row[at : at + GROUPS[bits]], bits) for at in range(0, len(row), GROUPS[bits]))
    length = -(-bits * len(row) // 8)
    if container == "packed-lsb":
        return sum(value << bits * at for at, value in enumerate(row)).to_bytes(length, "little")
    number = 0
    for value in row:
        number = number << bits | value
    return (number << 8 * length - bits * len(row)).to_bytes(length, "big")


def mipi(group: list[int], bits: int) -> bytes:
    """Return one group of MIPI CSI-2, completed with zeros."""
    whole, extra = group + [0] * (GROUPS[bits] - len(group)), bits - 8
    low = sum((value & 2**extra - 1) << extra * at for at, value in enumerate(whole))
    return bytes(value >> extra for value in whole) + low.to_bytes(len(whole) * extra // 8, "little")


def scene(height: int, width: int, *, bits: int, mono: bool, seed: int) -> np.ndarray:
    """Return a picture with structure of every size, light from dark to bright, and shot noise."""
    rng = np.random.default_rng(seed)
    frequency = np.hypot(np.fft.fftfreq(height)[:, None], np.fft.rfftfreq(width))
    frequency[0, 0] = 1.0
    light = np.fft.irfft2(np.fft.rfft2(rng.normal(size=(height, width))) / frequency**1.2, (height, width))
    light = (light - light.min()) / np.ptp(light)
    if not mono:
        light[0::2, 0::2] *= 0.5
        light[1::2, 1::2] *= 0.6
    electrons = rng.poisson(3200.0 * light + 20.0) + rng.normal(0.0, 3.0, light.shape)
    top = 2**bits - 1
    return np.clip(np.round(top * (0.05 + 0.9 * electrons / 4000.0)), 0, top).astype(np.uint16)
