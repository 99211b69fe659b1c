"""Black and white levels of a DNG file, per CFA site of the visible mosaic.

BlackLevel is a repeating pattern whose origin is the top-left corner of the ActiveArea (DNG 1.4, tag BlackLevel),
in row-column-sample order; BlackLevelDeltaH and DeltaV add a level per column and per row of the ActiveArea. All
levels hold after the LinearizationTable (DNG 1.4, chapter 5).
"""

import math
from dataclasses import dataclass

import numpy as np

from fullwell.findings import Finding, Severity
from fullwell.raw.cfa import cell
from fullwell.raw.directory import Directory
from fullwell.raw.image import Area, Levels
from fullwell.raw.tags import Tag

_LISTED = 16
"""Level tags with more values than this are summarised in a finding, not listed."""


@dataclass(frozen=True, slots=True, kw_only=True)
class DeclaredLevels:
    """Levels as the file declares them, by site, with what is to be said about them."""

    black: Levels | None
    white: Levels | None
    tags: tuple[tuple[str, tuple[float, ...]], ...]
    findings: tuple[Finding, ...]


def declared_levels(image: Directory, *, cfa: str, active_area: Area) -> DeclaredLevels:
    """Return the levels of a raw directory.

    Parameters
    ----------
    image
        Directory of the raw image.
    cfa
        Order at the visible top-left pixel.
    active_area
        Visible mosaic in raw coordinates.

    Returns
    -------
    DeclaredLevels
        Where the file has no BlackLevel or WhiteLevel: the specification's 0 and 2^BitsPerSample - 1, whose source
        is ``default``.

    """
    period = cell(cfa)
    findings: list[Finding] = []
    black = _black(image, period=period, findings=findings)
    if black is not None:
        deltas = _deltas(image, period=period, active_area=active_area, findings=findings)
        black = Levels(
            values=tuple(float(value) for value in (np.reshape(black.values, (period, period)) + deltas).ravel()),
            source=black.source,
            tag=black.tag,
        )
    white = image.number(Tag.WHITE_LEVEL)
    white_source = "default" if white is None else "metadata"
    if white is None:
        white = float(2 ** min(max(image.integer(Tag.BITS_PER_SAMPLE, 16), 1), 32) - 1)
    return DeclaredLevels(
        black=black,
        white=Levels(values=(white,) * period**2, source=white_source, tag="WhiteLevel"),
        tags=tuple(
            (name, image.numbers(tag))
            for name, tag in (
                ("BlackLevel", Tag.BLACK_LEVEL),
                ("BlackLevelDeltaH", Tag.BLACK_LEVEL_DELTA_H),
                ("BlackLevelDeltaV", Tag.BLACK_LEVEL_DELTA_V),
                ("WhiteLevel", Tag.WHITE_LEVEL),
            )
            if 0 < len(image.numbers(tag)) <= _LISTED
        ),
        findings=tuple(findings),
    )


def _black(image: Directory, *, period: int, findings: list[Finding]) -> Levels | None:
    sites = period * period
    values = image.numbers(Tag.BLACK_LEVEL)
    if not values:
        return Levels(values=(0.0,) * sites, source="default", tag="BlackLevel")
    rows, columns = (*image.integers(Tag.BLACK_LEVEL_REPEAT_DIM), 1, 1)[:2]
    samples = image.integer(Tag.SAMPLES_PER_PIXEL, 1)
    if samples > 1 and len(values) == rows * columns * samples:
        return None
    if rows < 1 or columns < 1 or len(values) != rows * columns or not all(map(math.isfinite, values)):
        findings.append(
            Finding(
                code="black-level-tag-damaged",
                severity=Severity.WARNING,
                message=f"BlackLevel has {len(values)} values for a pattern of {rows} x {columns}; it is not used.",
            )
        )
        return None
    pattern = np.reshape(np.asarray(values, dtype=np.float64), (rows, columns))
    whole = np.tile(pattern, (math.lcm(rows, period) // rows, math.lcm(columns, period) // columns))
    by_site = [whole[site // period :: period, site % period :: period] for site in range(sites)]
    if any(np.ptp(site) > 0 for site in by_site):
        findings.append(
            Finding(
                code="black-level-averaged",
                severity=Severity.INFO,
                message=f"BlackLevel repeats every {rows} x {columns} pixels; its mean per CFA site is used.",
            )
        )
    return Levels(values=tuple(float(site.mean()) for site in by_site), source="metadata", tag="BlackLevel")


def _deltas(
    image: Directory, *, period: int, active_area: Area, findings: list[Finding]
) -> np.ndarray[tuple[int, int], np.dtype[np.float64]]:
    """Return the mean BlackLevelDeltaH + DeltaV of each site, shape (period, period) [DN]."""
    total = np.zeros((period, period))
    sides = (
        ("BlackLevelDeltaH", Tag.BLACK_LEVEL_DELTA_H, active_area.right - active_area.left, (1, period)),
        ("BlackLevelDeltaV", Tag.BLACK_LEVEL_DELTA_V, active_area.bottom - active_area.top, (period, 1)),
    )
    for name, tag, length, shape in sides:
        delta = np.asarray(image.numbers(tag), dtype=np.float64)
        if delta.size == 0:
            continue
        if delta.size != length or length < period or not np.isfinite(delta).all():
            message = f"{name} has {delta.size} values for {length} lines; it is not used."
            findings.append(Finding(code="black-level-tag-damaged", severity=Severity.WARNING, message=message))
            continue
        total += np.reshape([delta[phase::period].mean() for phase in range(period)], shape)
        if np.ptp(delta) > 0:
            message = (
                f"{name} varies from {delta.min():g} to {delta.max():g} DN over the frame; "
                "its mean per CFA site is part of the black level."
            )
            findings.append(Finding(code="black-level-delta-averaged", severity=Severity.INFO, message=message))
    return total
