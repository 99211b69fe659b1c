"""Everything measured at one ISO, in the order one figure needs another."""

from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from functools import partial

from fullwell.fit.nonuniformity import Nonuniformity
from fullwell.frames.series import Study
from fullwell.units import Measured
from fullwell.workflow.executor import one_algebra_thread
from fullwell.workflow.measure.bursts import IsoBursts, with_code_steps, without_pixels
from fullwell.workflow.measure.dark_current import measure_dark_current
from fullwell.workflow.measure.dark_noise import measure_dark_noise
from fullwell.workflow.measure.dark_variance import measure_dark_variance
from fullwell.workflow.measure.dynamic_range import measure_range
from fullwell.workflow.measure.emva.measure import measure_emva, with_recommendations
from fullwell.workflow.measure.histograms import histogram_curves
from fullwell.workflow.measure.levels import ChannelLevels, measure_levels
from fullwell.workflow.measure.light import lit_flats, unlit_findings
from fullwell.workflow.measure.noise_coefficients import measure_noise_coefficients
from fullwell.workflow.measure.noise_regions import measure_noise_regions
from fullwell.workflow.measure.nonuniformity import ChannelPattern, look_at_maps, measure_nonuniformity
from fullwell.workflow.measure.other_units import rows_in_electrons, rows_in_volts
from fullwell.workflow.measure.pattern_maps import MADE_TOGETHER, IsoMaps, make_maps
from fullwell.workflow.measure.pattern_tiles import look_at_tiles, measure_pattern_tiles
from fullwell.workflow.measure.photon_transfer import ChannelTransfer, measure_photon_transfer
from fullwell.workflow.measure.processing import Processing, code_steps, code_uses, measure_processing
from fullwell.workflow.measure.read_noise import measure_read_noise
from fullwell.workflow.measure.second_reading import read_again
from fullwell.workflow.measure.section import RECOMMENDED, Section, joined
from fullwell.workflow.measure.shading import BurstShading, measure_shading
from fullwell.workflow.measure.steadiness import measure_steadiness
from fullwell.workflow.measure.unlit import usable_unlit
from fullwell.workflow.measure.white_level import WhiteLevel, measure_white


@dataclass(frozen=True, slots=True, kw_only=True)
class IsoMeasurement:
    """What was measured at one ISO, and what pictures, maps and comparisons between ISOs are made from.

    Parameters
    ----------
    bursts
        What could be used.
    levels
        Of every channel.
    section
        Rows, findings, curves.
    patterns
        Fixed pattern of every channel.
    shadings
        Every flat burst whose shading could be fitted, by ascending exposure.

    """

    bursts: IsoBursts
    levels: tuple[ChannelLevels, ...]
    section: Section
    patterns: tuple[ChannelPattern, ...]
    shadings: tuple[BurstShading, ...]


MapsMade = Callable[[IsoBursts, IsoMaps], None]
"""Told of the bursts of an ISO and some maps of its pixels, which are let go when it returns; once for each few."""


def without_sums(measured: IsoMeasurement) -> IsoMeasurement:
    """Return what was measured without the sums of its bursts and the errors of surfaces: comparisons need neither."""
    shadings = tuple(one.without_errors() for one in measured.shadings)
    return replace(measured, bursts=without_pixels(measured.bursts), shadings=shadings)


def measure_iso(
    study: Study,
    bursts: IsoBursts,
    *,
    workers: int,
    profiles: Sequence[str] = (),
    maps_made: MapsMade | None = None,
) -> IsoMeasurement:
    """Measure levels, noise, dark current, photon transfer, range, fixed pattern and shading at one ISO.

    Parameters
    ----------
    study, bursts
        What was taken.
    workers
        Threads; what is measured does not depend on their number.
    profiles
        Profiles of EMVA 1288 to evaluate by beside all that.
    maps_made
        Told of the maps of every pixel, some at a time.

    """
    whites = tuple(measure_white(study, bursts, index) for index in range(len(bursts.channels)))
    usable, unusable = usable_unlit(bursts, whites)
    usable, said_of_flats = lit_flats(usable)
    said = Section(findings=(*unusable, *said_of_flats, *unlit_findings(usable)))
    with one_algebra_thread(), ThreadPoolExecutor(1) as pool:
        every = replace(bursts, flats=usable.flats, black_clipped=usable.black_clipped)
        evaluate = partial(measure_emva, study, every, whites, profiles=profiles)
        beside = pool.submit(evaluate) if profiles and workers > 1 else None
        measurement, processing = _measured(study, usable, whites, workers, maps_made)
        parts = [said, measurement.section]
        if profiles:
            emva = evaluate() if beside is None else beside.result()
            rows = processing.marked(with_recommendations(measurement.section.rows, emva.rows))
            parts.append(replace(emva, rows=rows))
        return replace(measurement, section=joined(parts))


def _measured(
    study: Study, bursts: IsoBursts, whites: tuple[WhiteLevel, ...], workers: int, maps_made: MapsMade | None
) -> tuple[IsoMeasurement, Processing]:
    uses = code_uses(bursts)
    bursts = with_code_steps(bursts, code_steps(uses))
    again = read_again(bursts, whites, workers=workers)
    levels_section, levels = measure_levels(study, bursts, whites, masked=again.masked)
    noise_section = measure_read_noise(bursts)
    dark_section = measure_dark_current(bursts)
    transfer_section, transfers = measure_photon_transfer(bursts, levels)
    pattern_sections, patterns = _fixed_pattern(study, bursts, levels, transfers, workers=workers, maps_made=maps_made)
    black = next(
        (row.measured for row in levels_section.rows if (row.quantity, row.channel) == ("black_level", "all")), None
    )
    model_section, models = measure_noise_coefficients(bursts, levels, transfers, patterns, black=black)
    shading_section, shadings = measure_shading(
        bursts, levels, transfers, patterns, camera=study.camera, workers=workers
    )
    system_gain = {
        row.channel: row.measured
        for row in transfer_section.rows
        if row.quantity == "system_gain" and RECOMMENDED in row.flags
    }
    processing = measure_processing(bursts, uses, again, transfers)
    in_dn = (*noise_section.rows, *dark_section.rows, *pattern_sections[0].rows)
    section = joined(
        (
            levels_section,
            noise_section,
            measure_noise_regions(bursts),
            dark_section,
            transfer_section,
            model_section,
            *pattern_sections,
            rows_in_electrons(in_dn, transfer_section.rows),
            rows_in_volts(in_dn, levels, study.camera.voltage_swing_v),
            measure_dark_variance(bursts, system_gain),
            measure_dark_noise(bursts, (*in_dn, *transfer_section.rows)),
            measure_range(bursts, levels, transfers, models),
            shading_section,
            measure_steadiness(bursts, levels, transfers),
            histogram_curves(bursts),
            processing.section,
        )
    )
    section = replace(section, rows=processing.marked(section.rows))
    measurement = IsoMeasurement(bursts=bursts, levels=levels, section=section, patterns=patterns, shadings=shadings)
    return measurement, processing


def _fixed_pattern(
    study: Study,
    bursts: IsoBursts,
    levels: Sequence[ChannelLevels],
    transfers: Sequence[ChannelTransfer],
    *,
    workers: int,
    maps_made: MapsMade | None,
) -> tuple[tuple[Section, ...], tuple[ChannelPattern, ...]]:
    """Measure all that maps of every pixel are made for, a few maps at a time."""
    size = {"width": study.width, "height": study.height}
    whole: dict[tuple[str, str], Nonuniformity | None] = {}
    tiles: dict[tuple[str, str], tuple[Measured, ...] | None] = {}
    told = IsoMaps(channels=(), mosaics={})
    for names in MADE_TOGETHER:
        maps = make_maps(bursts, levels, transfers, names=names, workers=workers)
        whole |= look_at_maps(maps)
        tiles |= look_at_tiles(maps, cell=bursts.cell, **size)
        if maps_made is not None:
            maps_made(bursts, maps)
        told = maps.without_pixels()
        del maps
    section, patterns = measure_nonuniformity(bursts, told, whole)
    return (section, measure_pattern_tiles(bursts, told, tiles, **size)), patterns
