"""Pictures of a comparison: how far figures differ in standard errors, and the photon transfer curves in one panel."""

from collections.abc import Sequence
from typing import Final

import numpy as np

from fullwell.figures.side_by_side import Comparison
from fullwell.glossary import RECOMMENDED
from fullwell.report.curves import Table, Value, table_named
from fullwell.report.drawing import Axes
from fullwell.report.drawing.style import QUIET, Fill
from fullwell.report.pivots import title_of
from fullwell.report.plots import (
    Picture,
    canvas,
    channel_legend,
    color_of,
    iso_title,
    marker_of,
    picture,
)

_REACH: Final = 8.0
"""Standard errors at which the axis ends; what lies beyond stands at its edge."""
_FILLS: Final[tuple[Fill, ...]] = ("full", "none", "left", "bottom")
"""Of the markers of A, B and so on; where all is a difference from A, of B and so on."""


def comparison_pictures(comparison: Comparison) -> tuple[Picture, ...]:
    """Return the pictures there is something to see in."""
    return (*_pulls(comparison), *_transfer(comparison))


def _pulls(comparison: Comparison) -> tuple[Picture, ...]:
    """Draw every recommended figure's difference from A, in standard errors."""
    points: dict[str, list[tuple[int, str, float]]] = {}
    for match in comparison.matches:
        row = match.reference
        best = any(one is not None and RECOMMENDED in one.flags for one in match.rows)
        if not best or row.region is not None or row.quantity.endswith("_variance"):
            continue
        for at, one in enumerate(match.differences):
            if one is not None and one.statistic is not None:
                points.setdefault(row.quantity, []).append((at, row.channel, one.statistic))
    if not points:
        return ()
    figure, (axes,) = canvas(1, 1, height_in=1.1 + 0.27 * len(points))
    axes.axvspan(-2.0, 2.0, color="#eef2f5")
    axes.axvline(0.0, color=QUIET, linewidth=0.8)
    for place, values in enumerate(points.values()):
        for at, channel, statistic in values:
            axes.plot(
                float(np.clip(statistic, -_REACH, _REACH)),
                place,
                marker=marker_of(channel),
                color=color_of(channel),
                fillstyle=_FILLS[(at - 1) % len(_FILLS)],
                linestyle="none",
                clip_on=False,
            )
    axes.set_yticks(range(len(points)), [title_of(quantity) for quantity in points])
    axes.invert_yaxis()
    axes.set_xlim(-_REACH, _REACH)
    axes.set_xlabel("Difference from A [standard errors]")
    channel_legend(figure, [channel for values in points.values() for _, channel, _ in values])
    return (
        picture(
            figure,
            alt="Differences from A in standard errors, by quantity",
            caption=(
                "Recommended figures by the same method: difference from A in standard errors of the difference. The "
                f"grey band is ±2; what differs by more than {_REACH:g} stands at the edge. Filled markers: "
                f"{comparison.sides[1].label}; open and half ones: those after it."
            ),
        ),
    )


def _transfer(comparison: Comparison) -> tuple[Picture, ...]:
    """Draw the photon transfer curves of one ISO in one panel, at most three ISOs."""
    tables = [table_named(side.results.curves, "photon_transfer") for side in comparison.sides]
    isos: list[dict[Value, Table]] = [dict(table.split("iso")) if table else {} for table in tables]
    common = [iso for iso in dict.fromkeys(iso for one in isos for iso in one) if sum(iso in one for one in isos) > 1]
    if not common:
        return ()
    shown = common[:3]
    figure, panels = canvas(1, len(shown), height_in=3.6)
    channels: list[str] = []
    for axes, iso in zip(panels, shown, strict=True):
        for at, one in enumerate(isos):
            if iso in one:
                channels += _points(axes, one[iso], at)
        _finish(axes, iso)
    channel_legend(figure, channels)
    return (
        picture(
            figure,
            alt="Photon transfer of all results in one panel",
            caption=(
                "Temporal variance against signal above black. Filled markers: A; open and half ones: those after it."
            ),
        ),
    )


def _points(axes: Axes, table: Table, at: int) -> Sequence[str]:
    names: list[str] = []
    for channel, part in table.split("channel"):
        signal, variance = part.numbers("signal"), part.numbers("variance")
        lit = (signal > 0.0) & (variance > 0.0) & np.array([kind == "flat" for kind in part.values("kind")])
        axes.plot(
            signal[lit],
            variance[lit],
            linestyle="none",
            marker=marker_of(str(channel)),
            color=color_of(str(channel)),
            fillstyle=_FILLS[at % len(_FILLS)],
            markersize=4.5,
        )
        names.append(str(channel))
    return names


def _finish(axes: Axes, iso: Value) -> None:
    axes.set_xscale("log")
    axes.set_yscale("log")
    axes.set(xlabel="Signal above black [DN]", ylabel="Variance [DN²]")
    axes.set_title(iso_title(iso))
