"""Codes of a mosaic moved to another scale: shifted by bits, or stretched from black 0 to white 65535.

Whatever a scale cannot hold is counted.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fullwell.errors import UnsuitableFileError
from fullwell.frames.series import CONTAINER_BITS, HIGHEST_CODE
from fullwell.raw.cfa import MONO, cell
from fullwell.render.demosaic import demosaic
from fullwell.render.tone import relative


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Codes:
    """A mosaic and its scale.

    Parameters
    ----------
    mosaic
        ``uint16``, shape (height, width) [DN].
    black_level
        Per CFA site, row-major; None where unknown [DN].
    white_level
        The same [DN].
    bit_depth
        Bits of the codes.

    """

    mosaic: NDArray[np.uint16]
    black_level: tuple[float, ...] | None
    white_level: tuple[float, ...]
    bit_depth: int


@dataclass(frozen=True, slots=True, kw_only=True)
class Clipped:
    """Samples that lay outside the scale from black to white, and now are at its ends."""

    below: int
    above: int
    of: int


def shifted(codes: Codes, bits: int) -> tuple[Codes, int]:
    """Return codes shifted by some bits with their levels, and how many lost bits that were set.

    Parameters
    ----------
    codes
        The mosaic.
    bits
        To the left above 0, to the right below.

    Raises
    ------
    UnsuitableFileError
        ``codes-too-high`` where codes would need more than 16 bits, ``no-bits-left`` where they would have none.

    Examples
    --------
    >>> mosaic = np.array([[64, 1020]], dtype=np.uint16)
    >>> codes = Codes(mosaic=mosaic, black_level=(64.0,), white_level=(1020.0,), bit_depth=10)
    >>> fewer, lost = shifted(codes, -3)
    >>> fewer.mosaic.tolist(), fewer.black_level, fewer.white_level, fewer.bit_depth, lost
    ([[8, 127]], (8.0,), (127.0,), 7, 1)

    """
    highest = int(codes.mosaic.max())
    depth = codes.bit_depth + bits
    if bits > 0 and max(highest.bit_length() + bits, depth) > CONTAINER_BITS:
        message = f"codes of {codes.bit_depth} bits cannot be shifted by {bits}: 16 bits do not hold them"
        raise UnsuitableFileError("codes-too-high", message)
    if depth < 1:
        raise UnsuitableFileError("no-bits-left", f"codes of {codes.bit_depth} bits shifted by {bits} are nothing")
    factor = 2.0**bits
    if bits >= 0:
        mosaic, lost = codes.mosaic << np.uint16(bits), 0
    else:
        mosaic = codes.mosaic >> np.uint16(-bits)
        lost = int(np.count_nonzero(codes.mosaic & np.uint16(2**-bits - 1)))
    black = codes.black_level and tuple(level * factor for level in codes.black_level)
    white = tuple(float(math.floor(level * factor)) for level in codes.white_level)
    return Codes(mosaic=mosaic, black_level=black, white_level=white, bit_depth=depth), lost


def stretched(codes: Codes, *, cfa: str, factors: Sequence[float]) -> tuple[Codes, Clipped]:
    """Return codes with black at 0 and white at 65535.

    Parameters
    ----------
    codes
        The mosaic; its black level must be known and lie below its white level.
    cfa
        Order at the top-left pixel, or ``mono``.
    factors
        White balance of each CFA site, at least 1; white divided by it becomes 65535.

    """
    period = cell(cfa)
    out = np.empty_like(codes.mosaic)
    below = above = 0
    every = np.arange(HIGHEST_CODE + 1, dtype=np.float64)
    for site, (black, white, factor) in enumerate(zip(*_levels(codes), factors, strict=True)):
        window = (slice(site // period, None, period), slice(site % period, None, period))
        plane = codes.mosaic[window]
        scaled = (every - black) * (factor * HIGHEST_CODE / (white - black))
        out[window] = np.rint(scaled.clip(0.0, HIGHEST_CODE)).astype(np.uint16)[plane]
        below += int(np.count_nonzero((every < black)[plane]))
        above += int(np.count_nonzero((scaled > HIGHEST_CODE)[plane]))
    sites = period * period
    whole = Codes(
        mosaic=out,
        black_level=(0.0,) * sites,
        white_level=(float(HIGHEST_CODE),) * sites,
        bit_depth=CONTAINER_BITS,
    )
    return whole, Clipped(below=below, above=above, of=out.size)


def coloured(codes: Codes, *, cfa: str, factors: Sequence[float]) -> tuple[NDArray[np.uint16], Clipped]:
    """Return a linear picture, red, green and blue at every pixel, black at 0 and white at 65535.

    Parameters
    ----------
    codes, factors
        As in `stretched`; codes below black are clipped after the colours are interpolated.
    cfa
        Order at the top-left pixel.

    Raises
    ------
    UnsuitableFileError
        ``no-colours`` where the mosaic is monochrome.

    """
    if cfa == MONO:
        raise UnsuitableFileError("no-colours", "a monochrome mosaic has no colours to interpolate; leave --demosaic")
    black, white = _levels(codes)
    light = relative(codes.mosaic, cfa=cfa, black_level=black, white_level=white)
    for site, factor in enumerate(factors):
        light[site // 2 :: 2, site % 2 :: 2] *= np.float32(factor)
    rgb = demosaic(light, cfa=cfa)
    clipped = Clipped(below=int(np.count_nonzero(rgb < 0)), above=int(np.count_nonzero(rgb > 1)), of=rgb.size)
    return np.rint(rgb.clip(0.0, 1.0) * np.float32(HIGHEST_CODE)).astype(np.uint16), clipped


def _levels(codes: Codes) -> tuple[tuple[float, ...], tuple[float, ...]]:
    """Return black and white per site, which a scale from black to white needs."""
    if codes.black_level is None:
        raise UnsuitableFileError("black-level-unknown", "nothing says its black level; give it with --black")
    if any(black >= white for black, white in zip(codes.black_level, codes.white_level, strict=True)):
        raise UnsuitableFileError(
            "levels-impossible", "its black level is not below its white level; give them with --black and --white"
        )
    return codes.black_level, codes.white_level
