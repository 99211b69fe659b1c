"""Sums of bursts are kept pixel by pixel: in memory, or in files where they would take too much of it."""

import tempfile
from collections.abc import Collection, Mapping, Sequence
from pathlib import Path
from typing import Final

import numpy as np
from numpy.typing import NDArray

from fullwell.frames.series import Kind, Series, SeriesKey

MOST_KEPT_BYTES: Final = 1_000_000_000


class KeptSums:
    """What each pixel of a finished series sums up to over its frames, for series of some kinds.

    Parameters
    ----------
    series
        All series of the study.
    kinds
        Of which kinds sums are kept.
    least
        Frames that a series has at least for its sums to be kept.
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

    def __init__(
        self,
        series: Sequence[Series],
        *,
        kinds: Collection[Kind],
        pixels: int,
        folder: Path | None = None,
        least: int = 1,
    ) -> None:
        self._keys = {one.key for one in series if one.kind in kinds and len(one.frames) >= least}
        self._kept: dict[SeriesKey, NDArray[np.uint32]] = {}
        self._folder: Path | None = None
        total_bytes = len(self._keys) * pixels * np.dtype(np.uint32).itemsize
        if total_bytes > MOST_KEPT_BYTES:
            if folder is None:
                raise ValueError(
                    f"the sums of {len(self._keys)} series take {total_bytes / 1e9:.1f} GB: name a scratch folder"
                )
            self._folder = folder

    def keep(self, key: SeriesKey, sums: NDArray[np.uint32]) -> None:
        """Copy the sums of a series, if they are to be kept; from any thread, once for a series."""
        if key in self._keys:
            kept = sums.copy() if self._folder is None else _in_file(sums, self._folder)
            kept.flags.writeable = False
            self._kept[key] = kept

    def sums(self, series: Sequence[Series]) -> Mapping[SeriesKey, NDArray[np.uint32]]:
        """Return what was kept, read-only, in the order of the series."""
        return {one.key: self._kept[one.key] for one in series if one.key in self._kept}


def _in_file(sums: NDArray[np.uint32], folder: Path) -> NDArray[np.uint32]:
    """Write to a new file, which is faster than writing through a map, and map it."""
    with tempfile.NamedTemporaryFile(dir=folder, prefix="sums-", suffix=".u32", delete=False) as file:
        sums.tofile(file)
    return np.memmap(file.name, dtype=np.uint32, mode="r", shape=sums.shape).view(np.ndarray)
