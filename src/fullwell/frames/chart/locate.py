"""Find a chart's patches in a mosaic, on a small linear preview of it; refuse where they are not found for sure."""

from dataclasses import dataclass, replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

from fullwell.frames.chart.agreement import Agreement, agreement
from fullwell.frames.chart.areas import even_areas
from fullwell.frames.chart.borders import laid_on_borders
from fullwell.frames.chart.candidates import Candidate, candidates
from fullwell.frames.chart.definition import ChartDefinition
from fullwell.frames.chart.homography import UNIT_SQUARE, convex, homography, mapped, quadrilaterals
from fullwell.frames.chart.patches import SMALLEST, Patch
from fullwell.frames.chart.preview import Preview, preview
from fullwell.frames.chart.rectangles import inner_rectangle

CONFIDENCE: Final = 0.5
"""Below it a location is refused."""
INSET: Final = 0.17
"""Share of a patch's edges that is left out on each side."""
_SIZES: Final = (700, 1400, 350)
"""Longer edges of the previews that are searched, one after the other until the chart is found [pixel]."""
_SURE: Final = 0.8
"""Confidence at which no other preview is searched."""
_COMPARED: Final = 60
"""Candidates that are compared with the chart's light."""
_REFINED: Final = 4
"""Places of a chart of touching patches whose borders are looked at."""
_PROPORTION: Final = (0.8, 1.0)
_EVEN: Final = (0.5, 1.0)
_MET: Final = (0.2, 1.0)
_ENOUGH: Final = (4.0, 12.0)
"""From no to full confidence: share of the variance of log light explained, share of even patches, share of the
visible patches that are areas of their own, patches that count."""
_SCATTER: Final = 0.25
"""Scatter inside a patch over that between patches, up to which it is even."""
_LEAD: Final = 0.6
"""Patches by which the best place must lead the second best."""
_DOUBT: Final = 0.4
"""Factor on the confidence where it does not."""
_REFUSED: Final = 0.45
"""Most confidence of a location that is refused for another reason."""

Point = tuple[float, float]
Corners = tuple[Point, Point, Point, Point]


@dataclass(frozen=True, slots=True, kw_only=True)
class Located:
    """Where a chart is.

    Parameters
    ----------
    patches
        What to measure; empty where nothing was found.
    confidence
        0 to 1; below `CONFIDENCE` the caller refuses, with ``reason``.
    corners
        x, y of the chart's corners, clockwise from the chart's own top left (counter-clockwise where its back faces
        the camera) [pixel]; empty where nothing was found.
    orientation
        Clockwise turn of the chart in the frame, to the nearest quarter [degree].
    reason
        A sentence that says why the location is not trusted, empty where it is.

    """

    patches: tuple[Patch, ...]
    confidence: float
    corners: tuple[Point, ...]
    orientation: int
    reason: str = ""


@dataclass(frozen=True, slots=True, kw_only=True)
class _Place:
    """One supposed place, in pixels of the mosaic, and how good it is."""

    matrix: NDArray[np.float64]
    agreed: Agreement
    confidence: float
    weight: float
    candidate: Candidate | None = None
    given: bool = False
    doubtful: bool = False


def locate(
    mosaic: NDArray[np.uint16],
    *,
    cfa: str,
    black: float,
    white: float,
    definition: ChartDefinition,
    corners: Corners | None = None,
) -> Located:
    """Return where a chart's patches are.

    Parameters
    ----------
    mosaic
        Visible pixels, shape (height, width) [DN].
    cfa
        Order at its top-left pixel.
    black, white
        Levels, the black level perhaps some DN wrong [DN].
    definition
        The chart.
    corners
        x, y of the chart's corners, clockwise from the chart's own top left, where the user knows them [pixel].

    """
    if corners is not None:
        if not convex(np.array(corners, dtype=np.float64)):
            return _nothing("These corners are not those of a chart: give them clockwise, no three of them in a line.")
        return _located(_given(mosaic, corners, cfa=cfa, black=black, white=white, definition=definition), definition)
    best: _Place | None = None
    scales: set[int] = set()
    for longest in _SIZES:
        picture = preview(mosaic, cfa=cfa, black=black, white=white, longest=longest)
        if picture.empty:
            return _nothing("The frame shows nothing but noise: no chart can be found in it.")
        if picture.scale in scales:
            continue
        scales.add(picture.scale)
        place = _searched(picture, definition)
        if place is not None and (best is None or place.confidence > best.confidence):
            best = place
        if best is not None and best.confidence >= _SURE:
            break
    return _nothing(_not_found(definition, 0.0)) if best is None else _located(best, definition)


def _searched(picture: Preview, definition: ChartDefinition) -> _Place | None:
    """Return the best place in a preview; its confidence counts what the second best says against it."""
    areas = even_areas(picture)
    sides = (False, True) if definition.transmissive and not definition.in_line else (False,)
    found = [
        one
        for mirrored in sides
        for one in candidates(areas, definition, shape=picture.light.shape, mirrored=mirrored)[:_COMPARED]
    ]
    places = sorted((_compared(picture, definition, one) for one in found), key=lambda one: -one.weight)
    if definition.touching:
        refined = [_refined(picture, definition, one) for one in places[:_REFINED]]
        places = sorted(refined, key=lambda one: -one.weight)
    if not places:
        return None
    best = places[0]
    rivals = [one for one in places[1:] if _elsewhere(one, best, definition)]
    tied = bool(rivals) and rivals[0].weight > best.weight - _LEAD
    doubtful = best.confidence >= CONFIDENCE and (tied or _headless(best, definition))
    confidence = best.confidence * (_DOUBT if doubtful else 1.0)
    return replace(best, matrix=_of_mosaic(picture.scale) @ best.matrix, confidence=confidence, doubtful=doubtful)


def _refined(picture: Preview, definition: ChartDefinition, place: _Place) -> _Place:
    """Return the place of a chart of touching patches with their borders laid upon those in the light."""
    if place.candidate is None:
        return place
    met = place.candidate.met
    matrix = laid_on_borders(
        picture, definition, place.matrix, known=(definition.centres[met], place.candidate.middles)
    )
    return _compared(picture, definition, replace(place.candidate, matrix=matrix))


def _compared(picture: Preview, definition: ChartDefinition, candidate: Candidate) -> _Place:
    agreed = agreement(picture, definition, candidate.matrix)
    met = int((candidate.met & agreed.visible).sum())
    missed = int((~candidate.met & agreed.visible & ~agreed.clipped).sum())
    confidence = _confidence(agreed, share_met=met / max(met + missed, 1))
    weight = (met - missed) * max(agreed.proportion, 0.0) * _even(agreed)
    return _Place(matrix=candidate.matrix, agreed=agreed, confidence=confidence, weight=weight, candidate=candidate)


def _confidence(agreed: Agreement, *, share_met: float) -> float:
    """Return how far a place is to be trusted, 0 to 1: every kind of evidence may spoil it."""
    enough = int((agreed.visible & ~agreed.clipped).sum())
    return (
        _ramp(agreed.proportion, _PROPORTION)
        * _ramp(_even(agreed), _EVEN)
        * _ramp(share_met, _MET)
        * _ramp(enough, _ENOUGH)
    )


def _even(agreed: Agreement) -> float:
    """Return the share of the patches inside the picture that are even."""
    return float((agreed.scatter[agreed.inside] < _SCATTER).mean()) if agreed.inside.any() else 0.0


def _ramp(value: float, ends: tuple[float, float]) -> float:
    """Return 0 below the first end, 1 above the second, and what lies between in between."""
    return float(np.clip((value - ends[0]) / (ends[1] - ends[0]), 0.0, 1.0))


def _headless(place: _Place, definition: ChartDefinition) -> bool:
    """Whether the lightest step of a strip is not seen as one: its steps are alike, so nobody knows which is which."""
    lightest = int(np.argmax(definition.colours.sum(axis=1)))
    return definition.in_line and place.candidate is not None and not place.candidate.met[lightest]


def _elsewhere(one: _Place, other: _Place, definition: ChartDefinition) -> bool:
    """Whether two places give a patch to different light."""
    apart = np.linalg.norm(mapped(one.matrix, definition.centres) - mapped(other.matrix, definition.centres), axis=1)
    corners = quadrilaterals(other.matrix, definition, share=1.0)
    edges = np.linalg.norm(np.roll(corners, -1, axis=1) - corners, axis=2).min(axis=1)
    return bool(np.median(apart / np.maximum(edges, 1e-9)) > 0.5)


def _of_mosaic(scale: int) -> NDArray[np.float64]:
    """Return the map from pixels of a preview, whose middles have whole numbers, to those of the mosaic."""
    return np.array([(scale, 0.0, 0.5 * scale), (0.0, scale, 0.5 * scale), (0.0, 0.0, 1.0)])


def _given(
    mosaic: NDArray[np.uint16],
    corners: Corners,
    *,
    cfa: str,
    black: float,
    white: float,
    definition: ChartDefinition,
) -> _Place:
    """Return the place that a user's corners say, compared with the light there."""
    matrix = homography(UNIT_SQUARE, np.array(corners, dtype=np.float64))
    picture = preview(mosaic, cfa=cfa, black=black, white=white, longest=_SIZES[0])
    agreed = agreement(picture, definition, np.linalg.inv(_of_mosaic(picture.scale)) @ matrix)
    return _Place(matrix=matrix, agreed=agreed, confidence=_confidence(agreed, share_met=1.0), weight=0.0, given=True)


def _located(place: _Place, definition: ChartDefinition) -> Located:
    boxes = [inner_rectangle(one) for one in quadrilaterals(place.matrix, definition, share=1.0 - 2.0 * INSET)]
    patches = tuple(
        Patch(name=one.name, x=x, y=y, width=width, height=height, density=one.density)
        for one, (x, y, width, height) in zip(definition.patches, boxes, strict=True)
    )
    corners = mapped(place.matrix, UNIT_SQUARE)
    across = corners[1] - corners[0]
    reason, confidence = _reason(place, patches, definition)
    return Located(
        patches=patches,
        confidence=confidence,
        corners=tuple((float(x), float(y)) for x, y in corners),
        orientation=int(np.round(np.degrees(np.arctan2(across[1], across[0])) / 90.0)) % 4 * 90,
        reason=reason,
    )


def _reason(place: _Place, patches: tuple[Patch, ...], definition: ChartDefinition) -> tuple[str, float]:
    """Return why a location must be refused, empty where it need not be, and its confidence."""
    confidence, title = place.confidence, definition.title
    inside = place.agreed.inside
    refused = min(confidence, _REFUSED)
    if not inside.all() and (confidence >= CONFIDENCE or place.given):
        return (
            (
                f"Only {int(inside.sum())} of the {len(inside)} patches of the {title} lie in the frame: show the "
                "whole chart, or give the patches that can be seen with --patches."
            ),
            refused,
        )
    if confidence < CONFIDENCE:
        return _not_found(definition, confidence, given=place.given, doubtful=place.doubtful), confidence
    if min(min(one.width, one.height) for one in patches) < SMALLEST:
        return (
            (
                f"The {title} is too small in the frame: its patches have fewer than {SMALLEST} x {SMALLEST} pixels. "
                "Show it larger."
            ),
            refused,
        )
    return "", confidence


def _not_found(definition: ChartDefinition, confidence: float, *, given: bool = False, doubtful: bool = False) -> str:
    """Say that a chart was not found, and what helps."""
    surely = f"(confidence {confidence:.2f}, at least {CONFIDENCE:.2f} is needed)"
    help_ = (
        f"give its corners clockwise from its own top left with --corners ({definition.corners}), or the patches "
        "with --patches."
    )
    if given:
        return (
            f"At these corners the light does not look like the {definition.title} {surely}: check their order and "
            f"place; {help_}"
        )
    if doubtful:
        return (
            f"The {definition.title} fits in more than one place, because its first patches cannot be told from "
            f"others {surely}: {help_}"
        )
    return f"The {definition.title} was not found {surely}: {help_}"


def _nothing(reason: str) -> Located:
    return Located(patches=(), confidence=0.0, corners=(), orientation=0, reason=reason)
