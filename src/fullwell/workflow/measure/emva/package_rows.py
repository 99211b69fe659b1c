"""Rows of the ``emva1288`` package: its own figures, without uncertainties."""

import math

import numpy as np

from fullwell.figures.emva1288.package import PackageFigures, evaluate
from fullwell.figures.emva1288.sweep import Sweep
from fullwell.figures.results import Row
from fullwell.units import Measured
from fullwell.workflow.measure.bursts import IsoBursts
from fullwell.workflow.measure.emva.writer import PACKAGE, ChannelWriter


def why_not(sweep: Sweep) -> str | None:
    """Return why the package would refuse a sweep, None where it would not."""
    if sweep.photons is None:
        return "it needs the photons of every step"
    if not sweep.dark_measured.all():
        return "it needs a dark pair at every exposure"
    exposures = np.unique(sweep.exposure_s).size
    if exposures not in {1, sweep.steps}:
        return "it takes one exposure with many lights, or one light at each exposure"
    return None


def evaluate_package(sweep: Sweep) -> PackageFigures | None:
    """Return the package's figures, None where it would refuse the sweep."""
    return None if why_not(sweep) else evaluate(sweep)


def package_rows(
    bursts: IsoBursts, channel: str, sweep: Sweep, found: PackageFigures, *, area_um2: float | None
) -> tuple[Row, ...]:
    """Return every row of one channel that rests on the sweep."""
    writer = ChannelWriter(bursts=bursts, channel=channel, method=PACKAGE, source="EMVA1288-PY")

    def add(quantity: str, value: float | None, unit: str, *, snr: float | None = None) -> None:
        if value is not None:
            writer.add(quantity, Measured.exact(value, unit), equation="results", n=2 * sweep.n, snr=snr)

    gain, efficiency = found.system_gain, found.quantum_efficiency
    threshold_e, saturation_p = found.threshold_e, found.saturation_photons
    saturation_e = efficiency * saturation_p
    snr_max, dynamic_range = math.sqrt(max(saturation_e, 0.0)), saturation_p / (threshold_e / efficiency)
    add("quantum_efficiency", 100.0 * efficiency, "%")
    add("responsivity", found.responsivity, "DN/p")
    add("system_gain", gain, "DN/e-")
    add("conversion_factor", 1.0 / gain, "e-/DN")
    add("dark_noise", math.sqrt(found.dark_variance), "DN")
    add("dark_noise", found.dark_noise_e, "e-")
    add("sensitivity_threshold", threshold_e, "e-", snr=1.0)
    add("sensitivity_threshold", threshold_e / efficiency, "p", snr=1.0)
    add("saturation_capacity", saturation_e, "e-")
    add("saturation_capacity", saturation_p, "p")
    if area_um2 is not None:
        add("sensitivity_threshold_per_area", threshold_e / area_um2, "e-/um^2", snr=1.0)
        add("sensitivity_threshold_per_area", threshold_e / efficiency / area_um2, "p/um^2", snr=1.0)
        add("saturation_capacity_per_area", saturation_e / area_um2, "e-/um^2")
        add("saturation_capacity_per_area", saturation_p / area_um2, "p/um^2")
    if snr_max > 0.0 and dynamic_range > 0.0:
        add("snr_max", snr_max, "1")
        add("snr_max", 20.0 * math.log10(snr_max), "dB")
        add("snr_max", math.log2(snr_max), "bit")
        add("inverse_snr_max", 100.0 / snr_max, "%")
        add("dynamic_range", dynamic_range, "1", snr=1.0)
        add("dynamic_range", 20.0 * math.log10(dynamic_range), "dB", snr=1.0)
    add("linearity_error_min", found.linearity_min, "%")
    add("linearity_error_max", found.linearity_max, "%")
    add("linearity_offset", found.linearity_offset, "DN")
    add("linearity_slope", found.linearity_slope, "DN/p")
    if found.dark_mean_slope is not None:
        add("dark_current", found.dark_mean_slope, "DN/s")
        add("dark_current", found.dark_mean_slope / gain, "e-/s")
    if found.dark_variance_slope is not None and found.dark_variance_slope >= 0.0:
        add("dark_current_from_variance", found.dark_variance_slope / gain, "DN/s")
        add("dark_current_from_variance", found.dark_variance_slope / gain**2, "e-/s")
    return tuple(writer.rows)
