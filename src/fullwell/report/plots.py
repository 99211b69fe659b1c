"""The look of every picture: channels, ISOs, canvases, and how a picture becomes part of a page.

Draw on a canvas from `canvas` or `grid_of`, with `color_of` and `marker_of` for channels; finish with `picture`.
"""

import base64
import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from fullwell.raw.cfa import channel_rank
from fullwell.report.drawing import Axes, Figure, Key, key
from fullwell.report.drawing.images import data_uri
from fullwell.report.drawing.style import INK, Marker
from fullwell.report.numbers import show_iso

WIDTH_IN: Final = 9.2
DENSE: Final = 150
"""Points from which on a scatter is drawn as pixels."""

_COLORS: Final = (
    ("R", "#d1432f"),
    ("G1", "#00875f"),
    ("G2", "#93b52b"),
    ("B", "#1f6fc4"),
    ("mono", "#334155"),
    ("G", "#00875f"),
    ("all", "#6d4aa8"),
)
_MARKERS: Final[tuple[tuple[str, Marker], ...]] = (
    ("R", "s"),
    ("G1", "o"),
    ("G2", "D"),
    ("B", "^"),
    ("mono", "o"),
    ("G", "o"),
    ("all", "P"),
)


@dataclass(frozen=True, slots=True, kw_only=True)
class Picture:
    """A picture ready for the page: its data URI, what it shows in words, and what is to be seen in it."""

    uri: str
    alt: str
    caption: str


def canvas(rows: int, columns: int, *, height_in: float) -> tuple[Figure, list[Axes]]:
    """Return a figure as wide as the page and its axes, row by row."""
    figure = Figure((WIDTH_IN, height_in))
    return figure, figure.subplots(rows, columns)


def grid_of(count: int, *, panel_height_in: float, columns: int | None = None) -> tuple[Figure, list[Axes]]:
    """Return a figure with ``count`` panels, three in a row if not told; what is left over stays empty."""
    columns = columns or min(count, 3)
    rows = math.ceil(count / columns)
    figure, axes = canvas(rows, columns, height_in=panel_height_in * rows + 0.35)
    for spare in axes[count:]:
        spare.visible = False
    return figure, axes[:count]


def color_of(channel: str) -> str:
    """Return the colour of a channel, told apart also by those who see no red or green."""
    return dict(_COLORS).get(channel, INK)


def marker_of(channel: str) -> Marker:
    """Return the marker of a channel: no two channels rest on colour alone."""
    markers: dict[str, Marker] = dict(_MARKERS)
    return markers.get(channel, "o")


def channel_legend(figure: Figure, channels: Iterable[str], extra: Sequence[Key] = ()) -> None:
    """Name the channels, and what else is drawn, once above all panels."""
    names = sorted(set(channels), key=channel_rank)
    keys = [
        key(name, color=color_of(name), marker=marker_of(name), markerfacecolor=color_of(name), linestyle="none")
        for name in names
    ]
    keys += extra
    if len(keys) > 1:
        figure.legend(keys)


def iso_axis(axes: Axes, isos: Iterable[float], *, label_share: float) -> None:
    """Make the abscissa the ISO: logarithmic, one tick per ISO measured, labels that do not touch.

    Parameters
    ----------
    axes
        To change.
    isos
        Those measured.
    label_share
        Width of a label as a share of the width of the panel [1].

    """
    known = sorted({iso for iso in isos if math.isfinite(iso)})
    axes.set_xlabel("ISO")
    if not known or known[0] <= 0.0:
        return
    axes.set_xscale("log")
    axes.set_xlim(known[0] / 1.25, known[-1] * 1.25)
    labelled = _spaced(known, label_share)
    axes.set_xticks(labelled, [f"{iso:g}" for iso in labelled])


def _spaced(isos: Sequence[float], label_share: float) -> list[float]:
    """Return the ISOs that can be labelled without touching: the ends, and from the left what keeps its distance."""
    apart = label_share * math.log2(1.6 * isos[-1] / isos[0])
    kept = [isos[0]]
    for iso in isos[1:-1]:
        if math.log2(iso / kept[-1]) >= apart and math.log2(isos[-1] / iso) >= apart:
            kept.append(iso)
    return sorted({*kept, isos[-1]})


def beside(iso: NDArray[np.float64], index: int, count: int) -> NDArray[np.float64]:
    """Return the ISOs of one of ``count`` channels, moved a little so that channels stand side by side."""
    return iso * 1.03 ** (index - (count - 1) / 2.0)


def stepped(codes: NDArray[np.float64], counts: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return a histogram to draw as steps: codes ascending, no line where a code is missing or empty.

    Parameters
    ----------
    codes, counts
        Shape (codes,); codes that do not occur may be left out [DN].

    """
    order = np.argsort(codes)
    codes, counts = codes[order], np.where(counts[order] > 0.0, counts[order], np.nan)
    steps = np.diff(codes)
    width = float(steps.min()) if steps.size else 1.0
    gaps = np.flatnonzero(steps > 1.5 * width)
    codes = np.insert(codes, gaps + 1, codes[gaps] + width)
    return codes, np.insert(counts, gaps + 1, np.nan)


def finite_range(*arrays: NDArray[np.float64], positive: bool = False) -> tuple[float, float] | None:
    """Return the smallest and largest finite (and, if asked for, positive) value, None where there is none."""
    every = np.concatenate([np.ravel(array) for array in arrays]) if arrays else np.array([])
    every = every[np.isfinite(every)]
    every = every[every > 0.0] if positive else every
    return (float(every.min()), float(every.max())) if every.size else None


def iso_title(iso: float | str | None) -> str:
    """Return the title of the panel of one ISO."""
    return show_iso(iso if isinstance(iso, (int, float)) else None)


def picture(figure: Figure, *, alt: str, caption: str) -> Picture:
    """Return a drawing as a picture."""
    return picture_of(figure.svg(), alt=alt, caption=caption)


def drawing_of(picture: Picture) -> bytes:
    """Return the SVG of a picture."""
    return base64.b64decode(picture.uri.partition(",")[2])


def picture_of(drawing: bytes, *, alt: str, caption: str) -> Picture:
    """Return an SVG as a picture."""
    return Picture(uri=data_uri(drawing, kind="svg+xml"), alt=alt, caption=caption)
