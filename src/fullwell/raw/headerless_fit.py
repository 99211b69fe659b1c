"""What to say where a headerless file is not what it was said to be: what its size allows, what its codes show."""

from collections.abc import Iterator
from dataclasses import replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

from fullwell.raw.headerless_format import BYTE, LSB, MIPI, MIPI_SAMPLES, MSB, WORD, HeaderlessFormat, packed_bytes

COMMON_SIZES: Final = (
    *((640, 400), (640, 480), (640, 512), (768, 512), (800, 600), (1024, 768), (1024, 1024), (1280, 720)),
    *((1280, 800), (1280, 960), (1280, 1024), (1408, 1408), (1440, 1080), (1600, 1200), (1608, 1104), (1920, 1080)),
    *((1920, 1200), (1928, 1208), (1936, 1096), (1936, 1216), (2028, 1520), (2048, 1536), (2048, 2048), (2064, 1544)),
    *((2304, 1296), (2312, 1736), (2328, 1748), (2432, 2048), (2448, 2048), (2464, 2056), (2592, 1536), (2592, 1944)),
    *((2688, 1520), (2688, 1944), (2880, 1860), (3072, 2048), (3096, 2080), (3264, 2448), (3280, 2464), (3840, 2160)),
    *((4000, 3000), (4032, 3024), (4056, 3040), (4096, 2160), (4096, 3000), (4096, 3072), (4104, 3006), (4112, 3008)),
    *((4144, 2822), (4160, 3120), (4208, 3120), (4608, 2592), (4608, 3456), (4624, 3472), (4656, 3496), (5120, 5120)),
    *((5184, 3456), (5320, 4600), (5472, 3648), (5496, 3672), (6000, 4000), (6240, 4168), (6248, 4176), (7728, 5368)),
    *((7920, 6004), (8000, 6000), (8192, 6144), (9248, 6944), (9344, 7000), (9568, 6380), (14204, 10652)),
)
"""Pixels of sensors that many cameras have."""

STORED_AS: Final = (
    (WORD, 16),
    (BYTE, 8),
    *((MIPI, bits) for bits, _samples in MIPI_SAMPLES),
    *((packing, bits) for packing in (LSB, MSB) for bits in (10, 12, 14)),
)
"""Ways to store pixels that are looked for; in words of 16 bits, fewer may be used."""

_MOST_SHOWN: Final = 5
_LARGEST_HEADER: Final = 1 << 20


def mismatch(stated: HeaderlessFormat, *, size: int) -> str:
    """Return the sentences that call a geometry wrong, and what would fit.

    Parameters
    ----------
    stated
        How the file was said to be stored.
    size
        How long it is [byte].

    """
    needed = stated.file_sizes[0]
    much = f"{abs(size - needed)} {'more' if size > needed else 'fewer'}"
    fitting = list(dict.fromkeys(suggestions(stated, size=size)))[:_MOST_SHOWN]
    hint = f"What fits: {'; '.join(fitting)}. " if fitting else "No common size fits either. "
    cut = " or the file is cut short" if size < needed else ""
    return (
        f"the geometry is wrong{cut}: {stated} takes {needed} bytes, and the file has {size} ({much}). {hint}"
        "`fullwell inspect FILE --guess` looks at the content"
    )


def suggestions(stated: HeaderlessFormat, *, size: int) -> Iterator[str]:
    """Return changes to a format that make it fit a file's size, the smallest changes first."""
    yield from _other_side(stated, size=size)
    yield from _other_container(stated, size=size)
    yield from _common_sizes(stated, size=size)
    surplus = size - stated.file_sizes[0]
    if 0 < surplus <= _LARGEST_HEADER and surplus < stated.stride * stated.height:
        yield f"offset={stated.offset + surplus} if that is what comes before the pixels"
        yield f"trailer={stated.trailer + surplus} if it comes after them"
    frame = stated.stride * stated.height
    pixels = size - stated.offset - stated.trailer
    if pixels >= 2 * frame and pixels % frame == 0:
        yield f"{pixels // frame} frames of this geometry in one file, which must be split into one file each"
    for container, bits in STORED_AS:
        yield from _common_sizes(replace(stated, container=container, bits=bits), size=size, changed=True)


def _other_side(stated: HeaderlessFormat, *, size: int) -> Iterator[str]:
    pixels = size - stated.offset - stated.trailer
    if pixels <= 0:
        return
    rows, rest = divmod(pixels, stated.stride)
    if rest == 0 and rows != stated.height and stated.height / 3 <= rows <= stated.height * 3:
        yield f"height={rows}"
    stride, rest = divmod(pixels, stated.height)
    if rest or not stated.row_bytes / 3 <= stride <= stated.row_bytes * 3:
        return
    width = stride * 8 // stated.bits if stated.container in {MIPI, LSB, MSB} else stride // (1 + _in_words(stated))
    if packed_bytes(width, bits=stated.bits, container=stated.container) == stride:
        yield f"width={width}"
    if stride > stated.row_bytes:
        yield f"row_stride={stride}"


def _other_container(stated: HeaderlessFormat, *, size: int) -> Iterator[str]:
    for container, bits in STORED_AS:
        if container in {BYTE, WORD}:
            fewest = min(stated.bits, 8) if container == BYTE else stated.bits
            other = replace(stated, container=container, bits=fewest, row_stride=0)
        else:
            other = replace(stated, container=container, bits=bits, row_stride=0)
        if size in other.file_sizes:
            changed = f"container={container}"
            yield changed if other.bits == stated.bits else f"{changed},bits={other.bits}"


def _common_sizes(stated: HeaderlessFormat, *, size: int, changed: bool = False) -> Iterator[str]:
    """Return sizes of well-known sensors that fit; ``changed`` says that the container is another than was stated."""
    for width, height in COMMON_SIZES:
        for turned in ((width, height), (height, width)):
            other = replace(stated, width=turned[0], height=turned[1], row_stride=0)
            if size in other.file_sizes:
                sides = f"width={turned[0]},height={turned[1]}"
                yield f"{sides},container={stated.container},bits={stated.bits}" if changed else sides


def _in_words(stated: HeaderlessFormat) -> bool:
    return stated.container == WORD


def too_high(stated: HeaderlessFormat, mosaic: NDArray[np.uint16]) -> str:
    """Return the sentences that say what is wrong where codes are higher than their bits allow.

    Parameters
    ----------
    stated
        How the file was said to be stored.
    mosaic
        Its codes.

    """
    highest = int(mosaic.max())
    beyond = int(np.count_nonzero(mosaic >= 2**stated.bits))
    return (
        f"the geometry is wrong: {stated.bits} bits end at {2**stated.bits - 1}, and {beyond} of {mosaic.size} codes "
        f"lie above, up to {highest}. {_remedy(stated, mosaic)}"
    )


def _remedy(stated: HeaderlessFormat, mosaic: NDArray[np.uint16]) -> str:
    if stated.container == WORD:
        swapped = mosaic.byteswap()
        if int(swapped.max()) < 2**stated.bits:
            other = "big" if stated.byte_order == "little" else "little"
            return f"With byte_order={other} all codes fit"
        together = int(np.bitwise_or.reduce(mosaic, axis=None))
        unused = (together & -together).bit_length() - 1
        if unused >= 16 - stated.bits:
            return f"Every code is a multiple of {2**unused}: samples stand in the high bits, so give bits=16"
    needed = int(mosaic.max()).bit_length()
    return f"Give bits={needed} if width, height, offset and byte order are right; `--guess` looks at the content"
