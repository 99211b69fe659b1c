"""Whether the content of a mosaic bears its colour filter array out."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from fullwell.findings import Finding, Severity
from fullwell.raw.cfa import MONO
from fullwell.report.numbers import show_signed
from fullwell.statistics.mosaic_order import MosaicOrder, Order, alternation

ALTERNATION_ERRORS = 6.0
ALTERNATION_SHARE = 0.25
"""Of the noise of a pixel, from where on lines that take turns are worth telling."""


def order_findings(order: MosaicOrder, *, cfa: str | None) -> tuple[Finding, ...]:
    """Return a finding where content and declaration contradict each other, or where nothing is declared.

    Parameters
    ----------
    order
        What the content tells.
    cfa
        As declared; None where the file does not say.

    """
    names = " or ".join(order.order.names)
    if order.order is Order.QUAD:
        message = (
            "The mosaic repeats every four pixels with two by two alike: a quad-Bayer array that was not combined to "
            "Bayer; its planes hold mixed colours, so nothing of it can be measured as a Bayer mosaic."
        )
        return (Finding(code="quad-bayer", severity=Severity.WARNING, message=message),)
    if cfa is None and order.order in {Order.GREENS_ANTI, Order.GREENS_MAIN}:
        message = (
            f"The content is a Bayer mosaic with its greens on {_diagonal(order.order)}: {names} (which of both cannot "
            "be told without knowing the light); say so with --cfa."
        )
        return (Finding(code="cfa-suggested", severity=Severity.INFO, message=message),)
    if cfa is None or order.order is Order.UNTOLD or cfa in order.order.names:
        return ()
    if order.order is Order.ALIKE:
        message = (
            f"All four sites of what is declared {cfa} agree to {100.0 * order.all_sites:.1f} % all over the scene: a "
            "monochrome sensor, or light that the colour filters do not tell apart, such as near infrared. If it is "
            "monochrome, say --cfa mono."
        )
        return (Finding(code="cfa-contradicted", severity=Severity.WARNING, message=message),)
    greens, others = sorted((order.main, order.anti))
    declared = "no mosaic at all" if cfa == MONO else f"{cfa}, which has its greens on the other"
    message = (
        f"The greens of this mosaic lie on {_diagonal(order.order)}: its two sites agree to {100.0 * greens:.1f} %, "
        f"those of the other diagonal differ by {100.0 * others:.0f} %. The file says {declared}. Its order is {names} "
        "(which of both cannot be told without knowing the light); give it with --cfa."
    )
    return (Finding(code="cfa-contradicted", severity=Severity.WARNING, message=message),)


def alternation_findings(planes: Sequence[NDArray[np.uint16]], channels: Sequence[str]) -> tuple[Finding, ...]:
    """Return a finding where even and odd lines of the planes differ: an interleaved readout.

    Parameters
    ----------
    planes
        One per channel [DN].
    channels
        Their names.

    """
    found: list[Finding] = []
    for axis, lines in ((0, "rows"), (1, "columns")):
        told = [(channel, step) for channel, plane in zip(channels, planes, strict=True)
                if (step := _alternates(plane, axis)) is not None]  # fmt: skip
        if told:
            said = ", ".join(f"{channel} {show_signed(step, 2)} DN" for channel, step in told)
            message = (
                f"Even and odd {lines} differ in level ({said}): an interleaved readout, whose converters or "
                "amplifiers take turns. Fixed pattern and line noise hold that difference."
            )
            found.append(Finding(code="interleaved-lines", severity=Severity.INFO, message=message))
    return tuple(found)


def _alternates(plane: NDArray[np.uint16], axis: int) -> float | None:
    if min(plane.shape) < 16:
        return None
    found = alternation(plane, axis=axis)
    across = np.diff(plane.astype(np.int32), axis=1 - axis)
    noise = float(np.median(np.abs(across))) / 0.954
    beyond = abs(found.difference_dn) > ALTERNATION_ERRORS * found.std_error_dn
    return found.difference_dn if beyond and abs(found.difference_dn) > ALTERNATION_SHARE * max(noise, 1.0) else None


def _diagonal(order: Order) -> str:
    return "the main diagonal" if order is Order.GREENS_MAIN else "the other diagonal, top right and bottom left"
