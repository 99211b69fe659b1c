"""What the user asked for: which part of a study to measure, and facts that outrank the files' own."""

import math
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Final

from fullwell.frames.series import Camera, Kind
from fullwell.raw.headerless_format import HeaderlessFormat

EXPOSURE_TOLERANCE: Final = 0.005
"""Exposures within this fraction belong to one series (RESULTS 1)."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Selection:
    """Which frames to use; an empty tuple selects all.

    Parameters
    ----------
    isos, exposures_s, kinds
        Frames to keep, exposures within 0.5 % [-, s, -].
    cfa
        Order given by the user, above what files say.
    black_level, white_level
        Levels given by the user [DN], one or one per CFA site.
    camera
        Facts given by ``--camera``, above the manifest's.
    crop
        x, y, width and height of the region to use, in pixels of the visible mosaic; None is all of it.
    headerless
        How files without a header are stored, above the manifest, sidecars and presets.

    """

    isos: tuple[float, ...] = ()
    exposures_s: tuple[float, ...] = ()
    kinds: tuple[Kind, ...] = ()
    cfa: str | None = None
    black_level: tuple[float, ...] | None = None
    white_level: float | None = None
    camera: Camera | None = None
    crop: tuple[int, int, int, int] | None = None
    headerless: HeaderlessFormat | None = None

    def wants(self, *, iso: float | None, exposure_s: float | None) -> bool:
        """Return whether a frame's ISO and exposure were asked for."""
        return _among(iso, self.isos) and _among(exposure_s, self.exposures_s)


def _among(value: float | None, wanted: Iterable[float]) -> bool:
    chosen = tuple(wanted)
    if not chosen:
        return True
    return value is not None and any(math.isclose(value, one, rel_tol=EXPOSURE_TOLERANCE) for one in chosen)
