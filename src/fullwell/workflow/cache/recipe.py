"""What the numbers of a series depend on besides the content of its files."""

import sys
from dataclasses import replace
from functools import cache
from importlib.metadata import version
from pathlib import Path
from typing import Final

from xxhash import xxh3_128

import fullwell
from fullwell.frames.series import Series
from fullwell.statistics.moments import Layout

_ROOMS: Final = ("kernels", "raw", "statistics", "workflow")
"""Whose code makes, or stores, the numbers of a series."""
_LIBRARIES: Final = ("numpy", "numba", "imagecodecs")
_NOWHERE: Final = Path()


def recipe(series: Series, layout: Layout, *, sums: bool, pairs: bool = False) -> str:
    """Return the hash of all that makes the numbers of a series but the content of its files.

    These are the code itself, the libraries, the layout, what the frames are, their names and their headers.

    Parameters
    ----------
    series
        Its frames.
    layout
        Of the mosaic.
    sums
        Whether the sums of its pixels are kept.
    pairs
        Whether its first two frames are looked at as a pair.

    """
    digest = xxh3_128(code())
    digest.update(repr((layout, series.kind.value, sums, pairs)).encode())
    for frame in sorted(series.frames, key=lambda one: one.name):
        digest.update(repr((frame.name, replace(frame.header, path=_NOWHERE))).encode())
    return digest.hexdigest()


@cache
def code() -> bytes:
    """Return a hash of Fullwell's code and of what it stands on: with another, numbers may be others."""
    digest = xxh3_128(fullwell.__version__.encode())
    digest.update(repr((sys.version_info[:2], sys.byteorder, [version(name) for name in _LIBRARIES])).encode())
    home = Path(fullwell.__file__).parent
    for room in _ROOMS:
        for file in sorted((home / room).rglob("*.py")):
            digest.update(file.read_bytes())
    return digest.digest()
