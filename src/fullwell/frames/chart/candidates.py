"""Places where a chart may lie: two neighbouring patches laid upon two neighbouring areas, and what else then fits.

Every pair of neighbours on the chart is laid upon every pair of neighbouring areas of like size; such a similarity
says where the other patches must be. The best of them grow: patches that meet an area make the map affine, then
projective, and more patches meet theirs.
"""

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage
from scipy.spatial import KDTree

from fullwell.frames.chart.areas import Areas
from fullwell.frames.chart.definition import ChartDefinition
from fullwell.frames.chart.homography import UNIT_SQUARE, affine, convex, homography, mapped

_LIKE: Final = 2.6
"""Ratio of sizes, above which two areas do not belong to patches of one size: perspective, eaten edges."""
_NEIGHBOURS: Final = 10
"""Nearest areas of like size that may be the neighbour."""
_MISS: Final = 0.38
"""Distance between a predicted patch and an area that still meet, as a share of the spacing."""
_CONTRAST: Final = 0.8
"""Error of the logarithm of two patches' ratio of light that colour and illumination may make."""
_PERSPECTIVE: Final = 2.5
"""Ratio of opposite edges of a chart at most."""
_REACHES: Final = (2.6, 4.2, 7.0, 11.0, 18.0, np.inf, np.inf, np.inf)
"""Spacings from the first two patches, within which patches meet areas, one time after the other."""
_PROJECTIVE: Final = 9
"""Points from which on a map is projective."""
_KEPT: Final = 80
"""Similarities that grow."""
_LEAST: Final = 3.0
_HOPELESS: Final = 0.4
"""Score below which a similarity does not grow: in patches, and as a share of the best one's."""
_FEWEST: Final = 0.2
"""Share of the patches that meet an area at least, for a place to be one."""
_BATCH: Final = 20_000


@dataclass(frozen=True, slots=True, kw_only=True)
class Candidate:
    """One place of a chart.

    Parameters
    ----------
    matrix
        From fractions between the chart's corners to pixels of the preview, shape (3, 3).
    met
        Patches that lie on an area of their own, shape (patches,).
    middles
        Where the areas of those patches have their middles, shape (met patches, 2) [preview pixel].

    """

    matrix: NDArray[np.float64]
    met: NDArray[np.bool_]
    middles: NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True)
class _Plan:
    """A chart in coordinates whose unit is its height, as complex numbers, and its pairs of neighbours."""

    points: NDArray[np.complex128]
    pairs: NDArray[np.intp]
    spacing: NDArray[np.float64]
    light: NDArray[np.float64]
    edge: float


@dataclass(frozen=True, slots=True, kw_only=True)
class _Similarities:
    """Maps z -> slope z + offset from the plan to the preview, each array of shape (n,).

    ``score`` counts the areas that are explained in the right order of light, ``size`` is that of the two areas and
    ``seed`` one of the two patches that were laid on each other.
    """

    slope: NDArray[np.complex128]
    offset: NDArray[np.complex128]
    score: NDArray[np.float64]
    size: NDArray[np.float64]
    seed: NDArray[np.intp]


def candidates(areas: Areas, definition: ChartDefinition, *, shape: tuple[int, ...], mirrored: bool) -> list[Candidate]:
    """Return places where a chart may lie, those that explain most areas first.

    Parameters
    ----------
    areas
        Of the picture.
    definition
        The chart.
    shape
        Rows and columns of the picture.
    mirrored
        Seen from its back.

    """
    plan = _plan(definition, mirrored=mirrored)
    if len(areas) < 4:
        return []
    found = _similarities(areas, plan, shape=shape, grey=not definition.coloured)
    least = max(_LEAST, _HOPELESS * float(found.score.max(initial=0.0)))
    grown: dict[bytes, tuple[float, Candidate]] = {}
    taken: set[tuple[int, ...]] = set()
    for one in np.argsort(-found.score, kind="stable"):
        slope, offset = complex(found.slope[one]), complex(found.offset[one])
        key = _rounded(slope, offset, plan)
        if found.score[one] < least or len(taken) >= _KEPT:
            break
        if key in taken:
            continue
        taken.add(key)
        start = slope * plan.points + offset
        seed = int(found.seed[one])
        candidate, assigned = _grown(areas, definition, plan=plan, start=start, seed=seed, size=float(found.size[one]))
        if candidate is not None:
            grown.setdefault(assigned.tobytes(), (float(candidate.met.sum()), candidate))
    return [candidate for _, candidate in sorted(grown.values(), key=lambda pair: -pair[0])]


def _plan(definition: ChartDefinition, *, mirrored: bool) -> _Plan:
    centres = definition.centres * (definition.aspect, 1.0)
    points = centres[:, 0] * (-1.0 if mirrored else 1.0) + 1j * centres[:, 1]
    apart = np.abs(points[:, None] - points[None, :])
    np.fill_diagonal(apart, np.inf)
    spacing = apart.min(axis=1)
    pairs = np.argwhere(apart <= 1.3 * spacing[:, None])
    sizes = definition.sizes * (definition.aspect, 1.0)
    return _Plan(
        points=points,
        pairs=pairs,
        spacing=spacing,
        light=np.log(definition.colours.mean(axis=1)),
        edge=float(np.median(np.sqrt(sizes.prod(axis=1)))),
    )


def _rounded(slope: complex, offset: complex, plan: _Plan) -> tuple[int, ...]:
    """Return a key that similarities share where they lay the chart's ends on nearly the same places."""
    ends = np.array([plan.points[0], plan.points[-1]]) * slope + offset
    unit = 0.5 * abs(slope) * float(plan.spacing.min())
    parts = np.concatenate((ends.real, ends.imag)) / unit
    return tuple(int(part) for part in np.round(parts))


def _pairs_of_areas(areas: Areas, plan: _Plan) -> NDArray[np.intp]:
    """Return ordered pairs of areas that may be neighbouring patches, shape (n, 2)."""
    tree = KDTree(areas.centre)
    count = min(len(areas), 3 * _NEIGHBOURS)
    second = np.ravel(tree.query(areas.centre, k=count)[1]).astype(np.intp)
    first = np.repeat(np.arange(len(areas)), count)
    ratio = areas.size[second] / areas.size[first]
    edge = np.sqrt(np.minimum(areas.size[first], areas.size[second]))
    apart = np.linalg.norm(areas.centre[second] - areas.centre[first], axis=1) / edge
    spacing = plan.spacing / plan.edge
    good = (first != second) & (ratio < _LIKE) & (ratio > 1 / _LIKE)
    good &= (apart > 0.6 * spacing.min()) & (apart < 2.2 * spacing.max())
    first, second, apart = first[good], second[good], apart[good]
    order = np.lexsort((apart, first))
    first, second = first[order], second[order]
    start = np.searchsorted(first, first)
    nearest = np.arange(len(first)) - start < _NEIGHBOURS
    return np.column_stack((first, second))[nearest]


def _similarities(areas: Areas, plan: _Plan, *, shape: tuple[int, ...], grey: bool) -> _Similarities:
    """Return every similarity that lays neighbouring patches on neighbouring areas.

    The light of a grey chart rises along its densities, in steps that are known but for a common factor; that of a
    coloured one depends on the camera.
    """
    laid = _pairs_of_areas(areas, plan)
    place = areas.centre[:, 0] + 1j * areas.centre[:, 1]
    expected = plan.light[plan.pairs[:, 1]] - plan.light[plan.pairs[:, 0]]
    seen = areas.light[laid[:, 1]] - areas.light[laid[:, 0]]
    if grey:
        likely = (seen[:, None] * expected > 0) & (np.abs(seen[:, None]) < 4.0 * np.abs(expected) + 0.1)
    else:
        likely = np.abs(seen[:, None] - expected) < _CONTRAST
    which, pair = np.nonzero(likely)
    start, end = plan.points[plan.pairs[pair]].T
    u, v = place[laid[which]].T
    slopes = (v - u) / (end - start)
    offsets = u - slopes * start
    size = np.sqrt(areas.size[laid[which]].prod(axis=1))
    scores = np.zeros(len(slopes))
    octave = np.round(np.log2(size)).astype(np.int64)
    for one in np.unique(octave):
        nearest = _nearest_map(areas, shape=shape, size=float(2.0**one))
        mine = np.flatnonzero(octave == one)
        for begin in range(0, len(mine), _BATCH):
            part = mine[begin : begin + _BATCH]
            predicted = slopes[part, None] * plan.points + offsets[part, None]
            scores[part] = _explained(predicted, np.abs(slopes[part]), nearest=nearest, areas=areas, plan=plan)
    return _Similarities(slope=slopes, offset=offsets, score=scores, size=size, seed=plan.pairs[pair, 0])


def _nearest_map(areas: Areas, *, shape: tuple[int, ...], size: float) -> NDArray[np.intp]:
    """Return the nearest area of a size for every pixel, shape (rows, columns)."""
    like = np.flatnonzero((areas.size < _LIKE * size) & (areas.size > size / _LIKE))
    empty = np.ones(shape, dtype=np.bool_)
    owner = np.zeros(shape, dtype=np.intp)
    columns, rows = np.round(areas.centre[like]).astype(np.intp).T
    empty[rows, columns] = False
    owner[rows, columns] = like
    place = np.zeros((2, *shape), dtype=np.int32)
    ndimage.distance_transform_edt(empty, return_distances=False, return_indices=True, indices=place)
    return owner[place[0], place[1]]


def _explained(
    predicted: NDArray[np.complex128],
    scale: NDArray[np.float64],
    *,
    nearest: NDArray[np.intp],
    areas: Areas,
    plan: _Plan,
) -> NDArray[np.float64]:
    """Return how many patches meet an area, times the correlation of their light with the chart's."""
    rows, columns = nearest.shape
    x, y = predicted.real, predicted.imag
    inside = (x >= 0) & (y >= 0) & (x <= columns - 1) & (y <= rows - 1)
    owner = nearest[
        np.clip(np.round(y), 0, rows - 1).astype(np.intp), np.clip(np.round(x), 0, columns - 1).astype(np.intp)
    ]
    miss = np.hypot(x - areas.centre[owner, 0], y - areas.centre[owner, 1])
    met = inside & (miss < _MISS * plan.spacing * scale[:, None])
    count = met.sum(axis=1)
    share = met / np.maximum(count, 1)[:, None]
    seen, known = areas.light[owner], np.broadcast_to(plan.light, met.shape)
    seen = seen - (share * seen).sum(axis=1, keepdims=True)
    known = known - (share * known).sum(axis=1, keepdims=True)
    both = (share * seen * known).sum(axis=1)
    norm = np.sqrt((share * seen**2).sum(axis=1) * (share * known**2).sum(axis=1))
    return count * np.clip(both / np.maximum(norm, 1e-9), 0.0, 1.0)


def _grown(
    areas: Areas,
    definition: ChartDefinition,
    *,
    plan: _Plan,
    start: NDArray[np.complex128],
    seed: int,
    size: float,
) -> tuple[Candidate | None, NDArray[np.intp]]:
    """Let a similarity become a projective map by the areas that patches meet, farther from its seed each time.

    Far from the seed a similarity may be a whole spacing out of place, and meet the areas of other patches.
    """
    like = np.flatnonzero((areas.size < _LIKE * size) & (areas.size > size / _LIKE))
    tree = KDTree(areas.centre[like])
    predicted = np.column_stack((start.real, start.imag))
    away = np.abs(plan.points - plan.points[seed]) / plan.spacing
    matrix = None
    owner = np.full(len(start), -1, dtype=np.intp)
    for step, reach in enumerate(_REACHES):
        owner = _met(tree, predicted, plan=plan, miss=_MISS if step < len(_REACHES) - 2 else 0.8 * _MISS)
        owner = np.where(away <= reach, owner, -1)
        own = owner >= 0
        if own.sum() < (3 if np.isfinite(reach) else max(4.0, _FEWEST * len(own))):
            return None, owner
        matrix = _fitted(areas, definition, owner=np.where(own, like[owner], -1))
        if matrix is None:
            return None, owner
        predicted = mapped(matrix, definition.centres)
    assert matrix is not None  # noqa: S101 -- the loop ran
    met = owner >= 0
    return Candidate(matrix=matrix, met=met, middles=areas.centre[like[owner[met]]]), np.where(met, like[owner], -1)


def _met(tree: KDTree, predicted: NDArray[np.float64], *, plan: _Plan, miss: float) -> NDArray[np.intp]:
    """Return the area that each patch meets, -1 for none; an area is met once, by the nearest."""
    local = _local_spacing(predicted, plan)
    distance, owner = tree.query(predicted)
    owner = np.where(distance < miss * local, owner, -1)
    order = np.argsort(distance, kind="stable")
    _, first = np.unique(owner[order], return_index=True)
    kept = np.zeros(len(owner), dtype=np.bool_)
    kept[order[first]] = True
    return np.where(kept, owner, -1)


def _local_spacing(predicted: NDArray[np.float64], plan: _Plan) -> NDArray[np.float64]:
    """Return the distance of each predicted patch from its nearest neighbour on the chart."""
    apart = np.linalg.norm(predicted[plan.pairs[:, 0]] - predicted[plan.pairs[:, 1]], axis=1)
    nearest = np.full(len(predicted), np.inf)
    np.minimum.at(nearest, plan.pairs[:, 0], apart)
    return nearest


def _fitted(areas: Areas, definition: ChartDefinition, *, owner: NDArray[np.intp]) -> NDArray[np.float64] | None:
    """Return the map through the areas that patches meet; None where they do not determine one."""
    own = owner >= 0
    source, target = definition.centres[own], areas.centre[owner[own]]
    if _in_line(source * (definition.aspect, 1.0)):
        source, target = _with_edges(areas, definition, owner=owner)
        if _in_line(source):
            return None
    if len(source) >= _PROJECTIVE:
        matrix = homography(source, target)
        if convex(mapped(matrix, UNIT_SQUARE), perspective=_PERSPECTIVE):
            return matrix
    matrix = affine(source, target)
    return matrix if convex(mapped(matrix, UNIT_SQUARE)) else None


def _in_line(points: NDArray[np.float64]) -> bool:
    spread = np.linalg.svd(points - points.mean(axis=0), compute_uv=False)
    return bool(spread[-1] < 1e-3 * spread[0])


def _with_edges(
    areas: Areas, definition: ChartDefinition, *, owner: NDArray[np.intp]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return centres of patches in a line together with the middles of their long edges.

    The edge vector b of an area with the edges a and b has b b' = 12 M - a a', M its moments; a is known but for what
    the search for even areas ate at the edges, which is as much on all sides.
    """
    own = np.flatnonzero(owner >= 0)
    centres, sizes = definition.centres[own], definition.sizes[own]
    target, moments = areas.centre[owner[own]], areas.moments[owner[own]]
    upright = bool(np.ptp(centres[:, 0]) < np.ptp(centres[:, 1]))
    along = centres[:, 1] if upright else centres[:, 0]
    step = np.polynomial.polynomial.polyfit(along, target, 1)[1]
    length = float(np.linalg.norm(step))
    unit = step / max(length, 1e-9)
    whole = length * (sizes[:, 1] if upright else sizes[:, 0])
    normal = np.array((-unit[1], unit[0]))
    seen = np.sqrt(12.0 * np.linalg.det(moments) / np.einsum("i,nij,j->n", normal, moments, normal))
    rest = 12.0 * moments - seen[:, None, None] ** 2 * np.outer(unit, unit)
    _, vectors = np.linalg.eigh(rest.mean(axis=0))
    across = vectors[:, -1] * (1.0 if vectors[:, -1] @ normal > 0 else -1.0)
    if upright:
        across = -across
    eaten = np.median(np.clip(whole - seen, 0.0, None))
    wide = np.sqrt(np.maximum(np.einsum("i,nij,j->n", across, rest, across), 0.0)) + eaten
    offset = np.array((0.5, 0.0) if upright else (0.0, 0.5)) * sizes
    edge = 0.5 * wide[:, None] * across
    return np.vstack((centres, centres - offset, centres + offset)), np.vstack((target, target - edge, target + edge))
