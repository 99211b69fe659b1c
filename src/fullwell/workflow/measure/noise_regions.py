"""Read noise in sixteen regions of the frame, and whether they agree (METHOD 3.1)."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from fullwell.figures.results import Column, Curve
from fullwell.findings import Finding, Severity
from fullwell.fit.constancy import equal_variances
from fullwell.fit.pooling import SIGNIFICANCE
from fullwell.fit.read_noise import analogue_read_noise
from fullwell.statistics.series import PlaneStatistics
from fullwell.units import DN, DN2, Measured
from fullwell.workflow.measure.bursts import IsoBursts
from fullwell.workflow.measure.read_noise import choose_burst
from fullwell.workflow.measure.regions import Region
from fullwell.workflow.measure.section import Section
from fullwell.workflow.measure.transfer_points import correlation_inflation

ACROSS = 4
NOTABLE = 0.02
"""Relative scatter of the noise between regions below which a significant difference is not worth a finding."""


@dataclass(frozen=True, slots=True, kw_only=True)
class _RegionNoise:
    region: Region
    variance_dn2: float
    dof: float


def measure_noise_regions(bursts: IsoBursts) -> Section:
    """Measure the temporal noise of the read-noise burst in a grid of regions, per channel."""
    burst = choose_burst(bursts)
    if burst is None:
        return Section()
    curves: list[Curve] = []
    differing: list[str] = []
    for plane in burst.statistics.planes:
        found = _regions(plane, bursts.cell)
        if plane.channel in bursts.black_clipped or not found:
            continue
        inflation = _inflation(plane)
        dof = [one.dof / inflation for one in found]
        variances = [one.variance_dn2 for one in found]
        curves.append(_curve(bursts, plane, found, dof))
        same = equal_variances(variances, dof)
        spread = float(np.std(variances) / np.mean(variances)) / 2.0
        if same.p_value < SIGNIFICANCE / len(burst.statistics.planes) and spread > NOTABLE:
            differing.append(f"{plane.channel} (by {100.0 * spread:.1f} %, p = {same.p_value:.2g})")
    return Section(curves=tuple(curves), findings=_findings(bursts, differing))


def _regions(plane: PlaneStatistics, cell: int) -> tuple[_RegionNoise, ...]:
    """Pool the tiles of each cell of a grid of 4 x 4 that tell something; nothing with fewer tiles or without noise."""
    tiles = plane.tiles
    if min(tiles.n.shape) < ACROSS or plane.frames < 2 or plane.temporal_variance <= 0.0:
        return ()
    edges = [[size * k // ACROSS for k in range(ACROSS + 1)] for size in tiles.n.shape]
    found: list[_RegionNoise] = []
    for top, bottom in zip(edges[0], edges[0][1:], strict=False):
        for left, right in zip(edges[1], edges[1][1:], strict=False):
            part = (slice(top, bottom), slice(left, right))
            dof = tiles.temporal_dof[part]
            known = dof > 0  # a tile of one pixel in the corner tells nothing
            if not known.any():
                continue
            step = cell * tiles.size
            found.append(
                _RegionNoise(
                    region=Region(
                        x=left * step,
                        y=top * step,
                        width=min(right * tiles.size, plane.columns) * cell - left * step,
                        height=min(bottom * tiles.size, plane.rows) * cell - top * step,
                    ),
                    variance_dn2=float((dof * tiles.temporal_variance[part])[known].sum() / dof.sum()),
                    dof=float(dof.sum()),
                )
            )
    return tuple(found)


def _inflation(plane: PlaneStatistics) -> float:
    """Return how much wider variances scatter than those of normal, independent noise: lines and telegraph pixels."""
    normal = 2.0 * plane.temporal_variance**2 / (plane.frames - 1)
    tails = plane.temporal_variance_scatter / normal if normal > 0.0 else 1.0
    return max(1.0, tails) * correlation_inflation(plane, plane.temporal_variance)


def _curve(bursts: IsoBursts, plane: PlaneStatistics, found: Sequence[_RegionNoise], dof: Sequence[float]) -> Curve:
    count = len(found)
    noises = [
        analogue_read_noise(
            Measured.normal(one.variance_dn2, one.variance_dn2 * (2.0 / own) ** 0.5, DN2),
            spatial_spread_dn=plane.body_spread,
            n=int(one.dof),
        ).noise
        for one, own in zip(found, dof, strict=True)
    ]
    return Curve(
        name="read_noise_regions",
        columns=(
            Column(name="iso", unit="1", values=(bursts.iso,) * count),
            Column(name="channel", unit="", values=(plane.channel,) * count),
            Column(name="x", unit="pixel", values=tuple(one.region.x for one in found)),
            Column(name="y", unit="pixel", values=tuple(one.region.y for one in found)),
            Column(name="width", unit="pixel", values=tuple(one.region.width for one in found)),
            Column(name="height", unit="pixel", values=tuple(one.region.height for one in found)),
            Column(name="read_noise", unit=DN, values=tuple(one.value for one in noises)),
            Column(name="std_error", unit=DN, values=tuple(one.std_error for one in noises)),
        ),
    )


def _findings(bursts: IsoBursts, differing: Sequence[str]) -> tuple[Finding, ...]:
    if not differing:
        return ()
    message = (
        f"read noise at {bursts.label} is not the same in every region of the frame: {', '.join(differing)}; look for "
        "glow, warm parts of the chip or readout blocks"
    )
    return (Finding(code="read-noise-regions-differ", severity=Severity.INFO, message=message),)
