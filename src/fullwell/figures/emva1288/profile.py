"""Profiles: the middle, mean, largest and smallest line of an averaged stack (EMVA1288 7.7)."""

from dataclasses import dataclass

import numpy as np

from fullwell.figures.emva1288.sweep import Floats


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Profile:
    """Four lines along one axis of a plane [DN]."""

    middle: Floats
    mean: Floats
    maximum: Floats
    minimum: Floats


def profiles(plane: Floats) -> tuple[Profile, Profile]:
    """Return the horizontal profile, along a row, and the vertical one, along a column.

    Parameters
    ----------
    plane
        Shape (M, N), not filtered [DN].

    """
    rows, columns = plane.shape
    return (
        Profile(
            middle=plane[rows // 2].copy(),
            mean=plane.mean(axis=0),
            maximum=plane.max(axis=0),
            minimum=plane.min(axis=0),
        ),
        Profile(
            middle=plane[:, columns // 2].copy(),
            mean=plane.mean(axis=1),
            maximum=np.max(plane, axis=1),
            minimum=np.min(plane, axis=1),
        ),
    )
