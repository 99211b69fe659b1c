"""What a measurement is asked to do."""

import os
from dataclasses import dataclass, field

from fullwell.frames.selection import Selection


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
    legacy_black_subtracted
        Whether the published study's tables have the black level subtracted first; as published it is left in.

    """

    selection: Selection = field(default_factory=Selection)
    tile: int | None = None
    workers: int = field(default_factory=lambda: os.cpu_count() or 1)
    profiles: tuple[str, ...] = ()
    legacy_black_subtracted: bool = False
