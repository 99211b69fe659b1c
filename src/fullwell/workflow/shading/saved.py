"""Shading maps that were saved: found by a file or a folder, and the one that suits a scene."""

import math
from collections.abc import Sequence
from pathlib import Path
from typing import Final

from fullwell.errors import UsageError
from fullwell.workflow.maps import ShadingMapFile, load_shading_map

_PATTERN: Final = "shading_*.npz"


def map_files(path: Path) -> tuple[Path, ...]:
    """Return the maps that a path names: the file itself, or those in a folder or in its ``maps``; may be none."""
    if path.is_file():
        return (path,) if path.suffix.lower() == ".npz" else ()
    return tuple(sorted(path.glob(_PATTERN))) or tuple(sorted(path.glob(f"maps/{_PATTERN}")))


def saved_maps(path: Path) -> tuple[ShadingMapFile, ...]:
    """Read every map that a path names, by ISO and exposure.

    Raises
    ------
    UsageError
        Where there is none.

    """
    files = map_files(path)
    if not files:
        said = "holds no shading maps" if path.is_dir() else "is no shading map" if path.exists() else "does not exist"
        raise UsageError(
            f"{path} {said}. Give a map that `fullwell shading fit` wrote (maps/shading_*.npz), or its folder."
        )
    return tuple(sorted((load_shading_map(file) for file in files), key=by_iso_and_exposure))


def by_iso_and_exposure(shading: ShadingMapFile) -> tuple[float, float]:
    """Return what orders maps: ISO, unknown first, then exposure."""
    return (shading.iso or 0.0, shading.exposure_s)


def suitable_map(maps: Sequence[ShadingMapFile], *, iso: float | None) -> ShadingMapFile:
    """Return the map to correct a scene by: nearest in ISO, and of those the brightest, whose errors are least."""

    def distance(shading: ShadingMapFile) -> tuple[float, float]:
        own = shading.iso or 0.0
        apart = abs(math.log(own / iso)) if iso and own else own
        return (apart, -min(one.maximum_dn for one in shading.channels))

    return min(maps, key=distance)
