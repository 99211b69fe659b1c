"""Every figure against ISO: read noise split into what lies before and after the amplifier (METHOD 3.7)."""

import math
from collections.abc import Iterable, Sequence

import numpy as np

from fullwell.figures.results import Column, Curve, Row
from fullwell.fit.amplification import AmplifierNoise, fit_amplifier_noise
from fullwell.frames.series import Study
from fullwell.glossary import RECOMMENDED
from fullwell.units import DN, DN2, ELECTRON
from fullwell.workflow.measure.bursts import IsoBursts
from fullwell.workflow.measure.section import RowWriter, Section, joined


def measure_against_iso(study: Study, groups: Sequence[IsoBursts], rows: Iterable[Row]) -> Section:
    """Fit read noise against amplification for every channel measured at three ISOs or more."""
    recommended = [row for row in rows if RECOMMENDED in row.flags and row.iso is not None]
    channels = dict.fromkeys(channel for group in groups for channel in group.channels)
    return joined(_channel(study, channel, recommended) for channel in channels)


def _of(rows: Iterable[Row], quantity: str, channel: str, unit: str) -> dict[float, Row]:
    return {
        row.iso: row
        for row in rows
        if row.iso is not None and (row.quantity, row.channel, row.measured.unit) == (quantity, channel, unit)
    }


def _channel(study: Study, channel: str, rows: Sequence[Row]) -> Section:
    variances = _of(rows, "read_noise_variance", channel, DN2)
    noises = _of(rows, "read_noise", channel, DN)
    electrons = _of(rows, "read_noise", channel, ELECTRON)
    isos = sorted(variances)
    if len(isos) < 2:
        return Section()
    base = study.camera.base_iso or isos[0]
    amplification = np.array(isos) / base
    values = np.array([variances[iso].measured.value for iso in isos])
    errors = np.array([variances[iso].measured.std_error or np.nan for iso in isos])
    fitted: list[float | None] = [None] * len(isos)
    split: tuple[Row, ...] = ()
    if len(isos) >= 3 and bool(np.all(values > 0.0)) and bool(np.all(np.isfinite(errors))):
        fit = fit_amplifier_noise(amplification, values, 2.0 * (values / errors) ** 2, quantization_step=0.0)
        fitted = [
            math.sqrt(max(fit.pre_variance.value * one**2 + fit.post_variance.value, 0.0)) for one in amplification
        ]
        split = _split_rows(channel, fit)
    curve = Curve(
        name="read_noise_iso",
        columns=(
            Column(name="iso", unit="1", values=tuple(isos)),
            Column(name="channel", unit="", values=(channel,) * len(isos)),
            Column(name="read_noise", unit=DN, values=tuple(noises[iso].measured.value for iso in isos)),
            Column(name="std_error", unit=DN, values=tuple(noises[iso].measured.std_error for iso in isos)),
            Column(name="fitted", unit=DN, values=tuple(fitted)),
            Column(
                name="read_noise_e",
                unit=ELECTRON,
                values=tuple(electrons[iso].measured.value if iso in electrons else None for iso in isos),
            ),
        ),
    )
    return Section(rows=split, curves=(curve,))


def _split_rows(channel: str, fit: AmplifierNoise) -> tuple[Row, ...]:
    flags = ("model-misfit",) if fit.misfit else ()
    write = RowWriter(bursts=None).root_and_variance
    parts = (("read_noise_pre", fit.pre_variance), ("read_noise_post", fit.post_variance))
    return tuple(
        row
        for quantity, variance in parts
        for row in write(quantity, channel, "amplification-fit", variance, DN, source="METHOD 3.7", flags=flags)
    )
