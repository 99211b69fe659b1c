"""What the published method would have said: its figures beside the corrected ones, and why they differ."""

import math
import statistics
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Final

from fullwell import glossary
from fullwell.figures.results import Row
from fullwell.raw.cfa import channel_rank
from fullwell.report.chosen_models import Chosen
from fullwell.report.numbers import (
    MISSING,
    show,
    show_interval,
    show_iso,
    show_plain,
    show_signed,
    show_unit,
    show_value,
)
from fullwell.report.pivots import recommended, title_of, tooltip
from fullwell.report.reasons import reason

LEGACY: Final = "legacy-"

_MINUS: Final = "\N{MINUS SIGN}"
_CERTAIN: Final = 4.0
"""Standard errors from zero up to which a ratio means nothing."""

_PUBLISHED_DIGITS: Final = 4
_MOST_PLACES: Final = 7
_GREENS: Final = ("G1", "G2")
_LEFT_OUT: Final = frozenset({"shading_edge_x", "shading_edge_y"})
"""Told by the corner already."""

_BOTH_UNITS: Final = "legacy-std-intercept"
"""Published in a unit that was wrong: compared in every unit."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Line:
    """One published figure beside the corrected one."""

    channel: str
    published: str
    corrected: tuple[str, ...]
    tooltip: str
    difference: str


@dataclass(frozen=True, slots=True, kw_only=True)
class Block:
    """The figures of one published method at one ISO."""

    quantity: str
    title: str
    unit: str
    method: str
    reason: str
    lines: tuple[Line, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class IsoBlocks:
    """All published figures of one ISO."""

    label: str
    blocks: tuple[Block, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class Verdict:
    """One published method over all ISOs and channels."""

    quantity: str
    title: str
    method: str
    summary: str
    reason: str


@dataclass(frozen=True, slots=True, kw_only=True)
class Published:
    """The chapter: a line on top, a line per method, a table per ISO."""

    summary: str
    verdicts: tuple[Verdict, ...]
    isos: tuple[IsoBlocks, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class _Pair:
    legacy: Row
    partners: tuple[Row, ...]

    @property
    def method(self) -> tuple[str, str, str, bool]:
        """Return what stands together: quantity, method, unit, whether of the whole crop."""
        return (self.legacy.quantity, self.legacy.method, self.legacy.measured.unit, self.legacy.region is not None)


def published_beside(rows: Sequence[Row], models: Chosen) -> Published | None:
    """Return the chapter; None where no published figure has a corrected one beside it.

    Parameters
    ----------
    rows
        Every row.
    models
        The chosen shading models.

    """
    groups = _native(_pairs(rows, models))
    if not groups:
        return None
    isos = sorted({pair.legacy.iso for pairs in groups.values() for pair in pairs}, key=lambda iso: iso or -1.0)
    verdicts = tuple(_verdict(key, pairs) for key, pairs in groups.items())
    return Published(
        summary=_summary(groups),
        verdicts=verdicts,
        isos=tuple(
            IsoBlocks(
                label=show_iso(iso),
                blocks=tuple(
                    _block(key, mine)
                    for key, pairs in groups.items()
                    if (mine := [pair for pair in pairs if pair.legacy.iso == iso])
                ),
            )
            for iso in isos
        ),
    )


def _pairs(rows: Sequence[Row], models: Chosen) -> Iterable[_Pair]:
    """Yield every published figure that has corrected ones beside it; of exposures the longest of each ISO."""
    best = _corrected(rows, models)
    longest: dict[tuple[str, float | None], float] = {}
    found: list[_Pair] = []
    for row in rows:
        if not row.method.startswith(LEGACY) or row.quantity in _LEFT_OUT or _is_piece(row.region):
            continue
        if partners := _partners(row, best):
            key = (row.quantity, row.iso)
            longest[key] = max(longest.get(key, 0.0), row.exposure_s or 0.0)
            found.append(_Pair(legacy=row, partners=partners))
    return (
        pair for pair in found if (pair.legacy.exposure_s or 0.0) == longest[(pair.legacy.quantity, pair.legacy.iso)]
    )


def _is_piece(region: str | None) -> bool:
    """Tell whether a region is one tile or patch of many rather than the study's crop."""
    return region is not None and region.startswith(("tile:", "patch:"))


def _corrected(rows: Sequence[Row], models: Chosen) -> dict[tuple[object, ...], dict[str, Row]]:
    """Return the corrected rows by what they measure, and within that by channel."""
    best: dict[tuple[object, ...], dict[str, Row]] = {}
    for row in recommended(rows):
        best.setdefault(_key(row), {})[row.channel] = row
    for row in rows:
        if row.exposure_s is None or row.region is not None or row.method.startswith(LEGACY):
            continue
        if models.get((row.iso, row.exposure_s, row.channel)) == row.method:
            best.setdefault(_key(row), {})[row.channel] = row
    return best


def _key(row: Row) -> tuple[object, ...]:
    return (row.quantity, row.measured.unit, row.iso, row.exposure_s, row.temperature_c, row.snr_threshold)


def _partners(row: Row, best: Mapping[tuple[object, ...], Mapping[str, Row]]) -> tuple[Row, ...]:
    """Return the corrected rows of a published one: of its channel, of both greens for G, of all channels for all."""
    there = best.get(_key(row), {})
    if row.channel in there:
        return (there[row.channel],)
    if row.channel == "G":
        return tuple(there[name] for name in _GREENS if name in there)
    if row.channel == "all":
        return tuple(there[name] for name in sorted(there, key=channel_rank))
    return ()


def _native(pairs: Iterable[_Pair]) -> dict[tuple[str, str, str, bool], list[_Pair]]:
    """Return the pairs by method, in the first unit of each quantity alone."""
    native: dict[tuple[str, str], str] = {}
    groups: dict[tuple[str, str, str, bool], list[_Pair]] = {}
    for pair in pairs:
        row = pair.legacy
        unit = native.setdefault((row.quantity, row.method), row.measured.unit)
        if unit == row.measured.unit or row.method == _BOTH_UNITS:
            groups.setdefault(pair.method, []).append(pair)
    order = {entry.name: index for index, entry in enumerate(glossary.QUANTITIES)}
    return dict(sorted(groups.items(), key=lambda item: (order.get(item[0][0], len(order)), item[0])))


def _block(key: tuple[str, str, str, bool], pairs: Sequence[_Pair]) -> Block:
    quantity, method, unit, whole_crop = key
    ordered = sorted(pairs, key=lambda pair: channel_rank(pair.legacy.channel))
    return Block(
        quantity=quantity,
        title=_title(quantity, method, whole_crop=whole_crop),
        unit=show_unit(unit) or "1",
        method=method,
        reason=_reason(key, pairs),
        lines=tuple(
            Line(
                channel=pair.legacy.channel,
                published=_published(pair),
                corrected=_text(pair),
                tooltip="; ".join(tooltip(row) for row in pair.partners[:1]),
                difference=_difference(pair),
            )
            for pair in ordered
        ),
    )


def _verdict(key: tuple[str, str, str, bool], pairs: Sequence[_Pair]) -> Verdict:
    quantity, method, unit, whole_crop = key
    title = _title(quantity, method, whole_crop=whole_crop)
    return Verdict(
        quantity=quantity,
        title=f"{title} [{show_unit(unit)}]" if method == _BOTH_UNITS else title,
        method=method,
        summary=_spread(pairs),
        reason=_reason(key, pairs),
    )


def _reason(key: tuple[str, str, str, bool], pairs: Sequence[_Pair]) -> str:
    _, method, unit, whole_crop = key
    channels = frozenset(pair.legacy.channel for pair in pairs)
    return reason(method, channels=channels, unit=unit, whole_crop=whole_crop)


def _title(quantity: str, method: str, *, whole_crop: bool) -> str:
    title = title_of(quantity)
    if whole_crop:
        return f"{title}, whole crop"
    return f"{title}, tiles" if method in ("legacy-slope-std", "legacy-intercept-std") else title


def _text(pair: _Pair) -> tuple[str, ...]:
    """Return the corrected figure with its 95 % interval, those of both greens, or the range over channels."""
    if len(pair.partners) > 2:
        values = [row.measured for row in pair.partners]
        low, high = (end(values, key=lambda one: one.value) for end in (min, max))
        return (f"{show_value(low)} to {show_value(high)}", "over the channels")
    told = [_with_interval(row) for row in pair.partners]
    if pair.legacy.channel in {row.channel for row in pair.partners}:
        return (told[0],)
    return tuple(f"{row.channel} {text}" for row, text in zip(pair.partners, told, strict=True))


def _with_interval(row: Row) -> str:
    interval = show_interval(row.measured)
    if row.measured.value <= 0.0 and "upper-limit" in row.flags:
        return show(row.measured, row.flags)
    return show_value(row.measured) if interval == MISSING else f"{show_value(row.measured)} ({interval})"


def _published(pair: _Pair) -> str:
    """Return a published figure, which mostly has no error of its own, to four digits or those of the corrected one."""
    legacy, error = pair.legacy.measured, pair.partners[0].measured.std_error
    if legacy.std_error is not None or not error or legacy.value == 0.0:
        return show(legacy, pair.legacy.flags)
    four = _PUBLISHED_DIGITS - 1 - math.floor(math.log10(abs(legacy.value)))
    places = min(max(1 - math.floor(math.log10(error)), 0), four)
    return (
        f"{legacy.value:.{places}f}".replace("-", _MINUS) if 0 <= places <= _MOST_PLACES else show_plain(legacy.value)
    )


def _reference(pair: _Pair) -> tuple[float, float]:
    """Return the mean of the corrected figures and its standard error."""
    count = len(pair.partners)
    errors = [row.measured.std_error or 0.0 for row in pair.partners]
    return sum(row.measured.value for row in pair.partners) / count, sum(error**2 for error in errors) ** 0.5 / count


def _apart(pair: _Pair) -> float | None:
    """Return the published figure over the corrected one, minus 1; None where that one may as well be zero."""
    value, error = _reference(pair)
    return None if abs(value) <= _CERTAIN * error else pair.legacy.measured.value / value - 1.0


def _difference(pair: _Pair) -> str:
    """Return the difference in per cent, as a multiple where large, in standard errors where per cent mean nothing."""
    if (apart := _apart(pair)) is not None:
        return _relative(apart)
    value, error = _reference(pair)
    if not error:
        return MISSING
    return f"{show_signed((pair.legacy.measured.value - value) / error)} standard errors"


def _relative(apart: float) -> str:
    if apart >= 9.0:
        return f"{apart + 1.0:.3g} times"
    return f"{show_signed(100.0 * apart, 0 if abs(apart) >= 1.0 else 1)} %"


def _spread(pairs: Sequence[_Pair]) -> str:
    parts = sorted(apart for pair in pairs if (apart := _apart(pair)) is not None)
    if not parts:
        return "corrected figures that may as well be zero"
    text = _relative(statistics.median(parts))
    return f"{text} ({_relative(parts[0])} to {_relative(parts[-1])})" if len(parts) > 1 else text


def _summary(groups: Mapping[tuple[str, str, str, bool], Sequence[_Pair]]) -> str:
    """Return what the published methods would have said, over the median of all ISOs and channels."""
    told: list[str] = []
    for (quantity, method, unit, whole_crop), pairs in groups.items():
        parts = [apart for pair in pairs if (apart := _apart(pair)) is not None]
        if not parts or whole_crop or (method == _BOTH_UNITS and unit != "DN"):
            continue
        name = title_of(quantity)
        name = name if name.isupper() else name[:1].lower() + name[1:]
        told.append(f"{name} {_relative(statistics.median(parts))} ({method.removeprefix(LEGACY)})")
    return f"{'; '.join(told)}." if told else ""
