"""Patches of a chart: mean and variances per CFA plane, uneven light and flicker removed (METHOD 1.1, 1.11)."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Final, Protocol

import numpy as np
from numpy.typing import NDArray

from fullwell.raw.cfa import cell, channels
from fullwell.statistics.patch import without_surface

MAX_CLIPPED: Final = 1e-3
"""Share of values on a rail above which a patch's variance is not used (METHOD 1.11)."""


class Region(Protocol):
    """A rectangle of the visible mosaic, even in all its numbers [pixel], and what it is a picture of."""

    @property
    def name(self) -> str:
        """Return what the chart calls it."""
        ...

    @property
    def x(self) -> int:
        """Return the first column."""
        ...

    @property
    def y(self) -> int:
        """Return the first row."""
        ...

    @property
    def width(self) -> int:
        """Return the number of columns."""
        ...

    @property
    def height(self) -> int:
        """Return the number of rows."""
        ...

    @property
    def density(self) -> float | None:
        """Return the optical density, None where nobody knows it."""
        ...


@dataclass(frozen=True, slots=True, kw_only=True)
class PatchPoint:
    """One patch of one CFA plane, seen in one frame or several frames of one exposure.

    Parameters
    ----------
    patch, channel
        What it is.
    n
        Pixels of the plane.
    frames
        L.
    mean_dn
        Over pixels and frames [DN].
    variance_dn2, dof
        Of a single frame about its quadratic surface, temporal noise and fixed pattern together, mean over the frames
        [DN^2]; its degrees of freedom, n - 6 for one frame, by Satterthwaite for several.
    temporal_variance_dn2, temporal_dof
        Between the frames, each frame's own surface removed and with it any flicker of the light [DN^2];
        (L - 1)(n - 6) degrees of freedom. NaN and 0 for one frame.
    spatial_variance_dn2, spatial_dof
        Of the mean of the L frames about its surface, temporal noise over L left in [DN^2]; n - 6 degrees of freedom.
    lowest, highest
        Codes [DN].
    clipped_low, clipped_high
        Share of the values on code 0, and on the white level or above it.
    density
        As the chart has it.

    """

    patch: str
    channel: str
    n: int
    frames: int
    mean_dn: float
    variance_dn2: float
    dof: float
    temporal_variance_dn2: float
    temporal_dof: float
    spatial_variance_dn2: float
    spatial_dof: float
    lowest: int
    highest: int
    clipped_low: float
    clipped_high: float
    density: float | None

    @property
    def clipped(self) -> bool:
        """Tell whether a rail cuts off too much for the variance to be used (METHOD 1.11)."""
        return max(self.clipped_low, self.clipped_high) > MAX_CLIPPED

    @property
    def constant(self) -> bool:
        """Tell whether all values are one code: nothing to be measured there."""
        return self.lowest == self.highest


def patch_points(
    mosaics: Sequence[NDArray[np.uint16]],
    patches: Iterable[Region],
    *,
    cfa: str,
    white_dn: float | Sequence[float] | None,
) -> tuple[PatchPoint, ...]:
    """Measure every patch in every CFA plane.

    Parameters
    ----------
    mosaics
        Frames of one exposure of a still scene, each of shape (height, width) [DN].
    patches
        Where the patches are; they lie inside the frames.
    cfa
        Order at the visible top-left pixel.
    white_dn
        White level, one or one per CFA site [DN]; None where unknown: nothing counts as clipped there.

    Returns
    -------
    tuple of PatchPoint
        By patch, then by CFA site.

    """
    named = channels(cfa)
    whites = [white_dn] * len(named) if white_dn is None or isinstance(white_dn, (int, float)) else list(white_dn)
    step = cell(cfa)
    found: list[PatchPoint] = []
    for patch in patches:
        for site, (channel, white) in enumerate(zip(named, whites, strict=True)):
            rows = slice(patch.y + site // step, patch.y + patch.height, step)
            columns = slice(patch.x + site % step, patch.x + patch.width, step)
            stack = np.stack([mosaic[rows, columns] for mosaic in mosaics])
            found.append(_point(stack, patch, channel=channel, white_dn=white))
    return tuple(found)


def _point(stack: NDArray[np.uint16], patch: Region, *, channel: str, white_dn: float | None) -> PatchPoint:
    """Measure one plane of one patch, ``stack`` of shape (frames, rows, columns)."""
    frames, rows, columns = stack.shape
    n = rows * columns
    mean = float(stack.mean(dtype=np.float64))
    residuals, terms = without_surface(stack - mean)
    dof = n - terms
    together = residuals.mean(axis=0)
    spatial = _sum_of_squares(together) / dof if dof > 0 else float("nan")
    temporal, temporal_dof = float("nan"), 0
    if frames > 1 and dof > 0:
        temporal_dof = (frames - 1) * dof
        temporal = _sum_of_squares(residuals - together) / temporal_dof
    variance, total_dof = _single_frame(spatial, dof, temporal, temporal_dof, frames=frames)
    return PatchPoint(
        patch=patch.name,
        channel=channel,
        n=n,
        frames=frames,
        mean_dn=mean,
        variance_dn2=variance,
        dof=total_dof,
        temporal_variance_dn2=temporal,
        temporal_dof=float(temporal_dof),
        spatial_variance_dn2=spatial,
        spatial_dof=float(dof),
        lowest=int(stack.min()),
        highest=int(stack.max()),
        clipped_low=float(np.mean(stack == 0)),
        clipped_high=0.0 if white_dn is None else float(np.mean(stack >= white_dn)),
        density=patch.density,
    )


def _single_frame(spatial: float, dof: int, temporal: float, temporal_dof: int, *, frames: int) -> tuple[float, float]:
    """Return the mean variance of single frames, spatial + temporal (L - 1) / L exactly, and its freedom."""
    if not temporal_dof:
        return spatial, float(dof)
    share = temporal * (frames - 1) / frames
    total = spatial + share
    doubt = spatial**2 / dof + share**2 / temporal_dof
    return total, total**2 / doubt if doubt > 0.0 else float(dof)


def _sum_of_squares(values: NDArray[np.float64]) -> float:
    return float(np.vdot(values, values))
