"""Profiles: the middle, mean, largest and smallest line of an averaged stack (EMVA1288 7.7)."""

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from fullwell.figures.emva1288.sweep import Floats

Sums = NDArray[np.uint16 | np.uint32]

_BLOCK: Final = 64
"""Rows averaged at a time, so that they stay in the cache."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Profile:
    """Four lines along one axis of a plane [DN]."""

    middle: Floats
    mean: Floats
    maximum: Floats
    minimum: Floats


def profiles(sums: Sums, frames: int, *, less: tuple[Sums, int] | None = None) -> tuple[Profile, Profile]:
    """Return the horizontal profile, along a row, and the vertical one, along a column.

    Parameters
    ----------
    sums, frames
        Sums over the frames of a stack, shape (M, N), not filtered; and how many there are [DN].
    less
        The same of a stack whose average is subtracted.

    Examples
    --------
    >>> along_row, along_column = profiles(np.array([[2, 4], [6, 8], [4, 9]], np.uint32), 2)
    >>> along_row.middle.tolist(), along_row.mean.tolist(), along_column.maximum.tolist()
    ([3.0, 4.0], [2.0, 3.5], [2.0, 4.0, 4.5])

    """

    def average(place: slice | int, column: slice | int = np.s_[:]) -> Floats:
        found = sums[place, column] / float(frames)
        return found if less is None else found - less[0][place, column] / float(less[1])

    rows, columns = sums.shape
    total, highest, lowest = np.zeros(columns), np.full(columns, -np.inf), np.full(columns, np.inf)
    of_rows = np.empty((3, rows))
    for top in range(0, rows, _BLOCK):
        block = average(np.s_[top : top + _BLOCK])
        total += block.sum(axis=0)
        np.maximum(highest, block.max(axis=0), out=highest)
        np.minimum(lowest, block.min(axis=0), out=lowest)
        of_rows[:, top : top + _BLOCK] = block.mean(axis=1), block.max(axis=1), block.min(axis=1)
    mean, maximum, minimum = of_rows
    return (
        Profile(middle=average(rows // 2), mean=total / rows, maximum=highest, minimum=lowest),
        Profile(middle=average(np.s_[:], columns // 2), mean=mean, maximum=maximum, minimum=minimum),
    )
