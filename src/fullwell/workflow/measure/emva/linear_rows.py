"""Rows of sensitivity, range, linearity and dark current by Release 4.0 Linear."""

import math
from collections.abc import Callable, Iterator

import numpy as np

from fullwell.figures.emva1288.sensitivity import QUANTIZATION, threshold_at, threshold_electrons
from fullwell.figures.emva1288.sweep import Floats
from fullwell.figures.results import Row
from fullwell.glossary import SNR_THRESHOLDS
from fullwell.units import PERCENT, Measured
from fullwell.workflow.measure.bursts import IsoBursts
from fullwell.workflow.measure.emva.linear import LinearFits
from fullwell.workflow.measure.emva.writer import LINEAR, ChannelWriter, derived

_SATURATION_FLAGS = {
    "interpolated": ("interpolated",),
    "bracketed": ("interpolated",),
    "peak": ("lower-bound",),
    "unreached": ("lower-bound",),
}


def linear_rows(
    bursts: IsoBursts, channel: str, fits: LinearFits, *, area_um2: float | None, nominal: bool
) -> tuple[Row, ...]:
    """Return every row of one channel that rests on the sweep and the darks."""
    writer = ChannelWriter(bursts=bursts, channel=channel, method=LINEAR)
    marks = _Marks(fits, nominal=nominal)
    _sensitivity(writer, fits, marks)
    _thresholds(writer, fits, marks, area_um2=area_um2)
    _saturation(writer, fits, marks, area_um2=area_um2)
    _linearity(writer, fits, marks)
    _dark_current(writer, fits)
    return tuple(writer.rows)


class _Marks:
    """Flags by what a figure rests on."""

    def __init__(self, fits: LinearFits, *, nominal: bool) -> None:
        gain = fits.system_gain
        self.gain = ("model-misfit",) if gain is not None and gain.misfit else ()
        self.photons = ("nominal",) if nominal and fits.by_photons else ()
        self.noise = ("quantization-limited", "upper-limit") if fits.floored else ()
        self.saturation = _SATURATION_FLAGS.get(fits.saturation.mode, ())
        self.dark = () if fits.sweep.dark_measured.all() else ("dark-line",)


def _gain(fits: LinearFits) -> Measured | None:
    return None if fits.system_gain is None else fits.system_gain.measured


def _responsivity(fits: LinearFits) -> Measured | None:
    return fits.response if fits.by_photons else None


def _sensitivity(writer: ChannelWriter, fits: LinearFits, marks: _Marks) -> None:
    gain, n = fits.system_gain, 2 * fits.sweep.n * int(fits.in_range.sum())
    responsivity = _responsivity(fits)
    writer.add(
        "quantum_efficiency",
        derived(lambda v: 100.0 * v[0] / v[1], responsivity, _gain(fits), unit=PERCENT),
        equation="(52)",
        n=n,
        flags=(*marks.gain, *marks.photons, *marks.dark),
    )
    writer.add("responsivity", responsivity, equation="(49)", n=n, flags=(*marks.photons, *marks.dark))
    if gain is not None:
        flags = (*marks.gain, *marks.dark)
        writer.add("system_gain", gain.measured, equation="(50)", n=n, flags=flags)
        inverse = derived(lambda v: 1.0 / v[0], gain.measured, unit="e-/DN")
        writer.add("conversion_factor", inverse, equation="10.1", n=n, flags=flags)
        offset = Measured.normal(gain.line.offset, gain.offset_error, "DN^2")
        writer.add("photon_transfer_offset", offset, equation="(50)", n=n, flags=flags)
        if gain.line.slope_error is not None:
            error = Measured.exact(100.0 * gain.line.slope_error / gain.line.slope, PERCENT)
            writer.add("system_gain_regression_error", error, equation="10.2", n=n, flags=flags)
    if fits.gate is not None:
        deviation = Measured.normal(100.0 * fits.gate.deviation, 100.0 * fits.gate.error, PERCENT)
        writer.add("system_gain_deviation", deviation, equation="(51)", n=n, flags=marks.dark)
        floor = Measured.exact(100.0 * fits.gate.floor, PERCENT)
        writer.add("system_gain_deviation_floor", floor, equation="3", n=n)


def _thresholds(writer: ChannelWriter, fits: LinearFits, marks: _Marks, *, area_um2: float | None) -> None:
    lowest, gain = fits.darks.lowest, _gain(fits)
    n = 2 * lowest.n
    mean = Measured.normal(lowest.mean, math.sqrt(max(lowest.temporal_variance, 0.0) / n), "DN")
    writer.add("dark_signal", mean, equation="(16)", n=n)
    _dark_noise(writer, fits, marks)
    responsivity = _responsivity(fits)
    noise_flags = (*marks.noise, *marks.gain)
    for snr in SNR_THRESHOLDS:
        function = _threshold(snr)
        electrons = _at_most(derived(function, fits.dark_variance, gain, unit="e-"), limited=fits.floored)
        photons = derived(_in_photons(snr), fits.dark_variance, gain, responsivity, unit="p")
        photons = _at_most(photons, limited=fits.floored)
        for found, extra in ((electrons, ()), (photons, marks.photons)):
            writer.add(
                "sensitivity_threshold", found, equation="(25) (26) (27)", n=n, flags=(*noise_flags, *extra), snr=snr
            )
            if found is not None and area_um2 is not None and snr == SNR_THRESHOLDS[0]:
                writer.add(
                    "sensitivity_threshold_per_area",
                    found.scaled(1.0 / area_um2, f"{found.unit}/um^2"),
                    equation="10.1",
                    n=n,
                    flags=(*noise_flags, *extra),
                    snr=snr,
                )


def _threshold(snr: float) -> Callable[[Floats], float]:
    """Return the formula of the threshold [e-] from dark variance and system gain."""
    if snr == 1.0:
        return threshold_electrons
    return lambda v: threshold_at(snr, v[0], v[1])


def _in_photons(snr: float) -> Callable[[Floats], float]:
    """Return the formula of the threshold [p] from dark variance, system gain and responsivity."""
    electrons = _threshold(snr)
    return lambda v: electrons(v) * v[1] / v[2]


def _dark_noise(writer: ChannelWriter, fits: LinearFits, marks: _Marks) -> None:
    """Add the dark noise in DN with quantization, and in electrons without."""
    n, gain = 2 * fits.darks.lowest.n, _gain(fits)
    variance = fits.dark_variance
    if fits.floored:
        limit = math.sqrt(variance.value)
        writer.add("dark_noise", _limit(limit, "DN"), equation="(54)", n=n, flags=marks.noise)
        if gain is not None:
            electrons = math.sqrt(variance.value - QUANTIZATION) / gain.value
            flags = (*marks.noise, *marks.gain)
            writer.add("dark_noise", _limit(electrons, "e-"), equation="(54)", n=n, flags=flags)
        measured = Measured.normal(
            fits.darks.lowest.temporal_variance,
            fits.darks.lowest.temporal_variance * math.sqrt(2.0 / fits.darks.lowest.n),
            "DN^2",
        )
        writer.add("dark_noise_variance", measured, equation="(18)", n=n, flags=("quantization-limited",))
        in_electrons = derived(lambda v: (v[0] - QUANTIZATION) / v[1] ** 2, measured, gain, unit="e-^2")
        flags = ("quantization-limited", *marks.gain)
        writer.add("dark_noise_variance", in_electrons, equation="(53)", n=n, flags=flags)
        return
    writer.add_root("dark_noise", variance, "DN", equation="(53)", n=n)
    electrons2 = derived(lambda v: (v[0] - QUANTIZATION) / v[1] ** 2, variance, gain, unit="e-^2")
    if electrons2 is not None:
        writer.add_root("dark_noise", electrons2, "e-", equation="(53)", n=n, flags=marks.gain)


def _at_most(found: Measured | None, *, limited: bool) -> Measured | None:
    """Return what rests on the limit of the dark noise as a limit itself."""
    if found is None or not limited:
        return found
    return Measured.interval(found.value, None, (0.0, found.value if found.ci95 is None else found.ci95[1]), found.unit)


def _limit(value: float, unit: str) -> Measured:
    return Measured.interval(value, None, (0.0, value), unit)


def _saturation(writer: ChannelWriter, fits: LinearFits, marks: _Marks, *, area_um2: float | None) -> None:
    n, gain, response = 2 * fits.sweep.n, _gain(fits), fits.response
    where, flags = fits.saturation_exposure, marks.saturation
    writer.add("saturation_level", fits.saturation_level, equation="3.1", n=n, flags=flags)
    if not fits.by_photons and where is not None:
        writer.add("saturation_exposure", where, equation="3.1", n=n, flags=flags)
    photons = where if fits.by_photons else None
    electrons = derived(lambda v: v[0] * v[1] / v[2], where, response, gain, unit="e-")
    in_electrons = (*flags, *marks.gain, *marks.dark)
    for found, own in ((electrons, in_electrons), (photons, (*flags, *marks.photons))):
        writer.add("saturation_capacity", found, equation="(24)", n=n, flags=own)
        if found is not None and area_um2 is not None:
            per_area = found.scaled(1.0 / area_um2, f"{found.unit}/um^2")
            writer.add("saturation_capacity_per_area", per_area, equation="10.1", n=n, flags=own)
    if electrons is None or electrons.value <= 0.0:
        return
    writer.add(
        "snr_max", derived(lambda v: math.sqrt(v[0]), electrons, unit="1"), equation="(55)", n=n, flags=in_electrons
    )
    decibel = derived(lambda v: 10.0 * math.log10(v[0]), electrons, unit="dB")
    writer.add("snr_max", decibel, equation="(55)", n=n, flags=in_electrons)
    percent = derived(lambda v: 100.0 / math.sqrt(v[0]), electrons, unit=PERCENT)
    inverse = tuple("upper-limit" if flag == "lower-bound" else flag for flag in in_electrons)
    if "upper-limit" in inverse and percent is not None:
        percent = _limit(percent.value, PERCENT)
    writer.add("inverse_snr_max", percent, equation="(55)", n=n, flags=inverse)
    bound = {"lower-bound"} if fits.floored else set[str]()
    range_flags = tuple({*in_electrons, *(("quantization-limited",) if fits.floored else ()), *bound})
    ingredients = (where, response, gain, fits.dark_variance)
    ratio = derived(lambda v: v[0] * v[1] / v[2] / threshold_electrons((v[3], v[2])), *ingredients, unit="1")
    writer.add("dynamic_range", ratio, equation="(28)", n=n, flags=range_flags, snr=1.0)
    if ratio is not None:
        decibels = derived(lambda v: 20.0 * math.log10(v[0]), ratio, unit="dB")
        writer.add("dynamic_range", decibels, equation="(28)", n=n, flags=range_flags, snr=1.0)


def _linearity(writer: ChannelWriter, fits: LinearFits, marks: _Marks) -> None:
    line = fits.linearity
    if line is None:
        return
    n = 2 * fits.sweep.n * line.deviation.size
    error, floor, spread = line.error, line.floor, line.error_error
    hidden = error < floor + 2.0 * spread
    upper = error + 2.0 * spread
    limited = Measured.interval(error, None, (0.0, upper), PERCENT)
    measured = limited if hidden else Measured.normal(error, spread, PERCENT)
    flags = ("upper-limit", *marks.dark) if hidden else marks.dark
    writer.add("linearity_error", measured, equation="(63)", n=n, flags=flags)
    writer.add("linearity_error_floor", Measured.exact(floor, PERCENT), equation="4", n=n)
    for name, place in (("min", int(np.argmin(line.deviation))), ("max", int(np.argmax(line.deviation)))):
        found = Measured.normal(line.deviation[place], line.deviation_error[place], PERCENT)
        writer.add(f"linearity_error_{name}", found, equation="(62)", n=n, flags=marks.dark)
    unit = "DN/p" if fits.by_photons else "DN/s"
    offset = Measured.normal(line.offset, line.offset_error, "DN")
    writer.add("linearity_offset", offset, equation="(60)", n=n, flags=marks.dark)
    slope = Measured.normal(line.slope, line.slope_error, unit)
    writer.add("linearity_slope", slope, equation="(61)", n=n, flags=(*marks.dark, *marks.photons))


def _dark_current(writer: ChannelWriter, fits: LinearFits) -> None:
    """Add the dark current from mean and from variance, with the standard deviation of the regression and its sign."""
    lines, gain = fits.darks.lines, _gain(fits)
    if lines is None:
        return
    n = 2 * fits.darks.lowest.n * fits.darks.exposure_s.size
    for name, line, unit, power in (
        ("dark_current", lines[0], "DN/s", 1),
        ("dark_current_from_variance", lines[1], "DN^2/s", 2),
    ):
        slope = (
            Measured.exact(line.slope, unit)
            if line.slope_error is None
            else Measured.student(line.slope, line.slope_error, line.dof, unit)
        )
        writer.add(name, slope, equation="(29) (30)", n=n)
        in_electrons = derived(_over(power), slope, gain, unit="e-/s")
        writer.add(name, in_electrons, equation="(29) (30)", n=n)


def _over(power: int) -> Callable[[Floats], float]:
    return lambda v: v[0] / v[1] ** power


def missing(fits: LinearFits) -> Iterator[str]:
    """Say what could not be given, and why."""
    if fits.system_gain is None:
        yield "system gain and all figures in electrons: fewer than three steps up to 70 % of saturation, or no slope"
    if fits.linearity is None:
        yield "linearity error: fewer than two steps between 5 and 95 % of saturation, or no exposure to plot against"
    if fits.gate is None:
        yield "the test whether one system gain describes the camera: fewer than 12 steps up to saturation, better 50"
    if fits.darks.lines is None:
        yield "dark current: darks at one exposure only"
