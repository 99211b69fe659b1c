"""What the measurements read: the statistics of every series, grouped by ISO."""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace

from fullwell.frames.series import MEASURED_KINDS, Kind, Series, SeriesKey, Study
from fullwell.statistics.first_look import FirstFrames
from fullwell.statistics.pixels import PixelSums
from fullwell.statistics.series import PlaneStatistics, SeriesStatistics


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Burst:
    """One series and what its frames came to.

    Parameters
    ----------
    series, statistics
        The frames and their numbers.
    sums
        Sum over the frames of each pixel, shape (height, width) [DN]; None where it was not kept.
    first
        What the first frames tell one by one; None where it is not known.

    """

    series: Series
    statistics: SeriesStatistics
    sums: PixelSums | None = None
    first: FirstFrames | None = None

    @property
    def kind(self) -> Kind:
        """Return what the frames were taken for."""
        return self.series.kind

    @property
    def exposure_s(self) -> float:
        """Return the exposure, 0 where a bias series does not say [s]."""
        return self.series.exposure_s or 0.0

    @property
    def frames(self) -> int:
        """Return the number of frames that were used."""
        return len(self.statistics.frames)

    @property
    def cell(self) -> int:
        """Return the period of the mosaic [pixel]."""
        return _cell(len(self.statistics.planes))

    def without_pixels(self) -> "Burst":
        """Return the burst without its sums and the middles of its first frames."""
        return replace(self, sums=None, first=None if self.first is None else replace(self.first, middles=None))

    def with_code_steps(self, steps: Sequence[float]) -> "Burst":
        """Return the burst with the distances of its codes by channel [DN]."""
        planes = zip(self.statistics.planes, steps, strict=True)
        stepped = tuple(replace(plane, code_step=step) for plane, step in planes)
        return replace(self, statistics=replace(self.statistics, planes=stepped))

    def plane(self, channel: str) -> PlaneStatistics:
        """Return the statistics of one channel."""
        return next(plane for plane in self.statistics.planes if plane.channel == channel)

    def plane_sums(self, channel: str) -> PixelSums:
        """Return the sums over frames of one channel's pixels, a view [DN].

        Raises
        ------
        ValueError
            The sums of this burst were not kept.

        """
        if self.sums is None:
            raise ValueError("the sums of this burst were not kept")
        names = [plane.channel for plane in self.statistics.planes]
        row, column = divmod(names.index(channel), self.cell)
        return self.sums[row :: self.cell, column :: self.cell]


@dataclass(frozen=True, slots=True, kw_only=True)
class IsoBursts:
    """Every burst at one ISO and temperature, each group by ascending exposure.

    ``black_clipped`` names channels cut at black; ``elsewhere`` are the bursts of the same ISO at other temperatures,
    the coldest first.
    """

    iso: float | None
    temperature_c: float | None
    channels: tuple[str, ...]
    flats: tuple[Burst, ...]
    darks: tuple[Burst, ...]
    biases: tuple[Burst, ...]
    black_clipped: tuple[str, ...] = ()
    elsewhere: "tuple[IsoBursts, ...]" = ()

    @property
    def cell(self) -> int:
        """Return the period of the mosaic [pixel]."""
        return _cell(len(self.channels))

    @property
    def unlit(self) -> tuple[Burst, ...]:
        """Return the bias and dark bursts together, by ascending exposure."""
        return tuple(sorted((*self.biases, *self.darks), key=lambda burst: burst.exposure_s))

    @property
    def label(self) -> str:
        """Return the ISO as people write it."""
        return "unknown ISO" if self.iso is None else f"ISO {self.iso:g}"


def group_by_iso(
    study: Study,
    statistics: Mapping[SeriesKey, SeriesStatistics],
    sums: Mapping[SeriesKey, PixelSums] | None = None,
    first: Mapping[SeriesKey, FirstFrames] | None = None,
) -> tuple[IsoBursts, ...]:
    """Group the bursts that survived reduction by ISO, in ascending order.

    Parameters
    ----------
    study
        The experiment.
    statistics
        Statistics by the key of the series; series without usable frames are absent.
    sums
        Sums over frames of each pixel by the same key, as far as they were kept.
    first
        What the first frames tell one by one, by the same key.

    """
    groups: list[IsoBursts] = []
    for iso in study.isos:
        every = [
            Burst(
                series=series,
                statistics=statistics[series.key],
                sums=(sums or {}).get(series.key),
                first=(first or {}).get(series.key),
            )
            for series in study.select(*MEASURED_KINDS, iso=iso)
            if series.key in statistics
        ]
        if every:
            groups.append(_at_one_iso(iso, every))
    return tuple(groups)


def _at_one_iso(iso: float | None, every: Sequence[Burst]) -> IsoBursts:
    """Return the bursts at the temperature that has the most lit frames, or else the most; what knows none joins it."""
    by_condition: dict[float | None, list[Burst]] = {}
    for burst in every:
        by_condition.setdefault(burst.series.condition_c, []).append(burst)
    temperatures = sorted(celsius for celsius in by_condition if celsius is not None)
    if not temperatures:
        return _together(iso, every)
    main = max(temperatures, key=lambda celsius: _weight(by_condition[celsius]))
    here = [burst for burst in every if burst.series.condition_c in {main, None}]
    others = tuple(_together(iso, by_condition[celsius]) for celsius in temperatures if celsius != main)
    return replace(_together(iso, here), elsewhere=others)


def _weight(every: Sequence[Burst]) -> tuple[int, int]:
    return sum(one.frames for one in every if one.kind is Kind.FLAT), sum(one.frames for one in every)


def _together(iso: float | None, every: Sequence[Burst]) -> IsoBursts:
    flats, darks, biases = (tuple(burst for burst in every if burst.kind is kind) for kind in MEASURED_KINDS)
    return IsoBursts(
        iso=iso,
        temperature_c=_mean_temperature(burst.series for burst in every),
        channels=tuple(plane.channel for plane in every[0].statistics.planes),
        flats=flats,
        darks=darks,
        biases=biases,
    )


def without_pixels(bursts: IsoBursts) -> IsoBursts:
    """Return bursts that hold no pixels, so that these can be let go."""
    return _each(bursts, Burst.without_pixels)


def with_code_steps(bursts: IsoBursts, steps: Sequence[float]) -> IsoBursts:
    """Return bursts that know the distances of their codes by channel [DN]."""
    return _each(bursts, lambda burst: burst.with_code_steps(steps))


def _each(bursts: IsoBursts, change: Callable[[Burst], Burst]) -> IsoBursts:
    flats, darks, biases = (tuple(map(change, group)) for group in (bursts.flats, bursts.darks, bursts.biases))
    elsewhere = tuple(_each(other, change) for other in bursts.elsewhere)
    return replace(bursts, flats=flats, darks=darks, biases=biases, elsewhere=elsewhere)


def _cell(sites: int) -> int:
    return 1 if sites == 1 else 2


def _mean_temperature(series: Iterable[Series]) -> float | None:
    known = [one.temperature_c for one in series if one.temperature_c is not None]
    return round(sum(known) / len(known), 1) if known else None
