"""The graphs of the detail pages in the order of the standard, each with its drawing, its data and what it is for."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Final

from fullwell.figures.results import Curve
from fullwell.report import plots_emva, plots_emva_pattern
from fullwell.report.curves import Table, table_named
from fullwell.report.datasheet.contents import Graph
from fullwell.report.datasheet.tables import Columns, data_tables
from fullwell.report.plots_emva import LARGE, Draw, Legend

_PHOTONS: Final = ("photons", "irradiation", "p")
_EXPOSURE: Final = ("exposure_s", "exposure", "s")
_SIGNAL: Final = ("signal", "signal", "DN")
_NO_SWEEP: Final = "The sweep was not evaluated; the findings say why."
_NO_STACKS: Final = "There are no stacks of dark frames and of frames at half saturation."
_NO_DARKS: Final = "There is no series of dark frames at several exposure times."


@dataclass(frozen=True, slots=True, kw_only=True)
class Curves:
    """The curves of one operation point.

    Parameters
    ----------
    curves
        Of all operation points.
    profile, iso, temperature_c
        Which of their lines belong to this one.

    """

    curves: tuple[Curve, ...]
    profile: str
    iso: float | None
    temperature_c: float | None

    def table(self, name: str) -> Table | None:
        """Return the lines of one curve, None where there is none."""
        table = table_named(self.curves, name)
        if table is None:
            return None
        of_this = (self.profile, self.iso, self.temperature_c)
        mine = table.chosen(line == of_this for line in table.lines("method", "iso", "temperature_c"))
        return mine if len(mine) else None


@dataclass(frozen=True, slots=True, kw_only=True)
class _Kind:
    """One graph of the standard."""

    name: str
    title: str
    caption: str
    curve: str
    draw: Draw
    columns: Columns
    direction: str = ""
    in_range: bool = False
    missing: str = _NO_SWEEP


def graphs_of(curves: Curves, legend_of: Callable[[str], Legend]) -> tuple[Graph, ...]:
    """Return every graph of one operation point.

    Parameters
    ----------
    curves
        Of the operation point.
    legend_of
        Legend of a graph by its name.

    """
    return tuple(_graph(kind, curves, legend_of(kind.name)) for kind in _kinds())


def small_graphs(curves: Curves, legend_of: Callable[[str], Legend]) -> tuple[bytes, ...]:
    """Return photon transfer and SNR for the summary page."""
    size = plots_emva.SMALL
    transfer, ratio = curves.table("emva_photon_transfer"), curves.table("emva_snr")
    drawn: list[bytes] = []
    if transfer is not None:
        drawn.append(plots_emva.photon_transfer(transfer, legend_of("photon-transfer"), size))
    if ratio is not None:
        models = curves.table("emva_snr_model")
        drawn.append(plots_emva.snr(ratio, legend_of("snr"), size, models=models))
    return tuple(drawn)


def _graph(kind: _Kind, curves: Curves, legend: Legend) -> Graph:
    table = _part(curves.table(kind.curve), kind)
    if table is None:
        return Graph(
            name=kind.name, title=kind.title, caption=kind.caption, drawing=b"", tables=(), missing=kind.missing
        )
    if kind.name == "snr":
        drawing = plots_emva.snr(table, legend, LARGE, models=curves.table("emva_snr_model"))
    else:
        drawing = kind.draw(table, legend, LARGE)
    return Graph(
        name=kind.name,
        title=kind.title,
        caption=kind.caption,
        drawing=drawing,
        tables=data_tables(table, kind.columns),
    )


def _part(table: Table | None, kind: _Kind) -> Table | None:
    """Return the lines that a graph is about; None where there are none."""
    if table is None or not (kind.direction or kind.in_range):
        return table
    if kind.direction:
        part = table.chosen(value == kind.direction for value in table.values("direction"))
    else:
        part = table.chosen(value == 1.0 for value in table.values("in_range"))
    return part if len(part) else None


def _kinds() -> Iterator[_Kind]:
    yield from _RESPONSE
    yield from _DARK
    for which, unit in (("dsnu", "DN"), ("prnu", "%")):
        yield from _spectrograms(which, unit)
    for which in ("dsnu", "prnu"):
        yield from _profiles(which)
    for which in ("dsnu", "prnu"):
        yield _histogram(which)
    for which in ("dsnu", "prnu"):
        yield _accumulated(which)


_RESPONSE: Final = (
    _Kind(
        name="characteristic",
        title="Characteristic curve",
        caption="Signal against exposure; the line is the responsivity, the dashed marks the range of its fit.",
        curve="emva_characteristic",
        draw=plots_emva.characteristic,
        columns=(_PHOTONS, _EXPOSURE, _SIGNAL, ("fitted", "line", "DN")),
    ),
    _Kind(
        name="dark-mean",
        title="Dark signal against exposure time",
        caption="Mean dark value at the exposure times of the sweep (exposure control by time).",
        curve="emva_dark_mean",
        draw=plots_emva.dark_mean,
        columns=(_EXPOSURE, ("dark_mean", "mean dark value", "DN")),
        missing="The dark value does not go with the sweep: exposure was not controlled by time.",
    ),
    _Kind(
        name="stability",
        title="Stability",
        caption="Temporal noise, and the difference between the means of both frames of a pair, against signal.",
        curve="emva_stability",
        draw=plots_emva.stability,
        columns=(_SIGNAL, ("noise", "temporal noise", "DN"), ("mean_difference", "difference of means", "DN")),
    ),
    _Kind(
        name="photon-transfer",
        title="Photon transfer",
        caption=(
            "Temporal variance less that of the dark against signal. Solid: the line whose slope is K, over its range; "
            "dotted: beyond it; star: saturation."
        ),
        curve="emva_photon_transfer",
        draw=plots_emva.photon_transfer,
        columns=(
            _SIGNAL,
            ("variance", "variance − dark", "DN^2"),
            ("variance_std_error", "s.e.", "DN^2"),
            ("variance_total", "variance", "DN^2"),
            ("dark_variance", "dark variance", "DN^2"),
            ("fitted", "line", "DN^2"),
        ),
    ),
    _Kind(
        name="snr",
        title="Signal-to-noise ratio",
        caption=(
            "Filled: temporal noise alone; open: spatial noise included. Lines: both models, and that of an ideal "
            "sensor (dotted). Dashed: sensitivity threshold and saturation."
        ),
        curve="emva_snr",
        draw=plots_emva.snr,
        columns=(_PHOTONS, _EXPOSURE, ("snr", "SNR", ""), ("snr_total", "total SNR", "")),
    ),
    _Kind(
        name="linearity",
        title="Linearity",
        caption="Signal against exposure with the line of relative least squares between 5 and 95 % of saturation.",
        curve="emva_linearity",
        draw=plots_emva.linearity,
        columns=(_PHOTONS, _EXPOSURE, _SIGNAL, ("fitted", "line", "DN")),
    ),
    _Kind(
        name="deviation",
        title="Deviation from linearity",
        caption="Relative deviation of the signal from that line; bars: one standard error.",
        curve="emva_linearity",
        draw=plots_emva.deviation,
        in_range=True,
        columns=(_PHOTONS, _EXPOSURE, ("deviation", "deviation", "%"), ("deviation_std_error", "s.e.", "%")),
    ),
)

_DARK: Final = tuple(
    _Kind(
        name=f"dark-current-{end}",
        title=f"Dark current from the {end}",
        caption=f"{what} against exposure time with its line, whose slope is the dark current.",
        curve="emva_dark_current",
        draw=draw,
        columns=(_EXPOSURE, (column, words, unit), (f"{column}_fitted", "line", unit)),
        missing=_NO_DARKS,
    )
    for end, what, draw, column, words, unit in (
        ("mean", "Mean dark value", plots_emva.dark_current_mean, "dark_mean", "mean dark value", "DN"),
        (
            "variance",
            "Temporal dark variance",
            plots_emva.dark_current_variance,
            "dark_variance",
            "dark variance",
            "DN^2",
        ),
    )
)


def _spectrograms(which: str, unit: str) -> Iterator[_Kind]:
    for direction in ("horizontal", "vertical"):
        yield _Kind(
            name=f"spectrogram-{which}-{direction}",
            title=f"Spectrogram {which.upper()}, {direction}",
            caption=(
                f"Root of the mean power spectrum of the high-passed image along its {_LINES[direction]}. Lines: "
                f"{which.upper()}, and the temporal noise of one frame (dashed)."
            ),
            curve=f"emva_spectrogram_{which}",
            draw=getattr(plots_emva_pattern, f"spectrogram_{which}_{direction}"),
            columns=(("frequency", "frequency", "1/pixel"), ("amplitude", "amplitude", unit)),
            direction=direction,
            missing=_NO_STACKS,
        )


_LINES: Final = {"horizontal": "rows", "vertical": "columns"}


def _profiles(which: str) -> Iterator[_Kind]:
    what = "averaged dark image" if which == "dsnu" else "averaged bright image less the averaged dark image"
    for direction in ("horizontal", "vertical"):
        yield _Kind(
            name=f"profile-{which}-{direction}",
            title=f"Profile {which.upper()}, {direction}",
            caption=f"Middle line, mean, maximum and minimum of the {what}; no high-pass.",
            curve=f"emva_profile_{which}",
            draw=getattr(plots_emva_pattern, f"profile_{which}_{direction}"),
            columns=(
                ("index", "index", ""),
                ("middle", "middle", "DN"),
                ("mean", "mean", "DN"),
                ("maximum", "max.", "DN"),
                ("minimum", "min.", "DN"),
            ),
            direction=direction,
            missing=_NO_STACKS,
        )


def _histogram(which: str) -> _Kind:
    return _Kind(
        name=f"histogram-{which}",
        title=f"Logarithmic histogram {which.upper()}",
        caption="Pixels per bin of the high-passed average against their deviation from the mean; dashed: normal.",
        curve=f"emva_histogram_{which}",
        draw=getattr(plots_emva_pattern, f"histogram_{which}"),
        columns=(("deviation", "deviation", "DN"), ("pixels", "pixels", ""), ("model", "normal", "")),
        missing=_NO_STACKS,
    )


def _accumulated(which: str) -> _Kind:
    return _Kind(
        name=f"accumulated-{which}",
        title=f"Accumulated histogram {which.upper()}",
        caption="Share of the pixels whose deviation from the mean lies in the bin of this centre, or beyond it.",
        curve=f"emva_accumulated_{which}",
        draw=getattr(plots_emva_pattern, f"accumulated_{which}"),
        columns=(("deviation", "deviation", "DN"), ("share", "share", "%"), ("pixels", "pixels", "")),
        missing=_NO_STACKS,
    )
