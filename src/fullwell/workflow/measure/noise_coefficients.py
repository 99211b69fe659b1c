"""The noise model: k_dark, k_shot and k_fpn from temporal and spatial variances together (METHOD 1.4)."""

import math
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple, Self

import numpy as np
from numpy.typing import NDArray

from fullwell.figures.results import Row
from fullwell.fit.noise_coefficients import NoiseCoefficientFit, k_coefficients
from fullwell.fit.photon_transfer import fit_burst_photon_transfer
from fullwell.fit.pooling import (
    SIGNIFICANCE,
    SharedErrors,
    mean_of_sites,
    mean_sharing_errors,
    pool_channels,
    with_lines,
)
from fullwell.statistics.series import PlaneStatistics
from fullwell.statistics.tiles import SURFACE_TERMS, edges
from fullwell.units import ONE, Measured
from fullwell.workflow.measure.bursts import IsoBursts
from fullwell.workflow.measure.levels import ChannelLevels
from fullwell.workflow.measure.nonuniformity import ChannelPattern
from fullwell.workflow.measure.photon_transfer import ChannelTransfer
from fullwell.workflow.measure.rounding import only_an_interval, phase_aware_dof, phase_aware_spatial_dof
from fullwell.workflow.measure.section import RowWriter, Section
from fullwell.workflow.measure.transfer_points import TransferPoint, admitted_tiles, pooled_dof
from fullwell.workflow.measure.unlit import line_noise

METHOD = "gamma-likelihood"
OUTSTANDING = 2.0
"""Standard errors from which on the pattern of rows or columns counts."""
_NAMES = ("k_dark", "k_shot", "k_fpn")
_POWERS = (-2, -1, 0)
"""Of D, by which A, B and C become squared k's."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ChannelModel:
    """The three-term noise model of one channel: single-frame coefficients A, B, C and their covariance.

    ``fit_covariance`` is that of the fit alone, without what a sample of few rows and columns adds; the latter is
    ``shared`` (by A, B and C), since channels share patterns of rows and columns. ``rounding_limited`` says that A is
    only known to the unknown phase of rounding, which channels have in common; ``only_an_interval``, that the unlit
    bursts tell no more of their noise.
    """

    channel: str
    coefficients: NDArray[np.float64]
    covariance: NDArray[np.float64]
    fit_covariance: NDArray[np.float64]
    dof: float | None
    misfit: bool
    rounding_limited: bool
    only_an_interval: bool
    shared: tuple[SharedErrors, SharedErrors, SharedErrors]
    n: int


class _Line(NamedTuple):
    """A fixed pattern of rows or columns: its variance, and the degrees of freedom that it is known with."""

    variance: float
    dof: float

    @classmethod
    def of(cls, measured: Measured | None) -> Self:
        """Return a pattern; none where it does not stand out from its error."""
        if measured is None or measured.value <= OUTSTANDING * (measured.std_error or 0.0):
            return cls(0.0, math.inf)
        return cls(measured.value, measured.dof or math.inf)


@dataclass(frozen=True, slots=True, kw_only=True)
class _Lines:
    """Variances that the pixels of a row, and of a column, have in common.

    Parameters
    ----------
    temporal
        Of one frame, from unlit frames [DN^2].
    dark, response
        Fixed pattern: of the dark level [DN^2] and of the response [1].

    """

    temporal: tuple[float, float]
    dark: tuple[_Line, _Line]
    response: tuple[_Line, _Line]

    @classmethod
    def of(cls, bursts: IsoBursts, pattern: ChannelPattern) -> Self:
        """Return the lines of a channel."""
        known = (pattern.dsnu, pattern.prnu)
        dark, response = ((_Line.of(one and one.row), _Line.of(one and one.column)) for one in known)
        return cls(temporal=line_noise(bursts, pattern.channel), dark=dark, response=response)


def measure_noise_coefficients(
    bursts: IsoBursts,
    levels: Sequence[ChannelLevels],
    transfers: Sequence[ChannelTransfer],
    patterns: Sequence[ChannelPattern],
    *,
    black: Measured | None,
) -> tuple[Section, tuple[ChannelModel, ...]]:
    """Fit the three-term noise model of every channel at one ISO; ``black`` is the level of all channels [DN]."""
    models: list[ChannelModel] = []
    rows: list[Row] = []
    fitted: list[tuple[Measured, ...]] = []
    for level, transfer, pattern in zip(levels, transfers, patterns, strict=True):
        if transfer.fit is None or level.digital_maximum_dn is None or level.black is None:
            continue
        model = _model(bursts, level, transfer, lines=_Lines.of(bursts, pattern))
        if model is None:
            continue
        ks = k_coefficients(
            model.coefficients,
            model.fit_covariance,
            digital_maximum=level.digital_maximum_dn,
            dof=model.dof,
            offset_std_error_dn=level.black.std_error or 0.0,
            offset_dof=level.black.dof,
        )
        models.append(model)
        fitted.append(_variances(ks, model))
        flags = _flags([model], identified=level.black_identified)
        rows += _rows(bursts, level.channel, fitted[-1], n=model.n, flags=flags)
    rows += _pooled(bursts, levels, models, fitted, black=black)
    return Section(rows=tuple(rows)), tuple(models)


def _model(bursts: IsoBursts, level: ChannelLevels, transfer: ChannelTransfer, *, lines: _Lines) -> ChannelModel | None:
    chosen = [point for point, good in zip(transfer.points, transfer.on_curve, strict=True) if good]
    unlit = [point.burst.plane(level.channel) for point in chosen if point.burst in bursts.unlit]
    tried = (_pool(point, level, lines=lines, sharing=max(2 * len(unlit), 1)) for point in chosen)
    pooled = [one for one in tried if one is not None]
    if len(pooled) < 3:
        return None
    plane = chosen[-1].burst.plane(level.channel)
    fit = fit_burst_photon_transfer(
        [one.signal_dn for one in pooled],
        [one.temporal_dn2 for one in pooled],
        [one.temporal_dof for one in pooled],
        [one.spatial_dn2 for one in pooled],
        [one.spatial_dof for one in pooled],
        frames=[one.frames for one in pooled],
        n=[one.n for one in pooled],
        mean_square_dn2=[one.mean_square_dn2 for one in pooled],
        pattern_pixels=float(plane.n),
    )
    coefficients, covariance = fit.single_frame()
    by_lines = (_sample_of(lines.dark, plane), SharedErrors(), _sample_of(lines.response, plane))
    of_lines = np.diag([one.row[0] ** 2 + one.column[0] ** 2 for one in by_lines])
    return ChannelModel(
        channel=level.channel,
        coefficients=coefficients,
        covariance=covariance + of_lines,
        fit_covariance=covariance,
        dof=fit.dof,
        misfit=fit.misfit,
        rounding_limited=any(one.rounding_limited for one in pooled),
        only_an_interval=any(only_an_interval(plane) for plane in unlit),
        shared=by_lines,
        n=sum(one.n for one in pooled),
    )


@dataclass(frozen=True, slots=True, kw_only=True)
class _PooledBurst:
    """One burst: temporal and detrended spatial variance, pooled over its admitted tiles."""

    signal_dn: float
    mean_square_dn2: float
    temporal_dn2: float
    temporal_dof: float
    spatial_dn2: float
    spatial_dof: float
    frames: int
    n: int

    @property
    def rounding_limited(self) -> bool:
        """Tell whether the unknown phase of rounding, not the number of pixels, limits the temporal variance."""
        return self.temporal_dof < 0.25 * self.n


def _pool(point: TransferPoint, level: ChannelLevels, *, lines: _Lines, sharing: int) -> _PooledBurst | None:
    """Pool the tiles of a burst; ``sharing`` variances of unlit bursts, two of each, err by rounding together."""
    plane = point.burst.plane(level.channel)
    tiles = plane.tiles
    chosen = admitted_tiles(plane, level.white_dn) & (tiles.spatial_dof > 0)
    if not chosen.any():
        return None
    pixels, signal = tiles.n[chosen], tiles.mean[chosen] - level.black_dn
    temporal_dof, spatial_dof = tiles.temporal_dof[chosen], tiles.spatial_dof[chosen]
    by_surface = [share[chosen] for share in _shares_taken_off(plane, along=3, terms=SURFACE_TERMS)]
    by_mean = sum(
        share[chosen] * variance
        for share, variance in zip(_shares_taken_off(plane, along=1, terms=1), lines.temporal, strict=True)
    )
    spatial_dn2 = tiles.spatial_variance[chosen] + sum(
        share * (temporal / plane.frames + dark.variance + response.variance * signal**2)
        for share, temporal, dark, response in zip(by_surface, lines.temporal, lines.dark, lines.response, strict=True)
    )
    temporal_dn2 = float((temporal_dof * (tiles.temporal_variance[chosen] + by_mean)).sum() / temporal_dof.sum())
    pooled_spatial_dn2 = float((spatial_dof * spatial_dn2).sum() / spatial_dof.sum())
    return _PooledBurst(
        signal_dn=float((pixels * signal).sum() / pixels.sum()),
        mean_square_dn2=float((pixels * signal**2).sum() / pixels.sum()),
        temporal_dn2=temporal_dn2,
        temporal_dof=phase_aware_dof(
            plane, temporal_dn2, pooled_dof(temporal_dof, tiles.temporal_variance[chosen]), sharing=sharing
        ),
        spatial_dn2=pooled_spatial_dn2,
        spatial_dof=phase_aware_spatial_dof(
            plane, pooled_spatial_dn2, pooled_dof(spatial_dof, tiles.spatial_variance[chosen]), sharing=sharing
        ),
        frames=plane.frames,
        n=int(pixels.sum()) * plane.frames,
    )


def _with_offset(
    models: Sequence[ChannelModel], own: Sequence[Measured | None], black: Measured | None
) -> list[ChannelModel]:
    """Return models whose k_dark err together as the black levels do, which are those of the same frames.

    The error of the mean of n levels tells what they share: n^2 times its square holds that n^2 times, and what is each
    level's own n times.

    Parameters
    ----------
    models, own
        By channel, and their black levels [DN].
    black
        The mean of the black levels [DN].

    """
    if black is None or black.std_error is None:
        return list(models)
    count, alone = len(own), sum((one.std_error or 0.0) ** 2 for one in own if one is not None)
    shared_dn = math.sqrt(max((count * black.std_error) ** 2 - alone, 0.0) / (count * (count - 1)))
    return [
        replace(
            one,
            shared=(replace(one.shared[0], frame=(shared_dn * float(one.coefficients[1]), black.dof)), *one.shared[1:]),
        )
        for one in models
    ]


def _shares_taken_off(
    plane: PlaneStatistics, *, along: int, terms: int
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return which share of the variance of rows, and of columns, each tile takes off, shapes of the tiles [1].

    Of the m rows of a tile a mean follows one and a quadratic surface three: a variance that rows share then counts
    m less these times its width in the sum of squares, where pixels by themselves count m times the width less all
    terms; columns alike.

    Parameters
    ----------
    plane
        Of the burst.
    along, terms
        Rows, and pixels, that the mean or the surface follows.

    """
    heights, widths = (edges(side, tile) for side, tile in zip(plane.shape[1:], _tile(plane), strict=True))
    rows, columns = heights[:, np.newaxis].astype(np.float64), widths[np.newaxis, :].astype(np.float64)
    dof = np.maximum(rows * columns - terms, 1.0)
    return 1.0 - columns * (rows - along) / dof, 1.0 - rows * (columns - along) / dof


def _sample_of(lines: tuple[_Line, _Line], plane: PlaneStatistics) -> SharedErrors:
    """Return the errors that patterns of rows and columns have for being a sample of few.

    A tile of m rows tells its pattern with the m - 3 degrees of freedom that its surface leaves; the share that the
    surface took off was given back with those of the whole plane.
    """
    sides = plane.shape[1:]
    shares = _shares_taken_off(plane, along=3, terms=SURFACE_TERMS)
    known: list[float] = []
    for side, tile, line, share in zip(sides, _tile(plane), lines, shares, strict=True):
        within = float(np.maximum(edges(side, tile) - 3, 0).sum())
        kept = (1.0 - float(share.mean())) ** 2 if within else 0.0
        given_back = (1.0 - kept) / min(line.dof, side - 1.0)
        known.append(1.0 / (given_back + (kept / within if within else 0.0)))
    row, column = (line.variance for line in lines)
    return SharedErrors.of_variances(row=row, column=column, dof=(1.0, known[0], known[1]))


def _tile(plane: PlaneStatistics) -> tuple[int, int]:
    """Return rows and columns of a whole tile: square but where the plane has one tile across or down."""
    _, rows, columns = plane.shape
    down, across = plane.tiles.n.shape
    pixels = int(plane.tiles.n[0, 0])
    if down == 1:
        return rows, pixels // rows
    if across == 1:
        return pixels // columns, columns
    return math.isqrt(pixels), math.isqrt(pixels)


def _variances(ks: NoiseCoefficientFit, model: ChannelModel) -> tuple[Measured, ...]:
    """Return the squared k's of a channel, the sample of rows and columns in their errors."""
    shared = [one.scaled(ks.digital_maximum**power) for one, power in zip(model.shared, _POWERS, strict=True)]
    fitted = (ks.k_dark_variance, ks.k_shot_variance, ks.k_fpn_variance)
    return tuple(with_lines(one, (by.row, by.column)) for one, by in zip(fitted, shared, strict=True))


def _rows(
    bursts: IsoBursts, channel: str, variances: Sequence[Measured], *, n: int, flags: Mapping[str, set[str]]
) -> tuple[Row, ...]:
    write = RowWriter(bursts=bursts).root_and_variance
    return tuple(
        row
        for name, variance in zip(_NAMES, variances, strict=True)
        for row in write(name, channel, METHOD, variance, ONE, source="METHOD 1.4", n=n, flags=flags[name])
    )


def _flags(models: Sequence[ChannelModel], *, identified: bool, differ: Collection[str] = ()) -> Mapping[str, set[str]]:
    """Return the flags of each coefficient."""
    misfit = any(one.misfit for one in models)
    flags = {name: {"model-misfit"} if misfit else set[str]() for name in _NAMES}
    if any(one.only_an_interval for one in models):
        flags["k_dark"].add("quantization-limited")
    if not identified:
        flags["k_dark"].add("offset-not-identified")
    for name in differ:
        flags[name].add("channels-differ")
    return flags


def _pooled(
    bursts: IsoBursts,
    levels: Sequence[ChannelLevels],
    models: Sequence[ChannelModel],
    fitted: Sequence[tuple[Measured, ...]],
    *,
    black: Measured | None,
) -> tuple[Row, ...]:
    """Return the channels' k's as one: the weighted mean of their variances, and a flag where they differ."""
    if len(levels) < 2 or len(fitted) < len(levels):
        return ()
    parts = list(zip(*fitted, strict=True))
    models = _with_offset(models, [level.black for level in levels], black)
    maximum_dn = levels[0].digital_maximum_dn or 1.0
    shared = [[one.shared[term].scaled(maximum_dn**power) for one in models] for term, power in enumerate(_POWERS)]
    pooled = [
        (mean_of_sites(part, errors, weighted=True), pool_channels(part)[1])
        for part, errors in zip(parts, shared, strict=True)
    ]
    if any(one.rounding_limited for one in models):
        pooled[0] = (mean_sharing_errors(parts[0]), pooled[0][1])
    flags = _flags(
        models,
        identified=all(one.black_identified for one in levels),
        differ=[name for name, (_, p_value) in zip(_NAMES, pooled, strict=True) if p_value < SIGNIFICANCE],
    )
    return _rows(bursts, "all", [measured for measured, _ in pooled], n=sum(one.n for one in models), flags=flags)
