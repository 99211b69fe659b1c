"""The individual: what chance decided when a sensor was made, the same in every frame.

Patterns have a spread of 1 and no mean over each visible CFA plane, so that a plane's level and response are what the
parameters say. As many visible pixels are hot, or jump, as the parameters say, to the pixel; and the charge of the hot
ones is in the mean what it should be. Margins are made of the same stuff.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Final, TypeVar

import numpy as np
from numpy.typing import NDArray

from fullwell.kernels.random import Draws, normal
from fullwell.model.sensor import SensorParameters
from fullwell.raw.cfa import cell
from fullwell.raw.image import Area
from fullwell.simulate.geometry import Margins, Stream, tiles

Pattern = NDArray[np.float32]
_Kind = TypeVar("_Kind", bound=np.generic)
_LEAST: Final = 1e-300
"""Keeps a plane without any hot pixel from being divided by nothing."""


def _none() -> Pattern:
    return np.empty((0, 0), dtype=np.float32)


@dataclass(frozen=True, slots=True, kw_only=True)
class Individual:
    """Fixed patterns of one sensor; those it does not have are empty.

    Parameters
    ----------
    prnu, dsnu
        Of pixels, shape (height, width) of the stored mosaic [1].
    prnu_row, dsnu_row
        Of rows, shape (height, 1) [1].
    prnu_column, dsnu_column
        Of columns, shape (1, width) [1].
    dark_current
        Of each pixel where it differs, at the reference temperature, shape (height, width) [e-/s].
    jumping
        1 where a pixel jumps between two levels, else 0, shape (height, width).

    """

    prnu: Pattern = field(default_factory=_none)
    prnu_row: Pattern = field(default_factory=_none)
    prnu_column: Pattern = field(default_factory=_none)
    dsnu: Pattern = field(default_factory=_none)
    dsnu_row: Pattern = field(default_factory=_none)
    dsnu_column: Pattern = field(default_factory=_none)
    dark_current: Pattern = field(default_factory=_none)
    jumping: Pattern = field(default_factory=_none)


@dataclass(frozen=True, slots=True, kw_only=True)
class _Maker:
    """Makes the patterns of one seed."""

    seed: int
    shape: tuple[int, int]
    visible: Area
    period: int

    def pixels(self, stream: Stream, *, wanted: bool) -> Pattern:
        if not wanted:
            return _none()
        pattern = self._numbers(stream)
        for plane, seen in self._planes(pattern):
            np.subtract(plane, seen.mean(dtype=np.float64), out=plane, casting="same_kind")
        return pattern

    def rows(self, stream: Stream, *, wanted: bool) -> Pattern:
        return self._lines(stream, self.shape[0], self._rows)[:, None] if wanted else _none()

    def columns(self, stream: Stream, *, wanted: bool) -> Pattern:
        return self._lines(stream, self.shape[1], self._columns)[None, :] if wanted else _none()

    def chosen(self, stream: Stream, share: float) -> NDArray[np.bool_]:
        """Return which pixels are chosen, the same number of each plane."""
        numbers = self._numbers(stream)
        chosen = np.zeros(self.shape, dtype=np.bool_)
        for (plane, seen), (marks, _) in zip(self._planes(numbers), self._planes(chosen), strict=True):
            count = round(share * seen.size)
            if count:
                marks[:] = plane >= np.partition(seen, seen.size - count, axis=None)[seen.size - count]
        return chosen

    def dark_current(self, sensor: SensorParameters) -> Pattern:
        """Return each pixel's rate: log-normal with the mean and spread asked for, hot pixels upon it [e-/s]."""
        hot = sensor.hot_pixels * sensor.hot_pixel_current > 0.0
        if not sensor.dark_current_spread and not hot:
            return _none()
        rate = np.full(self.shape, sensor.dark_current, dtype=np.float32)
        if sensor.dark_current_spread and sensor.dark_current:
            width = math.sqrt(math.log1p((sensor.dark_current_spread / sensor.dark_current) ** 2))
            rate = np.exp(np.float32(width) * self._numbers(Stream.DARK_CURRENT))
            self._scale(rate, [sensor.dark_current * seen.size for _, seen in self._planes(rate)])
        if hot:
            places = self.chosen(Stream.HOT_PIXEL, sensor.hot_pixels)
            more = np.where(places, self._exponential(), np.float32(0.0))
            self._scale(more, [sensor.hot_pixel_current * float(seen.sum()) for _, seen in self._planes(places)])
            rate += more
        return rate

    def _scale(self, pattern: Pattern, totals: Sequence[float]) -> None:
        """Scale each plane to a sum over what is visible of it."""
        for (plane, seen), total in zip(self._planes(pattern), totals, strict=True):
            np.multiply(plane, total / max(float(seen.sum(dtype=np.float64)), _LEAST), out=plane, casting="same_kind")

    def _exponential(self) -> Pattern:
        """Return numbers of an exponential law: half the sum of two squares of normal numbers."""
        first, second = self._numbers(Stream.HOT_PIXEL_CURRENT), self._numbers(Stream.HOT_PIXEL_CURRENT_2)
        return np.asarray((first * first + second * second) / 2.0, dtype=np.float32)

    def _numbers(self, stream: Stream) -> Pattern:
        height, width = self.shape
        pattern = np.empty(self.shape, dtype=np.float32)
        for tile in tiles(height, width):
            draws = Draws(seed=self.seed, stream=stream.value, first=tile.top * width, stride=width)
            pattern[tile.window] = normal(tile.shape, draws)
        return pattern

    def _lines(self, stream: Stream, count: int, visible: slice) -> Pattern:
        lines = normal((1, count), Draws(seed=self.seed, stream=stream.value))[0].astype(np.float32)
        for first in range(self.period):
            own, seen = lines[first :: self.period], lines[visible][first :: self.period]
            own -= seen.mean(dtype=np.float64)
        return lines

    def _planes(self, pattern: NDArray[_Kind]) -> list[tuple[NDArray[_Kind], NDArray[_Kind]]]:
        """Return each CFA plane, and what is visible of it; margins are even."""
        period, seen = self.period, pattern[self._rows, self._columns]
        sites = [(slice(site // period, None, period), slice(site % period, None, period)) for site in range(period**2)]
        return [(pattern[site], seen[site]) for site in sites]

    @property
    def _rows(self) -> slice:
        return slice(self.visible.top, self.visible.bottom)

    @property
    def _columns(self) -> slice:
        return slice(self.visible.left, self.visible.right)


def make(sensor: SensorParameters, *, seed: int, margins: Margins, unequal: bool) -> Individual:
    """Return the fixed patterns of one sensor.

    Parameters
    ----------
    sensor
        Parameters.
    seed
        0 to 2^64 - 1.
    margins
        Around the visible pixels.
    unequal
        Whether levels differ at any ISO; `sensor` speaks of one.

    """
    visible, shape = margins.active(sensor), margins.shape(sensor)
    maker = _Maker(seed=seed, shape=shape, visible=visible, period=cell(sensor.cfa))
    jumps = sensor.rts_pixels * sensor.rts_amplitude > 0.0
    return Individual(
        prnu=maker.pixels(Stream.PRNU, wanted=sensor.prnu > 0.0),
        prnu_row=maker.rows(Stream.PRNU_ROW, wanted=sensor.prnu_row > 0.0),
        prnu_column=maker.columns(Stream.PRNU_COLUMN, wanted=sensor.prnu_column > 0.0),
        dsnu=maker.pixels(Stream.DSNU, wanted=unequal),
        dsnu_row=maker.rows(Stream.DSNU_ROW, wanted=unequal),
        dsnu_column=maker.columns(Stream.DSNU_COLUMN, wanted=unequal),
        dark_current=maker.dark_current(sensor),
        jumping=maker.chosen(Stream.RTS, sensor.rts_pixels).astype(np.float32) if jumps else _none(),
    )
