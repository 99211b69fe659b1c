"""The look of every picture: colours, type, canvases, and how a picture becomes part of a page.

Draw inside `style`, on a canvas from `canvas`, with `color_of` and `marker_of` for channels; finish with
`vector_picture` (lines and points) or `pixel_picture` (images).
"""

import base64
import io
import math
import re
from collections.abc import Generator, Iterable, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any, Final, Literal, TypeAlias

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.backends.backend_svg import FigureCanvasSVG
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter, NullLocator
from numpy.typing import NDArray
from PIL import Image

from fullwell.raw.cfa import channel_rank
from fullwell.report.canvas import Picture, picture_of
from fullwell.report.numbers import show_iso

WIDTH_IN: Final = 9.2
INK: Final = "#1f2933"
QUIET: Final = "#7b8794"
PAPER: Final = "#ffffff"
DENSE: Final = 150
"""Points from which on a scatter is drawn as pixels inside the vector picture."""
PIXELS: Final = -1.0
"""Put what is to become pixels at this ``zorder``, and call `pixels_below` for its panel."""

_FEW_DECADES: Final = 50.0
"""Ratio of ends up to which a logarithmic axis is labelled at 1, 2 and 5."""

_SVG_DPI: Final = 72
_PAD_IN: Final = 3.0 / 72.0
"""What is left empty around a figure of one panel [inch]."""

_SVG_WORDS: Final = re.compile(rb"<!--.*?-->|<metadata>.*?</metadata>|(?<=>)\s+(?=<)", re.DOTALL)
"""What a viewer of an SVG does not need: comments, metadata, blanks between tags."""

LineStyle: TypeAlias = Literal["-", "--", ":", "none"]

_COLORS: Final = (
    ("R", "#d1432f"),
    ("G1", "#00875f"),
    ("G2", "#93b52b"),
    ("B", "#1f6fc4"),
    ("mono", "#334155"),
    ("G", "#00875f"),
    ("all", "#6d4aa8"),
)
_MARKERS: Final = (("R", "s"), ("G1", "o"), ("G2", "D"), ("B", "^"), ("mono", "o"), ("G", "o"), ("all", "P"))
_STYLE: Final[dict[Any, Any]] = {
    "font.family": "sans-serif",
    "font.sans-serif": ["DejaVu Sans"],
    "font.size": 9.0,
    "axes.titlesize": 9.5,
    "axes.titleweight": "bold",
    "axes.titlelocation": "left",
    "axes.labelsize": 9.0,
    "axes.labelcolor": INK,
    "axes.edgecolor": "#b8c2cc",
    "axes.linewidth": 0.8,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "axes.axisbelow": True,
    "axes.formatter.useoffset": False,
    "grid.color": "#e6eaee",
    "grid.linewidth": 0.7,
    "text.color": INK,
    "xtick.color": "#52606d",
    "ytick.color": "#52606d",
    "xtick.labelsize": 8.0,
    "ytick.labelsize": 8.0,
    "lines.linewidth": 1.4,
    "lines.markersize": 4.0,
    "legend.frameon": False,
    "legend.fontsize": 8.5,
    "figure.facecolor": PAPER,
    "figure.constrained_layout.use": True,
    "svg.hashsalt": "fullwell",
    "svg.fonttype": "path",
    "mathtext.fontset": "dejavusans",
}


@contextmanager
def style() -> Generator[None]:
    """Draw and save pictures inside this."""
    with mpl.rc_context(_STYLE):
        yield


def canvas(rows: int, columns: int, *, height_in: float) -> tuple[Figure, list[Axes]]:
    """Return a figure as wide as the page and its axes, row by row."""
    figure = Figure(figsize=(WIDTH_IN, height_in))
    axes = figure.subplots(rows, columns, squeeze=False)
    return figure, [one for line in axes for one in line]


def sheet(height_in: float) -> Figure:
    """Return an empty figure as wide as the page, to be laid out by hand: axes in space tell no size of their own."""
    with mpl.rc_context({"figure.constrained_layout.use": False}):
        return Figure(figsize=(WIDTH_IN, height_in))


def grid_of(count: int, *, panel_height_in: float, columns: int | None = None) -> tuple[Figure, list[Axes]]:
    """Return a figure with ``count`` panels, three in a row if not told; what is left over stays empty."""
    columns = columns or min(count, 3)
    rows = math.ceil(count / columns)
    figure, axes = canvas(rows, columns, height_in=panel_height_in * rows + 0.35)
    for spare in axes[count:]:
        spare.set_visible(False)
    return figure, axes[:count]


def color_of(channel: str) -> str:
    """Return the colour of a channel, told apart also by those who see no red or green."""
    return dict(_COLORS).get(channel, INK)


def marker_of(channel: str) -> str:
    """Return the marker of a channel: no two channels rest on colour alone."""
    return dict(_MARKERS).get(channel, "o")


def channel_legend(figure: Figure, channels: Iterable[str], extra: Sequence[Line2D] = ()) -> None:
    """Name the channels, and what else is drawn, once above all panels."""
    names = sorted(set(channels), key=channel_rank)
    keys = [Line2D([], [], color=color_of(name), marker=marker_of(name), linestyle="", label=name) for name in names]
    keys += extra
    if len(keys) > 1:
        figure.legend(handles=keys, loc="outside upper right", ncols=len(keys), handletextpad=0.4, columnspacing=1.4)


def key(label: str, *, color: str = INK, linestyle: LineStyle = "-", marker: str = "") -> Line2D:
    """Return an entry for the legend."""
    return Line2D([], [], color=color, linestyle=linestyle, marker=marker, label=label, markerfacecolor="none")


def pixels_below(axes: Axes) -> None:
    """Draw what stands at `PIXELS` as one image inside the vector picture: small, however many points it has."""
    axes.set_rasterization_zorder(PIXELS / 2.0)


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
    axes.set_xscale("log", base=2)
    axes.xaxis.set_major_locator(NullLocator())
    axes.xaxis.set_minor_locator(NullLocator())
    axes.set_xlim(known[0] / 1.25, known[-1] * 1.25)
    labelled = _spaced(known, label_share)
    axes.set_xticks(labelled, [f"{iso:g}" for iso in labelled])
    axes.xaxis.set_minor_formatter(NullFormatter())


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


def log_axis(axes: Axes, which: str) -> None:
    """Make an axis logarithmic, with plain numbers at few places: call it when all is drawn and limits are set."""
    axis = axes.xaxis if which == "x" else axes.yaxis
    low, high = axes.get_xlim() if which == "x" else axes.get_ylim()
    if low <= 0.0 and math.isinf(axes.dataLim.minposx if which == "x" else axes.dataLim.minposy):
        (axes.set_xlim if which == "x" else axes.set_ylim)(0.1, 1.0)  # nothing above zero is drawn
    (axes.set_xscale if which == "x" else axes.set_yscale)("log")
    low, high = axes.get_xlim() if which == "x" else axes.get_ylim()
    subs = (1.0, 2.0, 5.0) if high < _FEW_DECADES * low else (1.0,)
    axis.set_major_locator(LogLocator(subs=subs, numticks=7 * len(subs)))
    axis.set_major_formatter(FuncFormatter(_decade))
    axis.set_minor_locator(NullLocator())


def _decade(value: float, _position: int | None) -> str:
    """Return a tick label: plain from 0.001 to below 10 000, else with a power of ten."""
    if 1e-3 <= value < 1e4 or value <= 0.0:
        return f"{value:g}"
    mantissa, _, exponent = f"{value:.0e}".partition("e")
    power = f"10^{{{int(exponent)}}}"
    return f"${power}$" if mantissa == "1" else f"${mantissa}\\cdot{power}$"


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


def thinned(order: NDArray[np.intp], most: int = 120) -> NDArray[np.intp]:
    """Return at most ``most`` of the ordered indices, both ends kept: enough for a smooth line."""
    if len(order) <= most:
        return order
    return order[np.unique(np.linspace(0, len(order) - 1, most).round().astype(np.intp))]


def iso_title(iso: float | str | None) -> str:
    """Return the title of the panel of one ISO."""
    return show_iso(iso if isinstance(iso, (int, float)) else None)


def vector_picture(figure: Figure, *, alt: str, caption: str) -> Picture:
    """Return a drawing as SVG; dense scatters inside it are pixels."""
    return picture_of(svg_of(figure), alt=alt, caption=caption)


def svg_of(figure: Figure) -> bytes:
    """Return a drawing as SVG, the same bytes for the same drawing.

    It is laid out at the resolution of SVG, at which texts are measured once then, and printed without `savefig`, which
    draws everything a first time for nothing.
    """
    figure.set_dpi(_SVG_DPI)
    _settle(figure)
    figure.set_dpi(140)
    buffer = io.BytesIO()
    FigureCanvasSVG(figure).print_svg(buffer, metadata={"Date": None, "Creator": None})
    return _SVG_WORDS.sub(b"", buffer.getvalue())


def font_folder() -> Path:
    """Return the folder of the fonts that pictures are set in."""
    return Path(mpl.get_data_path()) / "fonts" / "ttf"


def pixel_picture(figure: Figure, *, alt: str, caption: str, colors: int = 128) -> Picture:
    """Return a drawing with images in it as PNG of few colours, 256 at most."""
    figure.set_dpi(150)
    _settle(figure)
    drawing = FigureCanvasAgg(figure)
    drawing.draw()
    packed = io.BytesIO()
    picture = Image.fromarray(np.asarray(drawing.buffer_rgba())).convert("RGB")
    picture.quantize(colors=colors, dither=Image.Dither.NONE).save(packed, format="PNG")
    encoded = base64.b64encode(packed.getvalue()).decode("ascii")
    return Picture(uri=f"data:image/png;base64,{encoded}", alt=alt, caption=caption)


def _settle(figure: Figure) -> None:
    """Lay the figure out once: saving would otherwise draw everything a second time for it."""
    engine = figure.get_layout_engine()
    if engine is None:
        return
    figure.set_layout_engine("none")
    if len(figure.axes) == 1 and not figure.legends:
        _settle_one(figure, figure.axes[0])
    else:
        engine.execute(figure)


def _settle_one(figure: Figure, axes: Axes) -> None:
    """Lay out the only panel of a figure, whose texts are measured once for it, not twice as by the layout of several.

    It is measured at about the size it will have: what surrounds it depends little on that.
    """
    axes.set_position((0.08, 0.12, 0.9, 0.8))
    outer, inner = axes.get_tightbbox(for_layout_only=True), axes.get_window_extent()
    if outer is None:
        return
    width, height = figure.bbox.width, figure.bbox.height
    pad = _PAD_IN * figure.dpi
    left, bottom = (inner.x0 - outer.x0 + pad) / width, (inner.y0 - outer.y0 + pad) / height
    right, top = (outer.x1 - inner.x1 + pad) / width, (outer.y1 - inner.y1 + pad) / height
    axes.set_position((left, bottom, 1.0 - left - right, 1.0 - bottom - top))
