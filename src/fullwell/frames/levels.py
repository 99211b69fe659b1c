"""Which black and white level a study goes by: the user's, the manifest's, or what most files declare."""

from collections import Counter
from collections.abc import Iterable, Sequence

from fullwell.errors import UsageError
from fullwell.frames.reading import Reading
from fullwell.frames.selection import Selection
from fullwell.frames.series import Camera
from fullwell.raw.cfa import channels
from fullwell.raw.image import Levels


def black_level(readings: Sequence[Reading], *, selection: Selection, camera: Camera, cfa: str) -> Levels | None:
    """Return the declared black level per CFA site [DN], None where nobody declares one.

    Raises
    ------
    UsageError
        Where the user or the manifest gives neither one level nor one per CFA site.

    """
    if selection.black_level is not None:
        return Levels(values=_per_site(selection.black_level, cfa=cfa, where="--black"), source="user")
    if camera.black_level is not None:
        values = _per_site(camera.black_level, cfa=cfa, where="camera.black_level")
        return Levels(values=values, source="manifest")
    return _most_common((reading.frame.header.black_level for reading in readings), cfa=cfa)


def white_level(
    readings: Sequence[Reading], *, selection: Selection, camera: Camera, cfa: str, bit_depth: int
) -> Levels | None:
    """Return the declared white level per CFA site [DN].

    Where nobody declares one, the highest code of the bit depth, if that is truly known and not only the container's.
    """
    if selection.white_level is not None:
        return Levels(values=_per_site((selection.white_level,), cfa=cfa, where="--white"), source="user")
    if camera.white_level is not None:
        values = _per_site((camera.white_level,), cfa=cfa, where="camera.white_level")
        return Levels(values=values, source="manifest")
    declared = _most_common((reading.frame.header.white_level for reading in readings), cfa=cfa)
    if declared is None and any(one.bit_depth_known and one.bit_depth == bit_depth for one in readings):
        return Levels(values=_per_site((2.0**bit_depth - 1.0,), cfa=cfa, where="bit depth"), source="default")
    return declared


def _per_site(values: tuple[float, ...], *, cfa: str, where: str) -> tuple[float, ...]:
    sites = len(channels(cfa))
    if len(values) not in {1, sites}:
        wish = "one level" if sites == 1 else f"one level, or {sites} (one per CFA site of {cfa}, row by row)"
        raise UsageError(f"{where} has {len(values)} values; give {wish}.")
    return values if len(values) == sites else values * sites


def _most_common(declared: Iterable[Levels | None], *, cfa: str) -> Levels | None:
    counts = Counter(fitted for levels in declared if (fitted := _fitted(levels, cfa=cfa)) is not None)
    if not counts:
        return None
    return min(counts, key=lambda levels: (-counts[levels], levels.values, levels.source, levels.tag))


def _fitted(levels: Levels | None, *, cfa: str) -> Levels | None:
    """Return a file's levels per site of the study's CFA; None where they are of another pattern and not all alike."""
    if levels is None:
        return None
    sites = len(channels(cfa))
    if len(levels.values) == sites:
        return levels
    if len(set(levels.values)) > 1:
        return None
    return Levels(values=levels.values[:1] * sites, source=levels.source, tag=levels.tag)
