"""Where a run keeps its finished series."""

from pathlib import Path
from typing import Final

from fullwell.errors import UsageError
from fullwell.workflow.cache.series_cache import SeriesCache
from fullwell.workflow.options import Options

MOST_SHARED_BYTES: Final = 32_000_000_000


def cache_beside(out: Path) -> Path:
    """Return where the finished series of a run are kept unless it is told otherwise: ``OUT.cache``."""
    whole = out.resolve()
    return whole.parent / f"{whole.name}.cache"


def opened_cache(options: Options, *, out: Path) -> SeriesCache | None:
    """Return the cache that a run was told to use, if any.

    Raises
    ------
    UsageError
        Its folder holds something else, cannot be written to, or lies in ``out``, which the run replaces.

    """
    if options.cache is None:
        return None
    folder = options.cache.folder
    if out.resolve() in (whole := folder.resolve(), *whole.parents):
        raise UsageError(f"{folder} lies in {out}, which is replaced; name another folder with --cache")
    return SeriesCache(
        folder, recheck=options.cache.recheck, most_bytes=MOST_SHARED_BYTES if options.cache.shared else 0
    )
