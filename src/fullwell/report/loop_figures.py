"""The figures of a loop as its curve has them, and those of one quantity put together."""

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Final, cast

from fullwell import glossary
from fullwell.figures.calibration import binomial_interval
from fullwell.raw.cfa import ALL
from fullwell.report.comparison import LEGACY
from fullwell.report.curves import Table
from fullwell.units import DECIBEL, STOP

_ABSOLUTE: Final = frozenset({"black_level", "white_level", "digital_maximum"})
_ORDER: Final = {entry.name: at for at, entry in enumerate(glossary.QUANTITIES)}
_NUMBERS: Final = (
    "original",
    "original_std_error",
    "truth",
    "value",
    "std_error",
    "pull",
    "cameras",
    "bounds",
    "mean",
    "bias",
    "bias_std_error",
    "sd",
    "rms_std_error",
    "intervals",
    "covering",
    "pull_mean",
    "pull_sd",
)


@dataclass(frozen=True, slots=True, kw_only=True)
class LoopFigure:
    """One line of the curve ``loop_figures``, names as its columns; numbers that it lacks are NaN.

    ``bounds`` are the cameras in which the value is only a lower bound: its distance from the truth means nothing then.
    """

    quantity: str
    channel: str
    method: str
    unit: str
    iso: float | None
    snr_threshold: float | None
    exposure_s: float | None
    temperature_c: float | None
    recommended: bool
    original: float
    original_std_error: float
    truth: float
    value: float
    std_error: float
    pull: float
    cameras: float
    bounds: float
    mean: float
    bias: float
    bias_std_error: float
    sd: float
    rms_std_error: float
    intervals: float
    covering: float
    pull_mean: float
    pull_sd: float

    @property
    def bound(self) -> bool:
        """Whether it is a lower bound in any camera."""
        return self.bounds > 0.0

    @property
    def judged(self) -> bool:
        """Whether it is recommended and claims an interval, or is a bound and claims none."""
        return self.recommended and (self.bound or self.intervals > 0.0)

    @property
    def legacy(self) -> bool:
        """Whether its method is kept only because it was published."""
        return self.method.startswith(LEGACY)

    @property
    def relative(self) -> bool:
        """Whether its bias makes sense as a share of the truth."""
        return self.quantity not in _ABSOLUTE and self.unit not in {DECIBEL, STOP} and self.truth != 0.0


@dataclass(frozen=True, slots=True, kw_only=True)
class Together:
    """One quantity over its channels and ISOs.

    Parameters
    ----------
    quantity, method, unit, snr_threshold
        Of all of them.
    figures
        How many.
    bounds, cameras
        Summed over the figures: in how many cameras they are lower bounds, of how many. A figure that is one in any
        camera has no part in the rest.
    relative
        Whether bias and error are shares of the truth.
    bias, bias_std_error
        Mean over the figures, with its Monte Carlo error [1 or unit].
    sd
        Scatter of a figure over cameras, root mean square [1 or unit].
    scatter_ratio
        Scatter over reported error, root mean square; NaN without errors [1].
    covering, intervals
        Summed over the figures.
    pull_mean, pull_sd
        Mean of the means, root mean square of the standard deviations.

    """

    quantity: str
    method: str
    unit: str
    snr_threshold: float | None
    figures: int
    bounds: int
    cameras: int
    relative: bool
    bias: float
    bias_std_error: float
    sd: float
    scatter_ratio: float
    covering: int
    intervals: int
    pull_mean: float
    pull_sd: float

    @property
    def coverage(self) -> tuple[float, float, float] | None:
        """Share of the intervals that hold the truth, and its own 95 % interval; None without intervals."""
        if not self.intervals:
            return None
        return (self.covering / self.intervals, *binomial_interval(self.covering, self.intervals))


def loop_figures(table: Table) -> tuple[LoopFigure, ...]:
    """Return the lines of the curve ``loop_figures``."""
    numbers = {name: table.numbers(name).tolist() for name in _NUMBERS}
    names = ("quantity", "channel", "method", "unit", "recommended")
    words = zip(*(table.values(name) for name in names), strict=True)
    places = zip(*(table.values(name) for name in ("iso", "snr_threshold", "exposure_s", "temperature_c")), strict=True)
    return tuple(
        LoopFigure(
            quantity=str(quantity),
            channel=str(channel),
            method=str(method),
            unit=str(unit),
            recommended=recommended == "yes",
            iso=cast("float | None", iso),
            snr_threshold=cast("float | None", threshold),
            exposure_s=cast("float | None", exposure_s),
            temperature_c=cast("float | None", temperature_c),
            **{name: values[at] for name, values in numbers.items()},
        )
        for at, (
            (quantity, channel, method, unit, recommended),
            (iso, threshold, exposure_s, temperature_c),
        ) in enumerate(zip(words, places, strict=True))
    )


def native(figures: Iterable[LoopFigure]) -> list[LoopFigure]:
    """Return figures of their own unit in the order of the glossary, those of all channels left out where each has one.

    Variances and rows of single exposures are left out too.
    """
    every = list(figures)
    several = any(one.channel not in {ALL, "mono"} for one in every)
    kept = [one for one in every if _is_native(one) and not (several and one.channel == ALL)]
    return sorted(kept, key=lambda one: _ORDER.get(one.quantity, len(_ORDER)))


def put_together(figures: Iterable[LoopFigure]) -> tuple[Together, ...]:
    """Return figures by quantity, method, unit and threshold, in the order they come."""
    groups: dict[tuple[str, str, str, float | None], list[LoopFigure]] = {}
    for one in figures:
        groups.setdefault((one.quantity, one.method, one.unit, one.snr_threshold), []).append(one)
    return tuple(_together(same) for same in groups.values())


def _is_native(one: LoopFigure) -> bool:
    entry = glossary.quantity(one.quantity)
    if one.exposure_s is not None:
        return False
    return entry is not None and not one.quantity.endswith("_variance") and one.unit == entry.units[0]


def _together(same: Sequence[LoopFigure]) -> Together:
    first, told = same[0], [one for one in same if not one.bound]
    relative = all(one.relative for one in told)
    scale = [one.truth if relative else 1.0 for one in told]
    ratios = [one.sd / one.rms_std_error for one in told if one.rms_std_error > 0.0]
    return Together(
        quantity=first.quantity,
        method=first.method,
        unit=first.unit,
        snr_threshold=first.snr_threshold,
        figures=len(same),
        bounds=sum(int(one.bounds) for one in same),
        cameras=sum(int(one.cameras) for one in same),
        relative=relative,
        bias=_mean([one.bias / by for one, by in zip(told, scale, strict=True)]),
        bias_std_error=_rms([one.bias_std_error / by for one, by in zip(told, scale, strict=True)])
        / math.sqrt(max(len(told), 1)),
        sd=_rms([one.sd / by for one, by in zip(told, scale, strict=True)]),
        scatter_ratio=_rms(ratios),
        covering=sum(int(one.covering) for one in told),
        intervals=sum(int(one.intervals) for one in told),
        pull_mean=_mean([one.pull_mean for one in told]),
        pull_sd=_rms([one.pull_sd for one in told]),
    )


def _mean(values: Sequence[float]) -> float:
    known = [value for value in values if math.isfinite(value)]
    return sum(known) / len(known) if known else math.nan


def _rms(values: Sequence[float]) -> float:
    return math.sqrt(_mean([value**2 for value in values]))
