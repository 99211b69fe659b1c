"""Maps that hold a sensor's fixed pattern: linear combinations of the means of its bursts (METHOD 5.1, 5.2).

Three maps are made of the flats of one ISO that are neither saturated nor single frames: the *stack*, all flats
weighted by signal over variance, less the mean dark frame of their exposure; and the *slope* and the *intercept* of
each pixel's response against exposure. `floor_of` says how much temporal noise each keeps.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

from fullwell.fit.noise_floor import NoiseFloor, noise_floor
from fullwell.fit.variance_components import component
from fullwell.statistics.pixels import combine, line_coefficients
from fullwell.statistics.series import PlaneStatistics
from fullwell.workflow.measure.bursts import Burst, IsoBursts
from fullwell.workflow.measure.levels import ChannelLevels
from fullwell.workflow.measure.photon_transfer import ChannelTransfer
from fullwell.workflow.measure.rounding import phase_aware_dof
from fullwell.workflow.measure.transfer_points import admitted_tiles

STACK: Final = "stack"
SLOPE: Final = "slope"
INTERCEPT: Final = "intercept"
MADE_TOGETHER: Final = ((STACK,), (SLOPE, INTERCEPT))
"""Maps that are in memory at once."""
MOST_BEYOND: Final = 2.0
"""By what factor a dark frame may be longer exposed than the flats it is set against."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Combination:
    """One map of one channel: which bursts, and how much of the mean of each.

    Parameters
    ----------
    bursts
        What the map is made of.
    coefficients
        Factor of the mean of each burst, shape (bursts,).
    steady
        The unlit burst that tells the temporal row and column noise: in flats, a lamp that flickers over a shaded field
        looks like it. None where there is none.

    """

    bursts: tuple[Burst, ...]
    coefficients: NDArray[np.float64]
    steady: Burst | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class ChannelMaps:
    """The maps of one channel, by name.

    Parameters
    ----------
    flats
        Flats that take part, by ascending exposure.
    tiles
        Tiles that clip in none of them, shape (tile rows, tile columns).
    combinations
        What each map is made of; one that the bursts do not allow is missing.
    maps
        Those that were asked for, shape of the plane; the stack in DN, the slope in DN/s, the intercept in DN.

    """

    channel: str
    flats: tuple[Burst, ...]
    tiles: NDArray[np.bool_]
    combinations: Mapping[str, Combination]
    maps: Mapping[str, NDArray[np.float32]]

    @property
    def tile(self) -> int:
        """Edge of a tile [pixel of the plane]; there have to be flats."""
        return self.flats[0].plane(self.channel).tiles.size


@dataclass(frozen=True, slots=True, kw_only=True)
class IsoMaps:
    """The maps of every channel at one ISO, and the same as whole mosaics of shape (height, width)."""

    channels: tuple[ChannelMaps, ...]
    mosaics: Mapping[str, NDArray[np.float32]]

    def without_pixels(self) -> "IsoMaps":
        """Return what the maps were made of, without them."""
        return IsoMaps(channels=tuple(replace(one, maps={}) for one in self.channels), mosaics={})


def linear_flats(bursts: IsoBursts, level: ChannelLevels, transfer: ChannelTransfer) -> tuple[Burst, ...]:
    """Return the flats of two frames or more on the photon-transfer curve, no tile of which is clipped."""
    on_curve = [point.burst for point, good in zip(transfer.points, transfer.on_curve, strict=True) if good]
    return tuple(
        burst
        for burst in bursts.flats
        if burst.frames > 1
        and burst.sums is not None
        and any(burst is other for other in on_curve)
        and bool(admitted_tiles(burst.plane(level.channel), level.white_dn).all())
    )


def stacked(
    bursts: IsoBursts, flats: Sequence[Burst], channel: str, *, weights: NDArray[np.float64]
) -> Combination | None:
    """Return the mean flat less the mean dark frame of its exposure; None where no unlit burst is fit for that.

    The dark current of the mean flat is that of the flats' mean exposure, each counted by its share. Unlit bursts of
    two frames or more on either side of it are mixed to that exposure; with one side alone the nearest is taken. One
    much longer than all flats brings the pattern of its dark current with it and is not taken on its own.

    Parameters
    ----------
    bursts, flats, channel
        Of one ISO, and one channel.
    weights
        What the share of a flat is in proportion to, beside its signal: frames over variance, shape (flats,).

    """
    usable = _steady(bursts, channel)
    if not usable or not flats:
        return None
    exposures_s = np.array([burst.exposure_s for burst in flats])
    shortest = usable[0].plane(channel).mean
    shares = weights * np.maximum([burst.plane(channel).mean - shortest for burst in flats], 0.0)
    if not shares.any():
        return None
    shares /= shares.sum()
    darks = _darks_at(float(shares @ exposures_s), usable)
    if min(burst.exposure_s for burst, _ in darks) > MOST_BEYOND * exposures_s.max():
        return None
    return Combination(
        bursts=(*flats, *(burst for burst, _ in darks)),
        coefficients=np.append(shares, [-share for _, share in darks]),
        steady=usable[0],
    )


def _darks_at(exposure_s: float, usable: Sequence[Burst]) -> list[tuple[Burst, float]]:
    """Return what is mixed to a dark frame of an exposure, and how much of each; ``usable`` ascends by exposure."""
    shorter = [burst for burst in usable if burst.exposure_s <= exposure_s]
    longer = [burst for burst in usable if burst.exposure_s > exposure_s]
    if not (shorter and longer):
        return [(min(usable, key=lambda burst: (abs(burst.exposure_s - exposure_s), -burst.frames)), 1.0)]
    before = max(shorter, key=lambda burst: (burst.exposure_s, burst.frames))
    share = (exposure_s - before.exposure_s) / (longer[0].exposure_s - before.exposure_s)
    return [(before, 1.0 - share), (longer[0], share)]


def _steady(bursts: IsoBursts, channel: str) -> tuple[Burst, ...]:
    """Return the unlit bursts of two frames or more whose sums were kept."""
    if channel in bursts.black_clipped:
        return ()
    return tuple(burst for burst in bursts.unlit if burst.frames > 1 and burst.sums is not None)


def make_maps(
    bursts: IsoBursts,
    levels: Sequence[ChannelLevels],
    transfers: Sequence[ChannelTransfer],
    *,
    names: Sequence[str],
    workers: int,
) -> IsoMaps:
    """Make some maps of every channel at one ISO in one sweep over the sums."""
    flats = [linear_flats(bursts, level, transfer) for level, transfer in zip(levels, transfers, strict=True)]
    found = [_combinations(bursts, level, own) for level, own in zip(levels, flats, strict=True)]
    names = [name for name in names if any(name in one for one in found)]
    made = [one[name] for one in found for name in names if name in one]
    used = [burst for burst in (*bursts.flats, *bursts.unlit) if any(_takes(one, burst) for one in made)]
    sums = [burst.sums for burst in used if burst.sums is not None]
    mosaics: Mapping[str, NDArray[np.float32]] = {}
    if names:
        coefficients = np.array(
            [[[_coefficient(one.get(name), burst) for one in found] for burst in used] for name in names]
        )
        mosaics = dict(zip(names, combine(sums, coefficients, cell=bursts.cell, workers=workers), strict=True))
    channels = tuple(
        ChannelMaps(
            channel=level.channel,
            flats=own,
            tiles=_tiles(own, level),
            combinations=combinations,
            maps={name: _plane(mosaics[name], site, bursts.cell) for name in combinations if name in mosaics},
        )
        for site, (level, own, combinations) in enumerate(zip(levels, flats, found, strict=True))
    )
    return IsoMaps(channels=channels, mosaics=mosaics)


def floor_of(combination: Combination, channel: str) -> NoiseFloor:
    """Return the temporal noise that a map keeps of the frames it was made from."""
    planes = [burst.plane(channel) for burst in combination.bursts]
    told_by = planes if combination.steady is None else [combination.steady.plane(channel)]
    rows, columns = (
        [component(effect, plane.mean_squares, plane.shape) for plane in told_by] * (len(planes) // len(told_by))
        for effect in ("tv", "th")
    )
    return noise_floor(
        combination.coefficients,
        np.array([plane.tiles.temporal_variance for plane in planes]),
        np.array([_dof(plane) for plane in planes]),
        frames=[plane.frames for plane in planes],
        row_variances=rows,
        column_variances=columns,
    )


def _dof(plane: PlaneStatistics) -> NDArray[np.float64]:
    """Return the degrees of freedom of a plane's temporal variance by tile, lowered where rounding limits it."""
    whole = float(plane.n * (plane.frames - 1))
    known = phase_aware_dof(plane, plane.temporal_variance, whole) / whole
    return np.maximum(plane.tiles.temporal_dof * known, 1e-3)


def _combinations(bursts: IsoBursts, level: ChannelLevels, flats: Sequence[Burst]) -> dict[str, Combination]:
    """Return what the maps of one channel are made of."""
    found: dict[str, Combination] = {}
    planes = [burst.plane(level.channel) for burst in flats]
    weights = np.array([plane.frames / plane.temporal_variance for plane in planes if plane.temporal_variance > 0.0])
    if not flats or weights.size < len(flats):
        return found
    stack = stacked(bursts, flats, level.channel, weights=weights)
    if stack is not None:
        found[STACK] = stack
    steady = next(iter(_steady(bursts, level.channel)), None)
    exposures_s = [burst.exposure_s for burst in flats]
    if len(set(exposures_s)) > 1:
        slope, intercept = line_coefficients(exposures_s, weights.tolist())
        found[SLOPE] = Combination(bursts=tuple(flats), coefficients=slope, steady=steady)
        found[INTERCEPT] = Combination(bursts=tuple(flats), coefficients=intercept, steady=steady)
    return found


def _takes(combination: Combination, burst: Burst) -> bool:
    return any(burst is other for other in combination.bursts)


def _coefficient(combination: Combination | None, burst: Burst) -> float:
    """Return the factor of a burst's sum, 0 where the map does not hold it."""
    if combination is None:
        return 0.0
    pairs = zip(combination.bursts, combination.coefficients, strict=True)
    return next((float(factor) / burst.frames for other, factor in pairs if other is burst), 0.0)


def _tiles(flats: Sequence[Burst], level: ChannelLevels) -> NDArray[np.bool_]:
    if not flats:
        return np.zeros((0, 0), np.bool_)
    return np.logical_and.reduce([admitted_tiles(burst.plane(level.channel), level.white_dn) for burst in flats])


def _plane(mosaic: NDArray[np.float32], site: int, cell: int) -> NDArray[np.float32]:
    row, column = divmod(site, cell)
    return mosaic[row::cell, column::cell]
