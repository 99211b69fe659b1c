"""Everything measured at one ISO, in the order one figure needs another."""

from fullwell.frames.series import Study
from fullwell.workflow.measure.bursts import IsoBursts
from fullwell.workflow.measure.dark_current import measure_dark_current
from fullwell.workflow.measure.dark_noise import measure_dark_noise
from fullwell.workflow.measure.dark_variance import measure_dark_variance
from fullwell.workflow.measure.dynamic_range import measure_range
from fullwell.workflow.measure.histograms import histogram_curves
from fullwell.workflow.measure.levels import measure_levels
from fullwell.workflow.measure.noise_coefficients import measure_noise_coefficients
from fullwell.workflow.measure.other_units import rows_in_electrons, rows_in_volts
from fullwell.workflow.measure.photon_transfer import measure_photon_transfer
from fullwell.workflow.measure.read_noise import measure_read_noise
from fullwell.workflow.measure.section import RECOMMENDED, Section, joined
from fullwell.workflow.measure.steadiness import measure_steadiness
from fullwell.workflow.measure.unlit import usable_unlit
from fullwell.workflow.measure.white_level import measure_white


def measure_iso(study: Study, bursts: IsoBursts) -> Section:
    """Measure levels, noise, dark current, photon transfer and range at one ISO, in DN, electrons and volts."""
    whites = tuple(measure_white(study, bursts, index) for index in range(len(bursts.channels)))
    bursts, unlit_findings = usable_unlit(bursts, whites)
    levels_section, levels = measure_levels(study, bursts, whites)
    noise_section = measure_read_noise(bursts)
    dark_section = measure_dark_current(bursts)
    transfer_section, transfers = measure_photon_transfer(bursts, levels)
    model_section, models = measure_noise_coefficients(bursts, levels, transfers)
    system_gain = {
        row.channel: row.measured
        for row in transfer_section.rows
        if row.quantity == "system_gain" and RECOMMENDED in row.flags
    }
    in_dn = (*noise_section.rows, *dark_section.rows)
    return joined(
        (
            Section(findings=unlit_findings),
            levels_section,
            noise_section,
            dark_section,
            transfer_section,
            model_section,
            rows_in_electrons(in_dn, transfer_section.rows),
            rows_in_volts(in_dn, levels, study.camera.voltage_swing_v),
            measure_dark_variance(bursts, system_gain),
            measure_dark_noise(bursts, (*in_dn, *transfer_section.rows)),
            measure_range(bursts, levels, transfers, models),
            measure_steadiness(bursts, levels, transfers),
            histogram_curves(bursts),
        )
    )
