"""A second look at two unlit and two lit frames of each ISO: neighbours' noise, and masked pixels."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from fullwell.errors import RawFileError
from fullwell.frames.series import Frame, Kind
from fullwell.raw.open import decode, read_bytes
from fullwell.statistics.first_look import middle
from fullwell.statistics.noise_correlation import NoiseCorrelation, noise_correlation
from fullwell.workflow.executor import in_threads
from fullwell.workflow.masked import MaskedArea, MaskedSums, has_masked, masked_area, masked_sums
from fullwell.workflow.measure.bursts import Burst, IsoBursts
from fullwell.workflow.measure.read_noise import choose_burst
from fullwell.workflow.measure.white_level import WhiteLevel

SMALLEST_SIDE: Final = 32
"""Of a plane, from where on they are [pixel]."""


@dataclass(frozen=True, slots=True, kw_only=True)
class PairLook:
    """What two frames of one burst came to.

    Parameters
    ----------
    kind, exposure_s
        Of the burst.
    files
        The two frames.
    correlations
        By channel.

    """

    kind: Kind
    exposure_s: float
    files: tuple[str, ...]
    correlations: tuple[NoiseCorrelation, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class SecondReading:
    """What the frames of one ISO came to that were read once more.

    Parameters
    ----------
    pairs
        The unlit pair and the lit one, as far as there are such.
    masked
        Masked pixels by channel, of the unlit frames, else of the lit ones; empty where the files have none.

    """

    pairs: tuple[PairLook, ...] = ()
    masked: tuple[MaskedArea, ...] = ()


def read_again(bursts: IsoBursts, whites: Sequence[WhiteLevel], *, workers: int) -> SecondReading:
    """Read two frames of the shortest unlit burst and two of the brightest flats that do not clip.

    Masked pixels count in the unlit frames, if there are such: in longer exposures they hold dark current.
    """
    pairs: list[PairLook] = []
    frames: list[tuple[MaskedSums, ...]] = []
    for burst in (choose_burst(bursts), _brightest(bursts, whites)):
        if burst is None:
            continue
        masked: list[tuple[MaskedSums, ...]] = []
        look = _look(burst, masked, workers=workers)
        if look is not None:
            pairs.append(look)
        frames = frames or [one for one in masked if one]
    return SecondReading(pairs=tuple(pairs), masked=masked_area(frames, bursts.channels) if frames else ())


def _brightest(bursts: IsoBursts, whites: Sequence[WhiteLevel]) -> Burst | None:
    limits = {white.channel: white.level_dn for white in whites}

    def clips(burst: Burst) -> bool:
        return any(
            (limit := limits.get(plane.channel)) is not None and int(plane.tiles.highest.max()) >= limit
            for plane in burst.statistics.planes
        )

    usable = [burst for burst in bursts.flats if burst.frames > 1 and not clips(burst)]
    return max(usable, key=lambda burst: burst.statistics.planes[0].mean, default=None)


def _look(burst: Burst, masked: list[tuple[MaskedSums, ...]], *, workers: int) -> PairLook | None:
    frames = [frame for frame in burst.series.frames if frame.name in burst.statistics.frames][:2]

    names = tuple(frame.name for frame in frames)
    known = None if burst.first is None or burst.first.frames[:2] != names else burst.first.middles
    if known is not None and not any(has_masked(frame.header) for frame in frames):
        return _compared(burst, names, known)

    def read(frame: Frame) -> tuple[NDArray[np.uint16], tuple[MaskedSums, ...]]:
        data = read_bytes(frame.header)
        mosaic = decode(frame.header, data)
        return mosaic[middle(mosaic.shape, burst.cell)].copy(), masked_sums(frame.header, data)

    try:
        found = in_threads(read, frames, workers=workers)
    except (RawFileError, OSError):
        return None
    masked += [sums for _, sums in found]
    return _compared(burst, names, [mosaic for mosaic, _ in found])


def _compared(burst: Burst, names: tuple[str, ...], middles: Iterable[NDArray[np.uint16]]) -> PairLook | None:
    """Compare the neighbours in the middles of two frames, None where there are too few."""
    cell = burst.cell
    planes = [[one[site // cell :: cell, site % cell :: cell] for one in middles] for site in range(cell * cell)]
    if min(planes[-1][0].shape) < SMALLEST_SIDE:
        return None
    return PairLook(
        kind=burst.kind,
        exposure_s=burst.exposure_s,
        files=names,
        correlations=tuple(noise_correlation(*pair) for pair in planes),
    )
