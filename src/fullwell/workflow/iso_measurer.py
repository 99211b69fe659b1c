"""ISOs are measured one after the other, and what was measured of each is kept without its pixels.

This is most of the program by size; `isos` loads it while the first frames are read.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from fullwell.frames.series import Study
from fullwell.report.pictures import Pictures, ResponsePicture
from fullwell.workflow.iso_maps import write_response_maps, write_shading_maps
from fullwell.workflow.measure.bursts import IsoBursts, without_pixels
from fullwell.workflow.measure.iso import IsoMeasurement, measure_iso, without_sums
from fullwell.workflow.measure.pattern_maps import IsoMaps
from fullwell.workflow.measure.section import Section
from fullwell.workflow.measure.temperatures import measure_temperatures
from fullwell.workflow.options import Options
from fullwell.workflow.pattern_pictures import response_pictures
from fullwell.workflow.pictures import take_pictures
from fullwell.workflow.published.study import PublishedMeasurement
from fullwell.workflow.reduce import Reduction


@dataclass(frozen=True, slots=True, kw_only=True)
class IsoOutcome:
    """What one ISO came to, without its pixels.

    Parameters
    ----------
    bursts
        All that was taken.
    measured
        What was measured at its main temperature.
    temperatures
        What was measured at others.
    pictures
        Of two unlit frames, at the first ISO that has such.
    responses
        Of the slopes of its pixels.

    """

    bursts: IsoBursts
    measured: IsoMeasurement
    temperatures: Section
    pictures: Pictures
    responses: tuple[ResponsePicture, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class MeasuredIsos:
    """Every ISO of a study, in ascending order; what its files came to; and the published study's figures so far."""

    isos: tuple[IsoOutcome, ...]
    reduction: Reduction
    published: PublishedMeasurement


class IsoMeasurer:
    """Measures one ISO after the other.

    Parameters
    ----------
    study, options
        What was taken; what to measure and how.
    folder
        Where maps and tables are written; None writes none, and takes no pictures.

    """

    def __init__(self, study: Study, *, options: Options, folder: Path | None) -> None:
        self._study = study
        self._options = options
        self._folder = folder
        self._published = PublishedMeasurement(study, options=options, folder=folder)
        self._isos: list[IsoOutcome] = []

    def measure(self, bursts: IsoBursts) -> None:
        """Measure an ISO while its sums are there."""
        study, options, folder = self._study, self._options, self._folder
        responses: list[ResponsePicture] = []

        def maps_made(used: IsoBursts, maps: IsoMaps) -> None:
            if folder is not None:
                write_response_maps(study, used, maps, folder / "maps")
                responses.extend(response_pictures(study, used.iso, maps))

        one = measure_iso(study, bursts, workers=options.workers, profiles=options.profiles, maps_made=maps_made)
        pictures = Pictures()
        if folder is not None:
            write_shading_maps(study, one, folder / "maps")
            taken = any(iso.pictures.differences for iso in self._isos)
            pictures = pictures if taken else take_pictures(bursts)
        self._published.add(one)
        self._isos.append(
            IsoOutcome(
                bursts=without_pixels(bursts),
                measured=without_sums(one),
                temperatures=measure_temperatures(study, bursts, one.section.rows, profiles=options.profiles),
                pictures=pictures,
                responses=tuple(responses),
            )
        )

    def measured(self, reduction: Reduction, *, order: Sequence[float | None]) -> MeasuredIsos:
        """Return every ISO that was measured, in some order, with what its files came to."""
        isos = sorted(self._isos, key=lambda one: order.index(one.bursts.iso))
        return MeasuredIsos(isos=tuple(isos), reduction=reduction, published=self._published)
