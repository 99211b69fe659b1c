"""Fixed pattern as variances with errors: PRNU of a map relative to its surface, DSNU of a dark one (METHOD 5.1, 5.2).

Which function: `nonuniformity` for a map cut in tiles (`fullwell.statistics.pattern`), `dark_nonuniformity` for a dark
burst whose mean squares are known already. `fullwell.fit.noise_floor` gives the temporal noise that a map keeps.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fullwell.fit.noise_floor import NoiseFloor
from fullwell.fit.tile_pooling import PooledTiles, Tiles, dark_tiles, pattern_tiles, pool_tiles
from fullwell.fit.variance_components import degrees_of_freedom, modified_large_sample_interval
from fullwell.statistics.pattern import Pattern
from fullwell.statistics.series import MeanSquares, TileStatistics
from fullwell.units import DN2, Measured, student_975, welch_dof


@dataclass(frozen=True, slots=True, kw_only=True)
class Nonuniformity:
    """Fixed-pattern variances, signed, temporal noise removed; ``row`` + ``column`` + ``pixel`` = ``total``.

    Parameters
    ----------
    total
        Variance of a pixel.
    row, column, pixel
        Of whole rows, of whole columns, of pixels on their own.
    repeat_error
        Standard error of ``total`` given this sensor's pattern: what a repeat on the same pixels scatters by. It is the
        error to compare ISOs or exposures of one sensor with.
    between_tiles_p
        Chance of tiles that differ more than they do if all have the same pattern; 1 for a single tile.
    misfit
        Whether that chance is below 1 %; the errors then come from the scatter between tiles.

    """

    total: Measured
    row: Measured
    column: Measured
    pixel: Measured
    repeat_error: float
    between_tiles_p: float
    misfit: bool


def nonuniformity(pattern: Pattern, floor: NoiseFloor, *, unit: str) -> Nonuniformity:
    """Return the fixed-pattern variances of a map (METHOD 5.1, 5.2, 5.5).

    Parameters
    ----------
    pattern
        Of the map.
    floor
        Temporal noise of the map's pixels.
    unit
        Of the variances: 1 where the pattern is relative, else the unit of the map squared.

    Returns
    -------
    Nonuniformity
        Intervals of the modified large-sample method.

    Raises
    ------
    ValueError
        Where no tile has both a pattern and a noise floor.

    """
    tiles = pattern_tiles(pattern, floor)
    pooled = pool_tiles(tiles)
    rows, columns = _lines(pattern, floor, tiles)
    within = _Part.of(pattern.pixel_mean_square, pattern.pixel_dof)
    pixel = _pixel_part(tiles, pooled, rows.part.dof + columns.part.dof)
    common = [
        _Part(value=-pooled.floor, error=pooled.floor_error, dof=math.inf),
        _unevenness(pooled.weights * tiles.row_share, tiles.band, tiles.height - 3.0, tiles.row),
        _unevenness(pooled.weights * tiles.column_share, tiles.stripe, tiles.width - 3.0, tiles.column),
    ]
    lines = 1.0 / rows.length + 1.0 / columns.length
    alone = pixel._replace(value=pixel.value - within.value * lines, error=pixel.error * (1.0 - lines))
    return Nonuniformity(
        total=_sum_of([rows.part, columns.part, alone, *common], unit, less=rows.noise + columns.noise),
        row=_sum_of([rows.part, within.times(-1.0 / rows.length), rows.doubt], unit, less=rows.noise),
        column=_sum_of([columns.part, within.times(-1.0 / columns.length), columns.doubt], unit, less=columns.noise),
        pixel=_sum_of([pixel, rows.doubt, columns.doubt, *common], unit),
        repeat_error=_repeat_error(tiles, pooled, (rows, columns)),
        between_tiles_p=pooled.p_value,
        misfit=pooled.misfit,
    )


def dark_nonuniformity(
    mean_squares: MeanSquares, shape: tuple[int, int, int], *, tiles: TileStatistics | None = None
) -> Nonuniformity:
    """Return the fixed-pattern variances of a dark burst from its three-way layout (METHOD 3.5, 5.1) [DN^2].

    No surface is taken off: a level that drifts over the plane counts, as DSNU has it.

    Parameters
    ----------
    mean_squares
        The seven mean squares [DN^2].
    shape
        T frames (at least two), M rows, N columns.
    tiles
        The same burst by tile: their scatter shows heavy-tailed pattern (hot pixels) and widens the errors; None leaves
        errors that hold for a normal pattern only.

    Raises
    ------
    ValueError
        Where there is a single frame.

    """
    frames, rows, columns = shape
    if frames < 2:
        raise ValueError("the temporal noise of a dark burst needs two frames or more")
    every = degrees_of_freedom(shape)
    parts = {effect: _Part.of(getattr(mean_squares, effect), every[effect]) for effect in ("tv", "th", "tvh")}
    for line in ("v", "h"):
        least = getattr(mean_squares, f"t{line}") + mean_squares.vh - mean_squares.tvh
        parts[line] = _Part.of(getattr(mean_squares, line), every[line], at_least=least)
    cut = None if tiles is None else dark_tiles(tiles, mean_squares, shape)
    pooled = None if cut is None else pool_tiles(cut)
    parts["vh"] = _Part.of(mean_squares.vh, every["vh"]).scattered(pooled)
    by_row, by_column = 1.0 / (frames * columns), 1.0 / (frames * rows)
    factors = {
        "row": {"v": by_row, "tv": -by_row, "vh": -by_row, "tvh": by_row},
        "column": {"h": by_column, "th": -by_column, "vh": -by_column, "tvh": by_column},
        "pixel": {"vh": 1.0 / frames, "tvh": -1.0 / frames},
    }
    total: dict[str, float] = {}
    for factor in factors.values():
        for effect, share in factor.items():
            total[effect] = total.get(effect, 0.0) + share
    found = {
        name: _sum_of([parts[effect].times(share) for effect, share in factor.items()], DN2)
        for name, factor in {"total": total, **factors}.items()
    }
    noise = {"v": parts["tv"], "h": parts["th"], "vh": parts["tvh"]}
    scatter = sum(
        total[effect] ** 2 * _scatter_of_noise(getattr(mean_squares, effect), floor.value, every[effect])
        + (total[f"t{effect}"] * floor.error) ** 2
        for effect, floor in noise.items()
    )
    return Nonuniformity(
        **found,
        repeat_error=math.sqrt(scatter),
        between_tiles_p=1.0 if pooled is None else pooled.p_value,
        misfit=pooled is not None and pooled.misfit,
    )


class _Part(NamedTuple):
    """One term of a sum: its value, its error, the error's degrees of freedom, what the interval takes of the error."""

    value: float
    error: float
    dof: float
    reach: float = 1.0

    @classmethod
    def of(cls, mean_square: float, dof: float, *, at_least: float = 0.0) -> Self:
        """Return a mean square of chi-square.

        Its error is not counted for less than that of the least it is expected to be: one that came out low would make
        the error of a part near zero too small just where the part is too low. The interval keeps its own law.
        """
        error = max(mean_square, at_least) * math.sqrt(2.0 / dof)
        return cls(mean_square, error, dof, mean_square * math.sqrt(2.0 / dof) / error if error > 0.0 else 1.0)

    def times(self, factor: float) -> Self:
        return self._replace(value=self.value * factor, error=self.error * abs(factor))

    def scattered(self, pooled: PooledTiles | None) -> Self:
        """Take the scatter between tiles for the error where it is the larger; its own few degrees where it is sure."""
        if pooled is None:
            return self
        wider = self._replace(error=self.error * math.sqrt(max(pooled.scatter, 1.0)))
        if not pooled.misfit:
            return wider
        dof = float(pooled.scatter_dof)
        return wider._replace(dof=dof, reach=student_975(dof) / student_975(None))


class _Lines(NamedTuple):
    """Rows or columns: mean square over a line's pixels, noise in it, noise in the line variance, pixels of a line.

    ``doubt`` is the error of the noise in the line variance; the total does not know it, since what lines lose to it
    pixels gain.
    """

    part: _Part
    floor: float
    noise: float
    length: float
    doubt: _Part


def _sum_of(parts: Sequence[_Part], unit: str, *, less: float = 0.0) -> Measured:
    """Return a sum of independent parts less what is known, with the modified large-sample interval.

    Parts without a value of their own are errors to either side. Where a part's error comes from few degrees of freedom
    that are not those of a chi-square, Student's factor widens it.
    """
    value = sum(part.value for part in parts)
    reach = np.array([part.error * part.reach for part in parts])
    size = np.array([part.value for part in parts])
    law = (size != 0.0) & (reach > 0.0)
    below, above = 0.0, 0.0
    if law.any():
        low, high = modified_large_sample_interval(size[law], 2.0 * (size[law] / reach[law]) ** 2)
        below, above = float(size[law].sum()) - low, high - float(size[law].sum())
    either = student_975(None) * float(np.sqrt(np.sum(reach[~law] ** 2)))
    return Measured(
        value=value - less,
        unit=unit,
        std_error=math.hypot(*(part.error for part in parts)),
        dof=welch_dof(*((part.error, part.dof) for part in parts)),
        ci95=(value - less - math.hypot(below, either), value - less + math.hypot(above, either)),
    )


def _lines(pattern: Pattern, floor: NoiseFloor, tiles: Tiles) -> tuple[_Lines, _Lines]:
    share = tiles.dof / tiles.dof.sum()
    scale = float(share @ pattern.inverse_square[tiles.band, tiles.stripe])
    white = float(share @ tiles.floor)

    def lines(mean_square: float, dof: int, length: float, noise: tuple[float, float]) -> _Lines:
        value, error = (one * scale for one in noise)
        part = _Part.of(mean_square / length, dof, at_least=pattern.pixel_mean_square / length + value)
        return _Lines(part, white / length + value, value, length, _Part(0.0, error, math.inf))

    return (
        lines(pattern.row_mean_square, pattern.row_dof, pattern.columns, (floor.row, floor.row_error)),
        lines(pattern.column_mean_square, pattern.column_dof, pattern.rows, (floor.column, floor.column_error)),
    )


def _pixel_part(tiles: Tiles, pooled: PooledTiles, line_dof: float) -> _Part:
    """Return pattern and noise of pixels on their own; rows and columns have taken their degrees of freedom."""
    left = 1.0 - line_dof / float(tiles.dof.sum())
    error = pooled.error / math.sqrt(left)
    return _Part(pooled.pattern + pooled.floor, error, math.inf).scattered(pooled)


def _unevenness(
    parts: NDArray[np.float64], group: NDArray[np.int64], dof: NDArray[np.float64], variance: float
) -> _Part:
    """Return the error that comes of lines which count more in the tiles' mean than they do in the line variance."""
    groups, first, member = np.unique(group, return_index=True, return_inverse=True)
    nu = dof[first]
    weights = np.bincount(member, parts, minlength=groups.size)
    excess = weights - float(weights.sum()) * nu / nu.sum()
    return _Part(0.0, max(variance, 0.0) * math.sqrt(2.0 * float(np.sum(excess**2 / nu))), math.inf)


def _repeat_error(tiles: Tiles, pooled: PooledTiles, lines: Sequence[_Lines]) -> float:
    """Return what the noise alone scatters the total by: in each mean square 4 P F + 2 F^2, and that of the floor.

    Weights follow the noise, so two repeats at different noise also weigh the same pattern differently.
    """
    pattern = max(pooled.pattern, 0.0)
    crossed = _scatter_of_noise(pattern + tiles.smooth_floor, tiles.smooth_floor, tiles.dof)
    weighing = float(np.sum(pooled.weights**2 / tiles.dof)) - 1.0 / float(tiles.dof.sum())
    squares = [
        float(pooled.weights**2 @ crossed),
        pooled.floor_error**2,
        2.0 * pattern**2 * max(weighing, 0.0) * max(pooled.scatter, 1.0),
        *(float(_scatter_of_noise(one.part.value, one.floor, one.part.dof)) for one in lines),
    ]
    return math.sqrt(sum(squares))


def _scatter_of_noise(mean_square: ArrayLike, noise: ArrayLike, dof: ArrayLike) -> NDArray[np.float64]:
    """Return the variance, given the pattern, of a mean square of which ``noise`` is noise."""
    whole, noise = np.asarray(mean_square, np.float64), np.asarray(noise, np.float64)
    return (4.0 * np.maximum(whole - noise, 0.0) * noise + 2.0 * noise**2) / np.asarray(dof, np.float64)
