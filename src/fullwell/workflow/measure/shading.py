"""Lens shading of every flat burst and channel: bins, models, the choice among them (METHOD 6)."""

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from fullwell.figures.results import Column, Curve, Row
from fullwell.findings import Finding, Severity
from fullwell.fit.shading.data import ShadingData, shading_data
from fullwell.fit.shading.extent import corner_and_edges, residual_rms
from fullwell.fit.shading.selection import ShadingFits, fit_shading
from fullwell.fit.shading.surface import ShadingModel
from fullwell.frames.series import Camera
from fullwell.report.numbers import show_exposure
from fullwell.statistics.bins import bin_plane, bin_size
from fullwell.statistics.series import PlaneStatistics
from fullwell.units import ONE
from fullwell.workflow.executor import in_threads
from fullwell.workflow.measure.bursts import Burst, IsoBursts
from fullwell.workflow.measure.levels import ChannelLevels
from fullwell.workflow.measure.nonuniformity import ChannelPattern
from fullwell.workflow.measure.photon_transfer import ChannelTransfer
from fullwell.workflow.measure.section import RowWriter, Section
from fullwell.workflow.measure.unlit import line_noise

USUAL_PRNU = 0.01
"""Weight of the pixels' own scatter where it was not measured."""

MOST_SATURATED = 0.01
"""Share of saturated bins beyond which the top of a map cannot be told."""

FROM_SATURATION = 5.0

_SATURATED = "it comes too near to saturation"


@dataclass(frozen=True, slots=True, kw_only=True)
class ChannelShading:
    """One channel of one burst.

    Parameters
    ----------
    black_dn
        What was subtracted [DN].
    data
        Bins of the plane.
    fits
        All models and the choice among them.

    """

    channel: str
    black_dn: float
    data: ShadingData
    fits: ShadingFits

    def without_errors(self) -> "ChannelShading":
        """Return the same without the covariances of its models, which take the most memory."""
        return replace(self, fits=self.fits.without_errors())


@dataclass(frozen=True, slots=True, kw_only=True)
class BurstShading:
    """The shading of one flat burst, every channel of it."""

    iso: float | None
    burst: Burst
    channels: tuple[ChannelShading, ...]

    def without_errors(self) -> "BurstShading":
        """Return the same without pixels and covariances."""
        channels = tuple(one.without_errors() for one in self.channels)
        return replace(self, burst=self.burst.without_pixels(), channels=channels)


def measure_shading(
    bursts: IsoBursts,
    levels: Sequence[ChannelLevels],
    transfers: Sequence[ChannelTransfer],
    patterns: Sequence[ChannelPattern],
    *,
    camera: Camera,
    workers: int,
) -> tuple[Section, tuple[BurstShading, ...]]:
    """Fit the shading of every flat burst at one ISO whose sums were kept."""
    full = {(point.burst.series.key, one.channel) for one in transfers for point in one.beyond_the_turn}
    flats = [burst for burst in bursts.flats if burst.sums is not None]
    prnu = {one.channel: _relative(one) for one in patterns}
    tasks = [(burst, level) for burst in flats for level in levels]

    def fit(task: tuple[Burst, ChannelLevels]) -> ChannelShading | str:
        burst, level = task
        if (burst.series.key, level.channel) in full:
            return _SATURATED
        relative = prnu.get(level.channel, USUAL_PRNU)
        return _fit(burst, level, prnu=relative, lines=line_noise(bursts, level.channel), camera=camera)

    fitted = in_threads(fit, tasks, workers=workers)
    shadings: list[BurstShading] = []
    failures: list[tuple[Burst, str, str]] = []
    for at, burst in enumerate(flats):
        own = fitted[at * len(levels) : (at + 1) * len(levels)]
        good = tuple(one for one in own if isinstance(one, ChannelShading))
        if good:
            shadings.append(BurstShading(iso=bursts.iso, burst=burst, channels=good))
        failures += [
            (burst, level.channel, one) for level, one in zip(levels, own, strict=True) if isinstance(one, str)
        ]
    rows = tuple(row for one in shadings for row in _rows(bursts, one))
    curves = (*(_choices(one) for one in shadings), *(_profiles(one) for one in longest_whole(shadings)))
    return Section(rows=rows, curves=curves, findings=_findings(bursts, failures)), tuple(shadings)


def longest_whole(shadings: Sequence[BurstShading]) -> tuple[BurstShading, ...]:
    """Return the longest exposed burst of one ISO among those of most channels, alone; nothing of no bursts."""
    return (max(shadings, key=lambda one: (len(one.channels), one.burst.exposure_s)),) if shadings else ()


def _relative(pattern: ChannelPattern) -> float:
    return USUAL_PRNU if pattern.prnu is None else math.sqrt(max(pattern.prnu.total.value, 0.0))


def _fit(
    burst: Burst, level: ChannelLevels, *, prnu: float, lines: tuple[float, float], camera: Camera
) -> ChannelShading | str:
    """Fit one plane, or say why it cannot be fitted."""
    plane = burst.plane(level.channel)
    if level.black is None:
        return "the black level is unknown"
    size = bin_size((plane.rows, plane.columns))
    variance = _temporal_variance(plane)
    noise = math.sqrt(max(float(np.nanmean(variance)), 0.0) / plane.frames)
    bins = bin_plane(
        burst.plane_sums(level.channel),
        plane.frames,
        size=size,
        temporal_noise_dn=noise,
        limit_dn=_limit(plane, level, float(np.nanmean(variance))),
    )
    if bins.saturated > MOST_SATURATED * bins.n.size:
        return _SATURATED
    try:
        data = shading_data(
            bins,
            black_dn=level.black_dn,
            temporal_variance_dn2=_at_bins(variance, plane, bins.rows, bins.columns)
            # noise that the bins of a row share does not average out along it: as if each had so much more of its own
            + size * (lines[0] * bins.columns.size + lines[1] * bins.rows.size),
            frames=plane.frames,
            prnu=prnu,
            pitch_um=None if camera.pixel_pitch_um is None else burst.cell * camera.pixel_pitch_um,
            focal_length_mm=camera.focal_length_mm,
        )
        fits = fit_shading(data)
    except ValueError as error:
        return str(error)
    return ChannelShading(channel=level.channel, black_dn=level.black_dn, data=data, fits=fits)


def _temporal_variance(plane: PlaneStatistics) -> NDArray[np.float64]:
    """Return the temporal variance of a pixel by tile; of a single frame, the spatial variance in its place [DN^2]."""
    tiles = plane.tiles
    variance = tiles.temporal_variance if plane.frames > 1 else tiles.spatial_variance
    whole = float(np.nanmean(variance)) if np.isfinite(variance).any() else 1.0
    return np.where(np.isfinite(variance) & (variance > 0.0), variance, max(whole, 1e-3))


def _at_bins(
    variance: NDArray[np.float64], plane: PlaneStatistics, rows: NDArray[np.float64], columns: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Return the variance of the tile that each bin lies in, shape (bin rows, bin columns)."""
    row = np.minimum(rows // plane.tiles.size, variance.shape[0] - 1).astype(np.intp)
    column = np.minimum(columns // plane.tiles.size, variance.shape[1] - 1).astype(np.intp)
    return variance[row[:, np.newaxis], column]


def _limit(plane: PlaneStatistics, level: ChannelLevels, variance_dn2: float) -> float | None:
    """Return the mean above which a pixel is within five standard deviations of saturation, shot noise grown to it."""
    if level.white_dn is None:
        return None
    signal, full = plane.mean - level.black_dn, level.white_dn - level.black_dn
    growth = max(1.0, full / signal) if signal > 0.0 else 1.0
    return level.white_dn - FROM_SATURATION * math.sqrt(variance_dn2 * growth)


def _rows(bursts: IsoBursts, shading: BurstShading) -> Iterable[Row]:
    write = RowWriter(bursts=bursts).row
    exposure_s = shading.burst.exposure_s
    for one in shading.channels:
        n = shading.burst.plane(one.channel).n * shading.burst.frames
        for name, model in _ordered(one.fits):
            extent = corner_and_edges(model)
            flags = ("model-misfit",) if model.misfit else ()
            for quantity, measured in (
                ("shading_corner", extent.corner),
                ("shading_edge_x", extent.edge_x),
                ("shading_edge_y", extent.edge_y),
                ("shading_residual_rms", residual_rms(model, one.data)),
            ):
                yield write(
                    quantity,
                    one.channel,
                    name,
                    measured,
                    source="METHOD 6.2" if name != one.fits.chosen else "METHOD 6.3",
                    n=n,
                    exposure_s=exposure_s,
                    flags=flags,
                )


def _ordered(fits: ShadingFits) -> Iterable[tuple[str, ShadingModel]]:
    """Return the models by name, the chosen one first."""
    yield fits.chosen, fits.best
    for name, model in fits.models.items():
        if name != fits.chosen:
            yield name, model


def _choices(shading: BurstShading) -> Curve:
    """Return every model with its cross-validation, and which one was chosen."""
    found = [(one, name, model) for one in shading.channels for name, model in one.fits.models.items()]
    count = len(found)
    return Curve(
        name="shading_models",
        columns=(
            Column(name="iso", unit="1", values=(shading.iso,) * count),
            Column(name="exposure_s", unit="s", values=(shading.burst.exposure_s,) * count),
            Column(name="channel", unit="", values=tuple(one.channel for one, _, _ in found)),
            Column(name="model", unit="", values=tuple(name for _, name, _ in found)),
            Column(name="terms", unit="1", values=tuple(float(model.effective_terms) for _, _, model in found)),
            Column(name="cross_validation", unit=ONE, values=tuple(float(model.gcv) for _, _, model in found)),
            Column(name="chosen", unit="", values=tuple(_yes(name == one.fits.chosen) for one, name, _ in found)),
        ),
    )


def _yes(said: bool) -> str:  # noqa: FBT001 - one word of a table
    return "yes" if said else "no"


def _profiles(shading: BurstShading) -> Curve:
    """Return the middle row of every channel before and after the correction by its own map."""
    columns: dict[str, list[float | str | None]] = {name: [] for name in ("channel", "column", "before", "after")}
    for one in shading.channels:
        before, after = middle_row(one)
        columns["channel"] += [one.channel] * before.size
        columns["column"] += one.data.columns.tolist()
        columns["before"] += _numbers(before)
        columns["after"] += _numbers(after)
    count = len(columns["channel"])
    return Curve(
        name="shading_profile",
        columns=(
            Column(name="iso", unit="1", values=(shading.iso,) * count),
            Column(name="exposure_s", unit="s", values=(shading.burst.exposure_s,) * count),
            Column(name="channel", unit="", values=tuple(columns["channel"])),
            Column(name="column", unit="pixel", values=tuple(columns["column"])),
            Column(name="before", unit="DN", values=tuple(columns["before"])),
            Column(name="after", unit="DN", values=tuple(columns["after"])),
        ),
    )


def middle_row(shading: ChannelShading) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the signal of the bins of the middle row before and after correction, shape (bin columns,) [DN]."""
    data, model = shading.data, shading.fits.best
    middle = data.rows.size // 2
    before = data.signal_dn[middle]
    surface = model.surface(data.rows[middle], data.columns)
    return before, before * model.maximum_dn / surface


def _numbers(values: NDArray[np.float64]) -> list[float | None]:
    return [float(value) if np.isfinite(value) else None for value in values]


def _findings(bursts: IsoBursts, failures: Sequence[tuple[Burst, str, str]]) -> tuple[Finding, ...]:
    """Return what is to be said of (burst, channel, reason)."""
    by_reason: dict[tuple[str, str], list[str]] = {}
    for burst in dict.fromkeys(burst for burst, _, _ in failures):
        reasons: dict[str, list[str]] = {}
        for other, channel, reason in failures:
            if other is burst:
                reasons.setdefault(reason, []).append(channel)
        for reason, channels in reasons.items():
            by_reason.setdefault((", ".join(channels), reason), []).append(show_exposure(burst.exposure_s))
    return tuple(
        Finding(
            code="shading-not-measured",
            severity=Severity.WARNING,
            message=(
                f"lens shading of {channels} at {bursts.label}, flats of {', '.join(exposures)}, is not measured: "
                f"{reason}"
            ),
        )
        for (channels, reason), exposures in by_reason.items()
    )
