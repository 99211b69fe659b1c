"""Patches of a chart: mean and variances per CFA plane, uneven light and flicker removed (METHOD 1.1, 1.11).

`cut_patches` takes the patches out of a frame, so that the frame need not be kept; `measure_cuts` measures frames of
one exposure from what was taken out; `patch_points` does both.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final, Protocol

import numpy as np
from numpy.typing import NDArray

from fullwell.raw.cfa import cell, channels
from fullwell.statistics.patch import without_surface

MAX_CLIPPED: Final = 1e-3
"""Share of values on a rail above which a patch's variance is not used (METHOD 1.11)."""
LINE_TERMS: Final = 3
"""Terms that a surface takes from the means of rows, and from those of columns."""

Cuts = tuple[NDArray[np.uint16], ...]
"""The pixels of each patch of one frame [DN]."""


class Region(Protocol):
    """A rectangle of the visible mosaic, even in all its numbers [pixel], and what it is a picture of."""

    @property
    def name(self) -> str: ...  # noqa: D102 - what the chart calls it

    @property
    def x(self) -> int: ...  # noqa: D102 - first column

    @property
    def y(self) -> int: ...  # noqa: D102 - first row

    @property
    def width(self) -> int: ...  # noqa: D102 - columns

    @property
    def height(self) -> int: ...  # noqa: D102 - rows

    @property
    def density(self) -> float | None: ...  # noqa: D102 - None where nobody knows it


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
    mean_dn, frame_means_dn
        Over pixels and frames, and of each frame [DN].
    variance_dn2, dof
        Of a single frame about its quadratic surface, temporal noise and fixed pattern together, mean over the frames
        [DN^2]; its degrees of freedom, n - 6 for one frame, by Satterthwaite for several.
    temporal_variance_dn2, temporal_dof
        Between the frames, each frame's own surface removed and with it any flicker of the light [DN^2];
        (L - 1)(n - 6) degrees of freedom. NaN and 0 for one frame.
    spatial_variance_dn2, spatial_dof
        Of the mean of the L frames about its surface, temporal noise over L left in [DN^2]; n - 6 degrees of freedom.
    row_variance_dn2, column_variance_dn2
        Parts of a single frame's variance that rows and columns have in common, signed [DN^2].
    row_temporal_dn2, column_temporal_dn2
        The same of the variance between the frames; of one frame, which cannot tell them apart, all of it [DN^2].
    rows, columns
        Size in pixels of the plane.
    lowest, highest
        Codes [DN].
    clipped_low, clipped_high
        Share of the values on code 0, and on the white level or above it.
    density
        As the chart has it.
    full
        Whether its pixels are full though no rail cuts them off: its variance tells of nothing.

    """

    patch: str
    channel: str
    n: int
    frames: int
    mean_dn: float
    frame_means_dn: tuple[float, ...]
    variance_dn2: float
    dof: float
    temporal_variance_dn2: float
    temporal_dof: float
    spatial_variance_dn2: float
    spatial_dof: float
    row_variance_dn2: float
    column_variance_dn2: float
    row_temporal_dn2: float
    column_temporal_dn2: float
    rows: int
    columns: int
    lowest: int
    highest: int
    clipped_low: float
    clipped_high: float
    density: float | None
    full: bool = False

    @property
    def clipped(self) -> bool:
        """Tell whether a rail cuts off too much for the variance to be used (METHOD 1.11)."""
        return max(self.clipped_low, self.clipped_high) > MAX_CLIPPED

    @property
    def admitted(self) -> bool:
        """Tell whether the patch may take part in fits: not clipped or full, and more than one code in it."""
        return not self.clipped and not self.full and self.dof > 0 and self.highest > self.lowest

    @property
    def noise_dn2(self) -> float:
        """Return the variance between frames, that of a single frame where there is but one [DN^2]."""
        return self.temporal_variance_dn2 if self.frames > 1 else self.variance_dn2


def patch_points(
    mosaics: Sequence[NDArray[np.uint16]],
    patches: Sequence[Region],
    *,
    cfa: str,
    white_dn: float | Sequence[float] | None,
) -> tuple[PatchPoint, ...]:
    """Measure every patch in every CFA plane of frames of one exposure.

    Parameters
    ----------
    mosaics
        Frames of a still scene, each of shape (height, width) [DN].
    patches
        Where the patches are; they lie inside the frames.
    cfa, white_dn
        As in `measure_cuts`.

    Returns
    -------
    tuple of PatchPoint
        By patch, then by CFA site.

    """
    return measure_cuts([cut_patches(mosaic, patches) for mosaic in mosaics], patches, cfa=cfa, white_dn=white_dn)


def cut_patches(mosaic: NDArray[np.uint16], patches: Sequence[Region]) -> Cuts:
    """Return copies of the pixels of every patch."""
    return tuple(mosaic[patch.y : patch.y + patch.height, patch.x : patch.x + patch.width].copy() for patch in patches)


def plane_of(cut: NDArray[np.uint16], site: int, *, cfa: str) -> NDArray[np.uint16]:
    """Return one CFA site's pixels of a mosaic or of a patch that begins on a whole cell, a view."""
    step = cell(cfa)
    return cut[..., site // step :: step, site % step :: step]


def measure_cuts(
    frames: Sequence[Cuts],
    patches: Sequence[Region],
    *,
    cfa: str,
    white_dn: float | Sequence[float] | None,
) -> tuple[PatchPoint, ...]:
    """Measure patches that were taken out of frames of one exposure.

    Parameters
    ----------
    frames
        What `cut_patches` took out of each.
    patches
        What they are.
    cfa
        Order at the visible top-left pixel.
    white_dn
        White level, one or one per CFA site [DN]; None where unknown: nothing counts as clipped there.

    """
    named = channels(cfa)
    whites: Sequence[float | None]
    whites = [white_dn] * len(named) if white_dn is None or isinstance(white_dn, int | float) else white_dn
    found: list[PatchPoint] = []
    for index, patch in enumerate(patches):
        stack = np.stack([cuts[index] for cuts in frames])
        for site, (channel, white) in enumerate(zip(named, whites, strict=True)):
            found.append(_point(plane_of(stack, site, cfa=cfa), patch, channel=channel, white_dn=white))
    return tuple(found)


def _point(stack: NDArray[np.uint16], patch: Region, *, channel: str, white_dn: float | None) -> PatchPoint:
    """Measure one plane of one patch, ``stack`` of shape (frames, rows, columns)."""
    frames, rows, columns = stack.shape
    n = rows * columns
    means = stack.mean(axis=(1, 2), dtype=np.float64)
    mean = float(means.mean())
    residuals, terms = without_surface(stack - mean)
    dof = n - terms
    together = residuals.mean(axis=0)
    spatial = _sum_of_squares(together) / dof if dof > 0 else float("nan")
    temporal, temporal_dof = float("nan"), 0
    moving = residuals - together
    if frames > 1 and dof > 0:
        temporal_dof = (frames - 1) * dof
        temporal = _sum_of_squares(moving) / temporal_dof
    variance, total_dof = _single_frame(spatial, dof, temporal, temporal_dof, frames=frames)
    row, column = _line_variances(residuals, variance, frames=frames, dof=dof)
    between = _line_variances(moving, temporal, frames=frames - 1, dof=dof) if temporal_dof else (row, column)
    return PatchPoint(
        patch=patch.name,
        channel=channel,
        n=n,
        frames=frames,
        mean_dn=mean,
        frame_means_dn=tuple(means.tolist()),
        variance_dn2=variance,
        dof=total_dof,
        temporal_variance_dn2=temporal,
        temporal_dof=float(temporal_dof),
        spatial_variance_dn2=spatial,
        spatial_dof=float(dof),
        row_variance_dn2=row,
        column_variance_dn2=column,
        row_temporal_dn2=between[0],
        column_temporal_dn2=between[1],
        rows=rows,
        columns=columns,
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


def _line_variances(residuals: NDArray[np.float64], variance: float, *, frames: int, dof: int) -> tuple[float, float]:
    """Return what rows and columns share, from the means of so many independent ``frames``; signed.

    A mean of a line holds what its pixels have of their own beside, which is ``variance`` without either; across the
    lines the surface has taken three terms of both.
    """
    rows, columns = residuals.shape[1:]
    if min(rows, columns) <= LINE_TERMS:
        return 0.0, 0.0
    left = np.array([columns * (rows - LINE_TERMS), rows * (columns - LINE_TERMS)]) / dof
    length = np.array([columns, rows])
    squares = [_sum_of_squares(residuals.mean(axis=axis)) for axis in (2, 1)]
    seen = np.array(squares) / (frames * (np.array([rows, columns]) - LINE_TERMS)) - variance / length
    row, column = np.linalg.solve(np.eye(2) - left / length[:, None], seen)
    return float(row), float(column)


def _sum_of_squares(values: NDArray[np.float64]) -> float:
    return float(np.vdot(values, values))
