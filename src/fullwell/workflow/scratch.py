"""Sums of bursts are kept pixel by pixel: in memory, or in files where they would take too much of it."""

import mmap
import tempfile
from pathlib import Path
from typing import Final

import numpy as np
from numpy.typing import NDArray

MOST_KEPT_BYTES: Final = 1_000_000_000


class KeptSums:
    """Where the sums over frames of each pixel of finished series go.

    Parameters
    ----------
    series
        Of how many series sums are kept.
    pixels
        Pixels of a mosaic.
    folder
        Where files go if all sums together take more than `MOST_KEPT_BYTES`; it must be there as long as the sums are
        read, and is the caller's to remove.

    Raises
    ------
    ValueError
        If files are needed and there is no folder.

    """

    def __init__(self, *, series: int, pixels: int, folder: Path | None = None) -> None:
        self._folder: Path | None = None
        total_bytes = series * pixels * np.dtype(np.uint32).itemsize
        if total_bytes > MOST_KEPT_BYTES:
            if folder is None:
                raise ValueError(f"the sums of {series} series take {total_bytes / 1e9:.1f} GB: name a scratch folder")
            self._folder = folder

    def keep(self, sums: NDArray[np.uint32]) -> NDArray[np.uint32]:
        """Return a copy of the sums of a series, read-only; from any thread."""
        kept = sums.copy() if self._folder is None else _in_file(sums, self._folder)
        kept.flags.writeable = False
        return kept


def let_go(sums: NDArray[np.uint32]) -> None:
    """Give back the memory that a mapped file takes in this process; it is read again where it is looked at again."""
    base = sums.base
    while isinstance(base, np.ndarray) and base.base is not None:
        base = base.base
    if isinstance(base, mmap.mmap) and hasattr(mmap, "MADV_DONTNEED"):
        base.madvise(mmap.MADV_DONTNEED)


def _in_file(sums: NDArray[np.uint32], folder: Path) -> NDArray[np.uint32]:
    """Write to a new file, which is faster than writing through a map, and map it."""
    with tempfile.NamedTemporaryFile(dir=folder, prefix="sums-", suffix=".u32", delete=False) as file:
        sums.tofile(file)
    return np.memmap(file.name, dtype=np.uint32, mode="r", shape=sums.shape).view(np.ndarray)
