"""Which series' sums of single pixels are wanted, before any has been read."""

from collections.abc import Iterable, Sequence
from itertools import chain
from typing import Final

from fullwell.frames.series import Kind, Series, SeriesKey

FEWEST_FRAMES: Final = 3
"""Of a stack that EMVA 1288 measures fixed pattern in: more than a pair."""
_NEAREST: Final = 2
"""Exposures of unlit series kept on either side of the flats'."""


def wanted(groups: Iterable[Sequence[Series]], *, stacks: bool) -> frozenset[SeriesKey]:
    """Return the series whose pixels are looked at one by one: of each ISO, those of its maps, or stacks alone."""
    if stacks:
        return frozenset(one.key for one in chain(*groups) if len(one.frames) >= FEWEST_FRAMES)
    return frozenset(key for group in groups for key in may_be_mapped(group))


def may_be_mapped(series: Sequence[Series]) -> frozenset[SeriesKey]:
    """Return the series of one ISO whose sums maps may be made of, before any has been read.

    These are all flats; the shortest unlit series; those that lie between the flats by exposure; and the two nearest
    on either side, so that one may turn out to be damaged without another reading. With several temperatures all are.
    """
    flats = [one for one in series if one.kind is Kind.FLAT]
    several = [one for one in series if len(one.frames) > 1]
    unlit = sorted((one for one in several if one.kind is not Kind.FLAT), key=lambda one: one.exposure_s or 0.0)
    if not flats or any(one.condition_c is not None for one in series):
        return frozenset(one.key for one in series)
    exposures_s = [one.exposure_s or 0.0 for one in flats]
    before = {one.exposure_s or 0.0 for one in unlit if (one.exposure_s or 0.0) < min(exposures_s)}
    beyond = {one.exposure_s or 0.0 for one in unlit if (one.exposure_s or 0.0) > max(exposures_s)}
    far = {*sorted(before)[1:-_NEAREST], *sorted(beyond)[_NEAREST:]}
    return frozenset(one.key for one in (*flats, *unlit) if (one.exposure_s or 0.0) not in far)
