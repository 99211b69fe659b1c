"""What the gaps of histograms say: code steps, scaled channels, companding, missing codes (METHOD 0, 1.10, 10.3)."""

import math
from collections.abc import Iterable, Sequence
from typing import Final

from fullwell.findings import Finding, Severity
from fullwell.statistics.codes import CodeUse, Pattern

PROCESSED: Final = frozenset({Pattern.SCALED_UP, Pattern.SCALED_DOWN, Pattern.COMPANDED, Pattern.MISSING})
"""Patterns that a converter does not make by itself."""


def code_findings(channels: Sequence[str], uses: Sequence[CodeUse], *, at: str = "") -> tuple[Finding, ...]:
    """Return what the codes of some channels say.

    Parameters
    ----------
    channels, uses
        Names and code use, one each.
    at
        Where, with a blank before it, for example ``" at ISO 100"``.

    """
    named = tuple(zip(channels, uses, strict=True))
    return tuple(finding for find in (_stepped, _scaled, _companded, _missing) for finding in find(named, at))


def effective_bits(uses: Iterable[CodeUse], *, bit_depth: int, code_bits: int, unused_bits: int | None) -> int | None:
    """Return the bits of the codes less what the code step leaves unused; None where nothing tells it.

    Parameters
    ----------
    uses
        Code use of every channel.
    bit_depth
        As declared: more bits are never told apart [bit].
    code_bits
        Bits that decoded codes take up to white [bit].
    unused_bits
        Low bits that are zero in every code; None where every code is zero [bit].

    """
    every = tuple(uses)
    if unused_bits is None:
        return None
    finest = min(one.scale for one in every)
    told = all(one.judged for one in every)
    unused = max(unused_bits, math.floor(math.log2(finest) + 1e-9) if told and finest >= 1.0 else 0)
    return min(bit_depth, code_bits - unused)


def _stepped(named: Sequence[tuple[str, CodeUse]], at: str) -> tuple[Finding, ...]:
    steps = {use.step for _, use in named if use.pattern is Pattern.STEPPED}
    found: list[Finding] = []
    for step in sorted(steps):
        apart = [(channel, use) for channel, use in named if use.pattern is Pattern.STEPPED and use.step == step]
        multiples = all(use.lowest % step == 0 for _, use in apart)
        what = f"is a multiple of {step}" if multiples else f"lies a multiple of {step} above the lowest"
        bits = math.log2(step)
        empty = (
            f": the low {f'{bits:g} bits hold' if bits > 1 else 'bit holds'} nothing"
            if bits.is_integer() and multiples
            else ""
        )
        message = (
            f"Every code of {_listed(channel for channel, _ in apart)}{at} {what}{empty}. The quantization "
            f"step is {step} DN, not 1: its noise, step/√12, is {step / math.sqrt(12.0):.3g} DN, and K in DN/e- is "
            f"{step} times that of the converter."
        )
        found.append(Finding(code="code-step", severity=Severity.INFO, message=message))
    return tuple(found)


def _scaled(named: Sequence[tuple[str, CodeUse]], at: str) -> tuple[Finding, ...]:
    found: list[Finding] = []
    up = [(channel, use) for channel, use in named if use.pattern is Pattern.SCALED_UP]
    if up:
        factors = " and ".join(f"{use.scale:.4g} DN ({channel})" for channel, use in up)
        others = [channel for channel, use in named if use.pattern not in {Pattern.SCALED_UP, Pattern.SCALED_DOWN}]
        beside = f", unlike those of {_listed(others)}" if others else ""
        meaning = "digital white balance in the raw file" if others else "a scaled file"
        message = (
            f"Codes are used only every {factors}{at}{beside}: empty codes at regular distances, a comb, as a "
            f"multiplication after the converter leaves it ({meaning}). Signal, noise and K in DN hold that factor, "
            "and it is the quantization step; figures in electrons do not change."
        )
        found.append(Finding(code="scaled-codes", severity=Severity.WARNING, message=message))
    down = [(channel, use) for channel, use in named if use.pattern is Pattern.SCALED_DOWN]
    if down:
        factors = " and ".join(f"{use.scale:.4g} ({channel})" for channel, use in down)
        message = (
            f"Codes at regular distances hold twice what their neighbours hold{at}, as a multiplication by {factors} "
            "after the converter leaves it: two of its codes fell into one. Signal, noise and K in DN hold that "
            "factor. (Where the distance is a power of two, a converter with unequal steps does the same.)"
        )
        found.append(Finding(code="doubled-codes", severity=Severity.WARNING, message=message))
    return tuple(found)


def _companded(named: Sequence[tuple[str, CodeUse]], at: str) -> tuple[Finding, ...]:
    curved = [(channel, use) for channel, use in named if use.pattern is Pattern.COMPANDED]
    if not curved:
        return ()
    first = curved[0][1]
    widest = max(use.widest for _, use in curved)
    low, high = first.judged or (first.lowest, first.highest)
    message = (
        f"The codes in use of {_listed(channel for channel, _ in curved)}{at} lie farther and farther apart, from "
        f"{first.scale:.3g} DN at {low} DN to {widest} DN at {high} DN: they were companded (a curve with "
        "fewer codes in the highlights, undone when read). The quantization step grows with the signal, its variance "
        "step²/12 with it; read noise is safe only where the step is 1."
    )
    return (Finding(code="companded-codes", severity=Severity.WARNING, message=message),)


def _missing(named: Sequence[tuple[str, CodeUse]], at: str) -> tuple[Finding, ...]:
    alike: dict[tuple[tuple[int, ...], int], list[str]] = {}
    for channel, use in named:
        if use.pattern is Pattern.MISSING:
            alike.setdefault((use.missing, use.n_missing), []).append(channel)
    found: list[Finding] = []
    for (codes, count), channels in alike.items():
        shown = ", ".join(map(str, codes)) + (" ..." if count > len(codes) else "")
        message = (
            f"{count} codes of {_listed(channels)}{at} never occur though those around them do: {shown}. A table or a "
            "filter left them out; variances of noise not far wider than such a gap are wrong."
        )
        found.append(Finding(code="missing-codes", severity=Severity.WARNING, message=message))
    return tuple(found)


def _listed(channels: Iterable[str]) -> str:
    return ", ".join(channels)
