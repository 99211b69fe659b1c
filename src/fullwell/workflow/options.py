"""What a measurement is asked to do."""

import os
from dataclasses import dataclass, field
from pathlib import Path

from fullwell.frames.selection import Selection


@dataclass(frozen=True, slots=True, kw_only=True)
class CacheChoice:
    """Where and how finished series are kept.

    Parameters
    ----------
    folder
        Made if need be.
    shared
        Whether other studies use the folder too: what this one does not use stays there, up to 32 GB.
    recheck
        Whether every file is read and hashed before what is kept of it is used, whatever the file system says.

    """

    folder: Path
    shared: bool = False
    recheck: bool = False


@dataclass(frozen=True, slots=True, kw_only=True)
class Options:
    """Settings of a measuring command.

    Parameters
    ----------
    selection
        Which frames to use, and facts that outrank the files' own.
    tile
        Edge of a tile in pixels of a CFA plane; None is 64, or an eighth of the plane's shorter side where that is
        less, so that a smooth surface over a tile can follow the shading.
    workers
        Threads; results never depend on their number.
    profiles
        Profiles of EMVA 1288 to evaluate by, beside all else.
    dask
        Address of a Dask scheduler whose processes read the frames, ``local`` for as many processes of this machine as
        there are workers; None reads them in threads. Results never depend on it.
    cache
        Where finished series are kept, and looked for by the next run; None keeps none.
    legacy_black_subtracted
        Whether the published study's tables have the black level subtracted first; as published it is left in.

    """

    selection: Selection = field(default_factory=Selection)
    tile: int | None = None
    workers: int = field(default_factory=lambda: os.cpu_count() or 1)
    profiles: tuple[str, ...] = ()
    dask: str | None = None
    cache: CacheChoice | None = None
    legacy_black_subtracted: bool = False
