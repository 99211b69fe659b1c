"""Figures of the standard that dark frames cannot tell: they keep their value, and lose error and interval."""

from collections.abc import Iterable
from dataclasses import replace
from typing import Final

from fullwell.figures.results import Row
from fullwell.units import Measured
from fullwell.workflow.measure.bursts import IsoBursts
from fullwell.workflow.measure.emva.linear import LinearFits

_CLIPPED: Final = "black-clipped"
_LIMITED: Final = "quantization-limited"
_BOUNDS: Final = {"lower-bound", "upper-limit"}
_PATTERN: Final = ("dsnu", "dark_current", "stack_")
_CUT: Final = (
    *_PATTERN,
    "dark_noise",
    "dark_signal",
    "dynamic_range",
    "linearity_offset",
    "photon_transfer_offset",
    "responsivity",
    "sensitivity_threshold",
)
"""Beginnings of the quantities that rest on dark frames, but for those of bright stacks."""
_BRIGHT: Final = "_bright"


def with_untold(rows: Iterable[Row], bursts: IsoBursts, channel: str, fits: LinearFits) -> tuple[Row, ...]:
    """Return the rows of a channel, errors left off where black cuts the dark frames, or their noise hides in a code.

    Black cuts off up to half of the noise and lifts the level, by how much is not seen. Below the noise that the
    standard takes for measurable the means of pixels, and how they grow with time, stick to one code or jump to the
    next.
    """
    clipped = channel in bursts.black_clipped
    return tuple(_untold(row, clipped=clipped) if _rests(row, fits, clipped=clipped) else row for row in rows)


def _rests(row: Row, fits: LinearFits, *, clipped: bool) -> bool:
    if row.quantity.endswith(_BRIGHT):
        return False
    sticks = fits.floored or _LIMITED in row.flags
    return row.quantity.startswith(_CUT) if clipped else sticks and row.quantity.startswith(_PATTERN)


def _untold(row: Row, *, clipped: bool) -> Row:
    flag = _CLIPPED if clipped else _LIMITED
    value = Measured.exact(row.measured.value, row.measured.unit)
    return replace(row, measured=value, flags=tuple(sorted({*row.flags, flag} - _BOUNDS)))
