"""Where codes end: blacks that are cut off, and white and black levels against what the pixels and the margins say."""

from collections.abc import Sequence
from typing import Final

import numpy as np
from numpy.typing import NDArray

from fullwell.findings import Finding, Severity
from fullwell.fit.black_level import METADATA_STD_ERROR
from fullwell.fit.censored import MAX_CLIPPED
from fullwell.raw.image import Levels
from fullwell.statistics.series import Histogram
from fullwell.workflow.masked import MaskedArea

CODES_THAT_SHOW_A_CUT: Final = 4
APART_ERRORS: Final = 4.0
APART_DN: Final = 1.0
"""Least distance of optical black and declared level that is worth telling: a tag is a whole code [DN]."""
BLOCK: Final = 8
DARK_SHARE: Final = 0.02
"""Of the blocks, the darkest, that the noise of optical black is compared with."""
FEWEST_DARK: Final = 20
NOISIER: Final = 1.25
"""Ratio of variances beyond which optical black is called noisier than any part of the picture."""


def cut_share(histogram: Histogram) -> float:
    """Return the share of values on the lowest code where that is a rail, else 0.

    It is one where more values lie on it than on the next, which no falling tail does, and, unless it is code 0, where
    enough codes show the shape of the cut.
    """
    counts = histogram.counts
    total = int(counts.sum())
    share = float(counts[0]) / total
    filled = np.flatnonzero(counts)
    if share <= MAX_CLIPPED or filled.size < 2:
        return 0.0
    if histogram.first_code == 0:
        return share
    following = float(counts[filled[1]])
    shown = int((counts > MAX_CLIPPED * total).sum()) >= CODES_THAT_SHOW_A_CUT
    return share if shown and counts[0] > following + 5.0 * np.sqrt(following + 1.0) else 0.0


def clipping_findings(channels: Sequence[str], histograms: Sequence[Histogram]) -> tuple[Finding, ...]:
    """Return a finding where blacks are cut off."""
    cut = [
        (channel, histogram, share)
        for channel, histogram in zip(channels, histograms, strict=True)
        if (share := cut_share(histogram)) > 0.0
    ]
    if not cut:
        return ()
    said = ", ".join(
        f"{100.0 * share:.2f} % of {channel} on {histogram.first_code} DN" for channel, histogram, share in cut
    )
    message = (
        f"Blacks are cut off ({said}): what lay below is lost. Means and variances of dark areas are wrong; read noise "
        "is to be had from a censored fit only, and not without doubt."
    )
    return (Finding(code="black-clipped", severity=Severity.WARNING, message=message),)


def range_findings(channels: Sequence[str], histograms: Sequence[Histogram], *, bit_depth: int) -> tuple[Finding, ...]:
    """Return a finding where codes lie above what the bit depth allows."""
    limit = 2**bit_depth
    above = {
        channel: int(one.counts[max(limit - one.first_code, 0) :].sum())
        for channel, one in zip(channels, histograms, strict=True)
        if one.first_code + len(one.counts) > limit
    }
    if not above:
        return ()
    said = ", ".join(f"{count} of {channel}" for channel, count in above.items())
    highest = max(one.first_code + len(one.counts) - 1 for one in histograms)
    message = (
        f"Codes lie above {limit - 1} DN, the highest of {bit_depth} bits ({said}, up to {highest} DN): stuck pixels, "
        "or another bit depth."
    )
    return (Finding(code="codes-above-bit-depth", severity=Severity.WARNING, message=message),)


def optical_black_findings(masked: Sequence[MaskedArea], black: Levels | None, *, at: str = "") -> tuple[Finding, ...]:
    """Return a finding where masked pixels and the declared black level disagree.

    Parameters
    ----------
    masked
        One per CFA site in order, or none.
    black
        As declared; a default of the format is no declaration.
    at
        Where, with a blank before it.

    """
    if not masked or black is None or black.source == "default":
        return ()
    apart = [
        (area, declared)
        for area, declared in zip(masked, _per_site(black, len(masked)), strict=True)
        if abs(area.mean_dn - declared)
        > max(APART_DN, APART_ERRORS * float(np.hypot(area.std_error_dn, METADATA_STD_ERROR)))
    ]
    if not apart:
        return ()
    said = ", ".join(f"{area.channel} {area.mean_dn:.1f} ± {area.std_error_dn:.1f} DN" for area, _ in apart)
    declared = "/".join(f"{value:g}" for value in dict.fromkeys(value for _, value in apart))
    name = f"{black.source} {black.tag}".strip()
    message = (
        f"Optical black and the declared black level disagree{at}: masked pixels read {said}, {name} says "
        f"{declared} DN. Dark frames or an exposure bracket decide."
    )
    return (Finding(code="black-levels-disagree", severity=Severity.WARNING, message=message),)


def noise_findings(masked: Sequence[MaskedArea], planes: Sequence[NDArray[np.uint16]]) -> tuple[Finding, ...]:
    """Return a finding where masked pixels are noisier than the darkest parts of the picture, which light only adds to.

    Parameters
    ----------
    masked
        One per CFA site in order, or none.
    planes
        The visible mosaic by site [DN].

    """
    noisier = [
        (area, dark)
        for area, plane in zip(masked, planes, strict=bool(masked))
        if (dark := darkest_variance(plane)) is not None and area.variance_dn2 > NOISIER * max(dark, 1.0 / 12.0)
    ]
    if not noisier:
        return ()
    said = "; ".join(f"{area.channel} {area.variance_dn2:.0f} against {dark:.0f} DN²" for area, dark in noisier)
    message = (
        f"Optical black is noisier than the darkest parts of the picture (variance {said}): its noise is not that of "
        "the active area, and its level need not be."
    )
    return (Finding(code="optical-black-noisier", severity=Severity.WARNING, message=message),)


def darker_findings(
    channels: Sequence[str], planes: Sequence[NDArray[np.uint16]], black: Levels | None
) -> tuple[Finding, ...]:
    """Return a finding where parts of the picture are darker than the declared black level.

    Parameters
    ----------
    channels, planes
        By CFA site [DN].
    black
        As declared; a default of the format is no declaration.

    """
    if black is None or black.source == "default":
        return ()
    darker = [
        (channel, level, declared)
        for channel, plane, declared in zip(channels, planes, _per_site(black, len(channels)), strict=True)
        if (level := _darkest_level(plane)) is not None and level < declared - APART_DN
    ]
    if not darker:
        return ()
    said = ", ".join(f"{channel} {level:.1f} DN" for channel, level, _ in darker)
    declared = "/".join(f"{value:g}" for value in dict.fromkeys(value for _, _, value in darker))
    message = (
        f"Parts of the picture are darker than the declared black level {declared} DN (darkest blocks, six errors "
        f"above their mean: {said}): the true level is lower. Dark frames or an exposure bracket tell it."
    )
    return (Finding(code="black-level-too-high", severity=Severity.WARNING, message=message),)


def _darkest_level(plane: NDArray[np.uint16]) -> float | None:
    """Return what the level of the darkest blocks is at most, six errors above their mean [DN].

    Of so many blocks the least lies four errors low by chance. The darkest tenth of a per cent is averaged, so that one
    defect does not decide.
    """
    rows, columns = (side // BLOCK * BLOCK for side in plane.shape)
    tiles = plane[:rows, :columns].reshape(rows // BLOCK, BLOCK, columns // BLOCK, BLOCK)
    means = tiles.mean(axis=(1, 3), dtype=np.float64).ravel()
    variance = darkest_variance(plane)
    if variance is None:
        return None
    count = max(means.size // 1000, 4)
    return float(np.partition(means, count)[:count].mean() + 6.0 * np.sqrt(variance + 1.0 / 12.0) / BLOCK)


def darkest_variance(plane: NDArray[np.uint16]) -> float | None:
    """Return the variance of a pixel in the darkest blocks of a plane, from differences along rows [DN^2].

    The median over blocks; None where there are too few. Texture raises it.
    """
    rows, columns = (side // BLOCK * BLOCK for side in plane.shape)
    tiles = plane[:rows, :columns].reshape(rows // BLOCK, BLOCK, columns // BLOCK, BLOCK).astype(np.int32)
    means = tiles.mean(axis=(1, 3)).ravel()
    variances = (np.diff(tiles, axis=3).astype(np.float64) ** 2).mean(axis=(1, 3)).ravel() / 2.0
    count = int(DARK_SHARE * means.size)
    if count < FEWEST_DARK:
        return None
    darkest = np.argpartition(means, count)[:count]
    return float(np.median(variances[darkest]))


def _per_site(levels: Levels, sites: int) -> tuple[float, ...]:
    return levels.values if len(levels.values) == sites else levels.values[:1] * sites
