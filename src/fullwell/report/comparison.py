"""The recommended figure beside the published one, and why they differ."""

import statistics
from collections.abc import Sequence
from dataclasses import dataclass

from fullwell import glossary
from fullwell.figures.results import Row
from fullwell.raw.cfa import channel_rank
from fullwell.report.numbers import MISSING, show, show_iso, show_unit
from fullwell.report.pivots import recommended, title_of, tooltip

LEGACY = "legacy-"
_MINUS = "\N{MINUS SIGN}"
_CERTAIN = 4.0
"""Standard errors from zero up to which a ratio means nothing."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Pair:
    """One figure by both methods."""

    iso: str
    channel: str
    recommended: str
    recommended_title: str
    published: str
    ratio: str


@dataclass(frozen=True, slots=True, kw_only=True)
class Comparison:
    """One published method beside the recommended one, over all ISOs and channels."""

    quantity: str
    title: str
    unit: str
    method: str
    definition: str
    bias: str
    summary: str
    pairs: tuple[Pair, ...]


def comparisons(rows: Sequence[Row]) -> tuple[Comparison, ...]:
    """Return every published method that has a recommended figure beside it, in the native unit of the quantity."""
    best = {_key(row): row for row in recommended(rows)}
    groups: dict[tuple[str, str, str], list[tuple[Row, Row]]] = {}
    for row in rows:
        if row.method.startswith(LEGACY) and row.region is None and (partner := best.get(_key(row))):
            groups.setdefault((row.quantity, row.method, row.measured.unit), []).append((partner, row))
    native: dict[tuple[str, str], str] = {}
    for quantity, method, unit in groups:
        native.setdefault((quantity, method), unit)
    return tuple(
        _comparison(quantity, method, unit, pairs)
        for (quantity, method, unit), pairs in groups.items()
        if native[(quantity, method)] == unit
    )


def _key(row: Row) -> tuple[object, ...]:
    return (row.quantity, row.channel, row.measured.unit, row.iso, row.temperature_c, row.snr_threshold)


def _comparison(quantity: str, method: str, unit: str, pairs: Sequence[tuple[Row, Row]]) -> Comparison:
    entry = glossary.method(method)
    ordered = sorted(pairs, key=lambda pair: (pair[0].iso or 0.0, channel_rank(pair[0].channel)))
    return Comparison(
        quantity=quantity,
        title=title_of(quantity),
        unit=show_unit(unit) or "1",
        method=method,
        definition=entry.definition if entry else "",
        bias=entry.bias if entry else "",
        summary=_summary(ordered),
        pairs=tuple(
            Pair(
                iso=show_iso(best.iso),
                channel=best.channel,
                recommended=show(best.measured, best.flags),
                recommended_title=tooltip(best),
                published=_published(best, legacy),
                ratio=_ratio(best, legacy),
            )
            for best, legacy in ordered
        ),
    )


def _published(best: Row, legacy: Row) -> str:
    """Return a published figure, which mostly has no error of its own, to the digits of the recommended one."""
    if legacy.measured.std_error is not None or not best.measured.std_error:
        return show(legacy.measured, legacy.flags)
    digits = max(0, 1 - int(f"{best.measured.std_error:.1e}".partition("e")[2]))
    return f"{legacy.measured.value:.{min(digits, 9)}f}".replace("-", _MINUS)


def _apart(best: Row, legacy: Row) -> float | None:
    """Return the published figure over the recommended one, minus 1; None where that one may as well be zero."""
    value, error = best.measured.value, best.measured.std_error or 0.0
    return None if abs(value) <= _CERTAIN * error else legacy.measured.value / value - 1.0


def _ratio(best: Row, legacy: Row) -> str:
    """Return the difference in per cent, or in standard errors where per cent mean nothing."""
    if (apart := _apart(best, legacy)) is not None:
        return f"{100.0 * apart:+.1f} %".replace("-", _MINUS)
    if not best.measured.std_error:
        return MISSING
    pull = (legacy.measured.value - best.measured.value) / best.measured.std_error
    return f"{pull:+.1f} standard errors".replace("-", _MINUS)


def _summary(pairs: Sequence[tuple[Row, Row]]) -> str:
    found = (_apart(best, legacy) for best, legacy in pairs)
    parts = [100.0 * apart for apart in found if apart is not None]
    if not parts:
        return "the recommended figures cannot be told from zero, so a ratio would mean nothing"
    text = f"published against recommended: {statistics.median(parts):+.1f} %"
    if len(parts) > 1:
        text += f" in the median, {min(parts):+.1f} % to {max(parts):+.1f} %"
    return text.replace("-", _MINUS)
