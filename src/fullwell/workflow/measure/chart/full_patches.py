"""Patches whose pixels are full below the white level: hardly any noise is left of theirs."""

from collections.abc import Sequence
from dataclasses import replace
from typing import Final

import numpy as np

from fullwell.statistics.chart import PatchPoint
from fullwell.workflow.measure.chart.shots import Shots

LEFT: Final = 0.3
"""Share of the variance that the others tell, below which pixels are full; of half of them full, a third is left."""
_BRIGHT: Final = 0.05
"""Share of the range of levels above which noise is that of the light."""
_FEWEST: Final = 5
"""Points of a channel that tell how its variance grows with the level."""


def without_full(shots: Shots) -> Shots:
    """Return shots whose full patches are marked: they are on no curve, and tell where the pixels end."""
    full = [one for channel in shots.channels for one in _full(shots.points(channel))]
    if not full:
        return shots
    marked = {id(point) for point in full}
    scenes = tuple(
        replace(
            scene,
            exposures=tuple(
                replace(
                    exposure,
                    points=tuple(replace(one, full=True) if id(one) in marked else one for one in exposure.points),
                )
                for exposure in scene.exposures
            ),
        )
        for scene in shots.scenes
    )
    return replace(shots, scenes=scenes)


def _full(points: Sequence[PatchPoint]) -> list[PatchPoint]:
    """Return the brightest points of a channel as far as their variance is but a part of what the next ones tell.

    The variance of light grows with the level, and that of a pattern faster. The upper quartile of that growth is taken
    for it, since many patches may be full.
    """
    usable = sorted((point for point in points if point.admitted), key=lambda point: point.mean_dn)
    if len(usable) < _FEWEST:
        return []
    levels = np.array([point.mean_dn for point in usable]) - usable[0].mean_dn
    bright = levels > _BRIGHT * levels[-1]
    noise = np.array([point.noise_dn2 for point in usable])
    growth = float(np.quantile(noise[bright] / levels[bright], 0.75)) if bright.any() else 0.0
    left = noise < LEFT * growth * levels
    count = int(np.argmin(left[::-1])) if not left.all() else 0
    return usable[len(usable) - count :]
