"""Histograms as curves for the report."""

from collections.abc import Iterable

import numpy as np

from fullwell.figures.results import Column, Curve
from fullwell.units import DN
from fullwell.workflow.measure.bursts import Burst, IsoBursts
from fullwell.workflow.measure.read_noise import choose_burst
from fullwell.workflow.measure.section import Section

MAX_BINS = 512


def histogram_curves(bursts: IsoBursts) -> Section:
    """Return the histogram of the burst read noise was measured on, and those of the flats."""
    unlit = choose_burst(bursts) or next(iter(bursts.unlit), None)
    curves: list[Curve] = []
    if unlit is not None:
        curves.append(_curve("dark_histogram", bursts, [unlit]))
    if bursts.flats:
        curves.append(_curve("flat_histogram", bursts, bursts.flats))
    return Section(curves=tuple(curves))


def _curve(name: str, bursts: IsoBursts, chosen: Iterable[Burst]) -> Curve:
    rows: list[tuple[str, float, int, int]] = []
    for burst in chosen:
        for plane in burst.statistics.planes:
            counts = plane.histogram.counts
            step = -(-len(counts) // MAX_BINS)
            binned = np.add.reduceat(counts, np.arange(0, len(counts), step))
            rows += [
                (plane.channel, burst.exposure_s, plane.histogram.first_code + index * step, int(count))
                for index, count in enumerate(binned)
            ]
    channels, exposures, codes, counted = zip(*rows, strict=True)
    return Curve(
        name=name,
        columns=(
            Column(name="iso", unit="1", values=(bursts.iso,) * len(rows)),
            Column(name="channel", unit="", values=channels),
            Column(name="exposure_s", unit="s", values=exposures),
            Column(name="code", unit=DN, values=codes),
            Column(name="count", unit="1", values=counted),
        ),
    )
