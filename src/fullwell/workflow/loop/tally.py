"""What remains of every turn of the loop: a few numbers a figure, so that many turns take little memory."""

from array import array
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from fullwell.figures.calibration import Calibration, Trials, calibration
from fullwell.workflow.loop.comparison import Comparison, Figure

Numbers: TypeAlias = tuple[float, float, float, float, float, float]
"""What one turn found of a figure: value, standard error, ends of the interval, pull, NaN for none; 1 for a bound."""
Share: TypeAlias = tuple[Figure, float, Numbers]
"""A figure, its truth, and what one turn found."""

_NONE = float("nan")


@dataclass(slots=True)
class _Ledger:
    """All turns of one figure, one column after the other."""

    truth: float
    columns: "tuple[array[float], ...]" = field(default_factory=lambda: tuple(array("d") for _ in range(6)))

    def trials(self) -> Trials:
        values, std_errors, low, high, pulls, bound = (_array(column) for column in self.columns)
        return Trials(
            truth=self.truth,
            values=values,
            std_errors=std_errors,
            low=low,
            high=high,
            pulls=pulls,
            bounds=int(bound.sum()),
        )


@dataclass(slots=True)
class Tally:
    """Every figure of every turn."""

    turns: int = 0
    ledgers: dict[Figure, _Ledger] = field(default_factory=dict[Figure, _Ledger])

    def add(self, shares: Iterable[Share]) -> None:
        """Enter one turn."""
        self.turns += 1
        for figure, truth, numbers in shares:
            ledger = self.ledgers.setdefault(figure, _Ledger(truth=truth))
            for column, number in zip(ledger.columns, numbers, strict=True):
                column.append(number)

    def calibrations(self) -> Mapping[Figure, Calibration]:
        """Return what the turns tell of the errors of each figure."""
        return {figure: calibration(ledger.trials()) for figure, ledger in self.ledgers.items()}

    def pulls(self, figure: Figure) -> NDArray[np.float64]:
        """Return the pulls of a figure, those that there are; none where it is a bound in any turn."""
        return self.ledgers[figure].trials().told_pulls


def shares_of(compared: Iterable[Comparison]) -> list[Share]:
    """Return what remains of one turn."""
    return [(one.figure, one.truth, _numbers(one)) for one in compared]


def _numbers(one: Comparison) -> Numbers:
    measured = one.row.measured
    low, high = (None if one.mixed else measured.ci95) or (_NONE, _NONE)
    error = _NONE if measured.std_error is None else measured.std_error
    return measured.value, error, low, high, _NONE if one.pull is None else one.pull, float(one.bound)


def _array(column: "array[float]") -> NDArray[np.float64]:
    return np.frombuffer(column, np.float64) if column else np.empty(0)
