"""What the report shows of the loop, as curves.

``loop_figures``
    Every figure whose truth is known: original, truth, what the first camera came to, and what all of them tell.
``loop_pulls``
    Pulls of the recommended figures over all cameras, in order, with the probability that each belongs to.
``loop_transfer``
    Variance against signal: of the original, of the first simulated camera, and true.
"""

from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Final

import numpy as np
from numpy.typing import NDArray

from fullwell import glossary
from fullwell.figures.calibration import Calibration
from fullwell.figures.results import Column, Curve
from fullwell.raw.cfa import ALL, MONO, channels
from fullwell.simulate.config import SimulationConfig
from fullwell.units import DN, DN2, Measured
from fullwell.workflow.loop.camera import Turn
from fullwell.workflow.loop.comparison import Comparison, Figure, figure_of
from fullwell.workflow.loop.source import Source
from fullwell.workflow.loop.tally import Tally

Value = float | int | str | None
Record = Mapping[str, Value]

MOST_PULLS: Final = 400
"""Pulls of one quantity that are kept for the report; of more, as many in even steps of probability."""
_CURVES: Final = ("photon_transfer", "chart_points")
_REPEATS: Final[tuple[tuple[str, Callable[[Calibration], Value]], ...]] = (
    ("cameras", lambda one: one.trials),
    ("bounds", lambda one: one.bounds),
    ("mean", lambda one: one.mean),
    ("bias", lambda one: one.bias),
    ("bias_std_error", lambda one: one.bias_std_error),
    ("sd", lambda one: one.sd),
    ("rms_std_error", lambda one: one.std_error),
    ("scatter_ratio", lambda one: one.scatter_ratio),
    ("intervals", lambda one: one.intervals),
    ("covering", lambda one: one.covering),
    ("coverage", lambda one: one.coverage),
    ("coverage_low", lambda one: one.coverage_low),
    ("coverage_high", lambda one: one.coverage_high),
    ("coverage_p", lambda one: one.coverage_p),
    ("pulls", lambda one: one.pulls),
    ("pull_mean", lambda one: one.pull_mean),
    ("pull_sd", lambda one: one.pull_sd),
    ("pull_p", lambda one: one.pull_p),
)


def figure_records(
    compared: Iterable[Comparison], originals: Mapping[Figure, Measured], found: Mapping[Figure, Calibration]
) -> list[Record]:
    """Return every compared figure as plain values by name."""
    return [_record(one, originals.get(one.figure), found[one.figure]) for one in compared]


def originals_of(source: Source) -> Mapping[Figure, Measured]:
    """Return what was measured of the source, by figure; the whole plane's alone."""
    return {figure_of(row): row.measured for row in source.rows if row.region is None}


def _record(one: Comparison, original: Measured | None, found: Calibration) -> Record:
    row, measured = one.row, one.row.measured
    low, high = measured.ci95 or (None, None)
    return {
        "quantity": row.quantity,
        "channel": row.channel,
        "method": row.method,
        "unit": measured.unit,
        "iso": row.iso,
        "snr_threshold": row.snr_threshold,
        "exposure_s": row.exposure_s,
        "temperature_c": row.temperature_c,
        "recommended": "yes" if one.recommended else "no",
        "flags": ";".join(row.flags),
        "original": None if original is None else original.value,
        "original_std_error": None if original is None else original.std_error,
        "truth": one.truth,
        "value": measured.value,
        "std_error": measured.std_error,
        "dof": measured.dof,
        "ci95_low": low,
        "ci95_high": high,
        "pull": one.pull,
        **{name: read(found) for name, read in _REPEATS},
    }


def loop_curves(
    records: Sequence[Record], first: Turn, tally: Tally, source: Source, config: SimulationConfig
) -> tuple[Curve, ...]:
    """Return every curve of the loop that has points.

    Parameters
    ----------
    records
        From `figure_records`.
    first
        The first camera.
    tally
        What all of them came to.
    source
        Where the loop started.
    config
        What was simulated.

    """
    transfer = _transfer(source, config, first.measurement.results.curves)
    made = (
        _curve("loop_figures", records),
        _curve("loop_pulls", _pulls(first.compared, tally)),
        _curve("loop_transfer", transfer, units={"signal": DN, "variance": DN2}),
    )
    return tuple(curve for curve in made if curve.columns)


def _curve(name: str, records: Sequence[Record], units: Mapping[str, str] | None = None) -> Curve:
    names = tuple(records[0]) if records else ()
    return Curve(
        name=name,
        columns=tuple(
            Column(name=title, unit=(units or {}).get(title, ""), values=tuple(one[title] for one in records))
            for title in names
        ),
    )


def _pulls(compared: Sequence[Comparison], tally: Tally) -> list[Record]:
    """Return pulls by quantity, of the channels by themselves: what they share is no further evidence."""
    groups: dict[str, list[NDArray[np.float64]]] = {}
    several = any(one.row.channel not in {ALL, MONO} for one in compared)
    for one in compared:
        entry = glossary.quantity(one.row.quantity)
        native = entry is not None and one.row.measured.unit == entry.units[0] and one.row.exposure_s is None
        counted = one.recommended and native
        if counted and not (several and one.row.channel == ALL):
            groups.setdefault(one.row.quantity, []).append(tally.pulls(one.figure))
    lines: list[Record] = []
    for quantity, parts in groups.items():
        pulls = np.sort(np.concatenate(parts))
        shown = pulls if pulls.size <= MOST_PULLS else np.quantile(pulls, (np.arange(MOST_PULLS) + 0.5) / MOST_PULLS)
        lines += [
            {"quantity": quantity, "probability": (at + 0.5) / shown.size, "pull": float(pull), "of": int(pulls.size)}
            for at, pull in enumerate(shown)
        ]
    return lines


def _transfer(source: Source, config: SimulationConfig, simulated: Sequence[Curve]) -> list[Record]:
    lines: list[Record] = []
    for name in _CURVES:
        own = _points(simulated, name, "simulated")
        if own:
            lines += _points(source.curves, name, "original") + own
            lines += _true_lines(config, own, single_frame=name == "chart_points", measurement=name)
    return lines


def _points(curves: Sequence[Curve], name: str, whose: str) -> list[Record]:
    """Return the points of one kind of photon transfer that took part in the fit."""
    lines: list[Record] = []
    for curve in (one for one in curves if one.name == name):
        columns = (curve.column(title) for title in ("iso", "channel", "signal", "variance", "used"))
        for iso, channel, signal, variance, used in zip(*columns, strict=True):
            if used == "yes" and isinstance(signal, (int, float)) and signal > 0.0:
                lines.append(
                    {
                        "measurement": name,
                        "whose": whose,
                        "iso": iso,
                        "channel": channel,
                        "signal": signal,
                        "variance": variance,
                    }
                )
    return lines


def _true_lines(
    config: SimulationConfig, points: Sequence[Record], *, single_frame: bool, measurement: str
) -> list[Record]:
    """Return the true variance against signal at every ISO of the points: that of time, or of a single frame."""
    lines: list[Record] = []
    for iso in dict.fromkeys(one["iso"] for one in points):
        if not isinstance(iso, (int, float)):
            continue
        sensor = config.sensor_at(iso)
        system_gain = sensor.system_gain_at(iso)
        own = [float(one["signal"]) for one in points if one["iso"] == iso and isinstance(one["signal"], (int, float))]
        signal = np.geomspace(min(own), max(own), 64)
        offsets = sensor.dsnu**2 + sensor.dsnu_row**2 + sensor.dsnu_column**2
        responses = sensor.prnu**2 + sensor.prnu_row**2 + sensor.prnu_column**2
        dark = sensor.dark_noise_at(iso, 0.0, of_frames=False) ** 2 + offsets * single_frame
        variance = dark * system_gain**2 + 1.0 / 12.0 + system_gain * signal + responses * signal**2 * single_frame
        for at, value in zip(signal.tolist(), variance.tolist(), strict=True):
            lines.append(
                {
                    "measurement": measurement,
                    "whose": "truth",
                    "iso": iso,
                    "channel": ALL if len(channels(config.sensor.cfa)) > 1 else MONO,
                    "signal": at,
                    "variance": value,
                }
            )
    return lines
