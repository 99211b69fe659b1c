"""Truth beside measurement, row by row."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from itertools import product
from typing import Final, TypeAlias

from fullwell.figures.calibration import pull
from fullwell.figures.results import Row
from fullwell.figures.saturation import GRID_LIMITED, LOWER_BOUND
from fullwell.glossary import RECOMMENDED
from fullwell.simulate.truth import TrueValue
from fullwell.units import DN2, ONE, VOLT

_NO_ESTIMATE: Final = frozenset({LOWER_BOUND, "upper-limit", GRID_LIMITED})
_ONLY_AN_INTERVAL: Final = "quantization-limited"
_MIXED: Final = "mixed"
_TOLD_BY_LIGHT: Final = frozenset({"k_fpn", "k_fpn_variance"})
"""Fixed pattern is told by how it grows with light: of a simulated chart, which is even, nothing else is in it."""
_TWIN: Final = "_variance"
_SQUARED: Final = {ONE: ONE, VOLT: DN2}
"""Units whose square is not written with ``^2``, and one whose rows have their variance in another."""

Figure: TypeAlias = tuple[str, str, str, str, float | None, float | None, float | None, float | None]
"""What the same figure of two runs has in common.

Quantity, channel, method, unit, ISO, SNR threshold, exposure and temperature.
"""

_Name: TypeAlias = tuple[str, str, str, float | None, float | None, float | None, float | None]
_Truths: TypeAlias = Mapping[_Name, float]


@dataclass(frozen=True, slots=True, kw_only=True)
class Comparison:
    """One figure beside its truth.

    Parameters
    ----------
    row
        As it was measured.
    truth
        The true value, in the unit of the row.
    pull
        Error in standard errors, put on the scale of a normal number where the degrees of freedom are few: 95 % of
        them lie within -1.96 and 1.96. That of a square root is its variance's, which alone follows Student's t near
        zero. None where the row claims no standard error, is a bound, holds more than its truth (``mixed``), or only an
        interval is known.

    """

    row: Row
    truth: float
    pull: float | None

    @property
    def recommended(self) -> bool:
        """Whether the row is the one to use; legacy figures never are."""
        return RECOMMENDED in self.row.flags

    @property
    def bound(self) -> bool:
        """Whether the value is only a lower bound."""
        return LOWER_BOUND in self.row.flags

    @property
    def mixed(self) -> bool:
        """Whether the row holds more than its truth, so that neither error nor interval can be judged by that."""
        return _is_mixed(self.row)

    @property
    def figure(self) -> Figure:
        """What the row is, whichever run it comes from."""
        return figure_of(self.row)


def figure_of(row: Row) -> Figure:
    """Return what a row is, whichever run it comes from."""
    return (
        row.quantity,
        row.channel,
        row.method,
        row.measured.unit,
        row.iso,
        row.snr_threshold,
        row.exposure_s,
        row.temperature_c,
    )


def compared(rows: Iterable[Row], truth: Iterable[TrueValue]) -> tuple[Comparison, ...]:
    """Return every row whose truth is known beside that truth.

    Parameters
    ----------
    rows
        Measured figures; those of a region are left out.
    truth
        True values.

    """
    known = {
        (
            *(one.quantity, one.channel, one.unit, one.iso, one.snr_threshold, one.exposure_s),
            None if one.temperature_c is None else round(one.temperature_c, 1),
        ): one.value
        for one in truth
    }
    whole = [row for row in rows if row.region is None]
    twins = {_place(row): row for row in whole if row.quantity.endswith(_TWIN)}
    found: list[Comparison] = []
    for row in whole:
        value = _true(row, known)
        if value is not None:
            found.append(Comparison(row=row, truth=value, pull=_pull(row, value, twins, known)))
    return tuple(found)


def pulls_of(compared_rows: Sequence[Comparison]) -> tuple[float, ...]:
    """Return the pulls of the recommended rows."""
    return tuple(one.pull for one in compared_rows if one.recommended and one.pull is not None)


def _pull(row: Row, truth: float, twins: Mapping[tuple[object, ...], Row], known: _Truths) -> float | None:
    if _ONLY_AN_INTERVAL in row.flags or _is_mixed(row):
        return None
    twin = _twin(row, twins)
    if twin is not None and (its_truth := _true(twin, known)) is not None:
        return pull(twin.measured, its_truth)
    return None if _NO_ESTIMATE.intersection(row.flags) else pull(row.measured, truth)


def _is_mixed(row: Row) -> bool:
    return _MIXED in row.flags and row.quantity not in _TOLD_BY_LIGHT


def _twin(row: Row, twins: Mapping[tuple[object, ...], Row]) -> Row | None:
    """Return the signed variance in the squared unit behind a square root; None where there is none."""
    quantity, *rest, unit = _place(row)
    return twins.get((f"{quantity}{_TWIN}", *rest, _SQUARED.get(str(unit), f"{unit}^2")))


def _place(row: Row) -> tuple[object, ...]:
    return (row.quantity, row.channel, row.method, row.iso, row.exposure_s, row.temperature_c, row.measured.unit)


def _true(row: Row, known: _Truths) -> float | None:
    """Return the truth at the exposure and temperature of a row, else what is true at all of them."""
    name = (row.quantity, row.channel, row.measured.unit, row.iso, row.snr_threshold)
    places = product((row.exposure_s, None), (row.temperature_c, None))
    return next((known[(*name, *place)] for place in places if (*name, *place) in known), None)
