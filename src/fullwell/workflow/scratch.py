"""Sums of bursts are kept pixel by pixel: in memory, or in files where they would take too much of it."""

import mmap
import tempfile
from pathlib import Path
from threading import Lock
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from fullwell.statistics.pixels import PixelSums

MOST_KEPT_BYTES: Final = 200_000_000
"""From where on sums that are kept go to files [byte]."""


class KeptSums:
    """Where the sums over frames of each pixel of finished series go.

    Its methods may be called from several threads at once.

    Parameters
    ----------
    series
        Of how many series sums are kept at once.
    pixels
        Pixels of a mosaic.
    folder
        Where files go once what is kept takes `MOST_KEPT_BYTES`; it must be there as long as the sums are read, and is
        the caller's to remove.

    Raises
    ------
    ValueError
        If files may be needed and there is no folder.

    """

    def __init__(self, *, series: int, pixels: int, folder: Path | None = None) -> None:
        self._folder = folder
        self._lock = Lock()
        self._kept: dict[int, int] = {}
        total_bytes = series * pixels * np.dtype(np.uint32).itemsize
        if total_bytes > MOST_KEPT_BYTES and folder is None:
            raise ValueError(f"the sums of {series} series take {total_bytes / 1e9:.1f} GB: name a scratch folder")

    def keep(self, sums: PixelSums, *, copied: bool = False) -> PixelSums:
        """Return the sums of a series read-only, a copy unless they are ``copied`` already."""
        with self._lock:
            fits = sum(self._kept.values()) + sums.nbytes <= MOST_KEPT_BYTES
            kept = (sums if copied else sums.copy()) if fits or self._folder is None else _in_file(sums, self._folder)
            self._kept[id(kept)] = kept.nbytes
        kept.flags.writeable = False
        return kept

    def roomy(self) -> bool:
        """Whether more may be kept ahead of time: in files, or while three quarters of the memory are not yet taken."""
        with self._lock:
            return self._folder is not None or 4 * sum(self._kept.values()) < 3 * MOST_KEPT_BYTES

    def forget(self, sums: PixelSums) -> None:
        """Hear that sums are no longer looked at, so that others may take their place."""
        with self._lock:
            self._kept.pop(id(sums), None)
        _let_go(sums)


def narrowed(sums: PixelSums) -> PixelSums:
    """Return sums in 16 bits where they fit, else as they are: they are read often, and memory is slow.

    Examples
    --------
    >>> narrowed(np.array([65535], np.uint32)).dtype, narrowed(np.array([65536], np.uint32)).dtype
    (dtype('uint16'), dtype('uint32'))

    """
    fits = sums.dtype != np.uint16 and sums.max(initial=0) <= np.iinfo(np.uint16).max
    return sums.astype(np.uint16) if fits else sums


def _let_go(sums: NDArray[Any]) -> None:
    """Give back the memory that a mapped file takes in this process; it is read again where it is looked at again."""
    base = sums.base
    while isinstance(base, np.ndarray) and base.base is not None:
        base = base.base
    if isinstance(base, mmap.mmap) and hasattr(mmap, "MADV_DONTNEED"):
        base.madvise(mmap.MADV_DONTNEED)


def _in_file(sums: PixelSums, folder: Path) -> PixelSums:
    """Write to a new file, which is faster than writing through a map, and map it."""
    with tempfile.NamedTemporaryFile(dir=folder, prefix="sums-", suffix=".raw", delete=False) as file:
        sums.tofile(file)
    return np.memmap(file.name, dtype=sums.dtype, mode="r", shape=sums.shape).view(np.ndarray)
