"""What a results document says of a camera, asked for by quantity, unit, channel and ISO.

Recommended figures of the whole plane alone. A figure that the channels share is taken as it stands; of others the
mean over the channels, weighted by their errors where they have some.
"""

import statistics
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Final, cast

from fullwell.errors import UsageError
from fullwell.figures.results import Row, at_main_temperature
from fullwell.glossary.flags import RECOMMENDED
from fullwell.model.conversions import rounding_electrons2
from fullwell.raw.cfa import ALL, channels
from fullwell.report.reading import results_of

_NO_CAPACITY: Final = frozenset({"lower-bound", "adc-limited"})
_FACTS: Final = ("pixel_pitch_um", "voltage_swing_v", "name")

Light = tuple[float, float | None]
"""Exposure [s] and photons, None where unknown [p], of a series of flats."""
Table = Mapping[str, Sequence[object]]
"""Columns of a curve by name."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Figures:
    """A results document that can be asked.

    Parameters
    ----------
    study
        What was read (RESULTS 2).
    rows
        Recommended rows of the whole plane.
    curves
        What is plotted, by name.

    """

    study: Mapping[str, object]
    rows: tuple[Row, ...]
    curves: Mapping[str, Table]

    @classmethod
    def of(cls, document: Mapping[str, object]) -> "Figures":
        """Return the figures of a document.

        Raises
        ------
        UsageError
            Where it is no results document, or its frames are of unknown size.

        """
        try:
            every = results_of(document).rows
        except ValueError as error:
            raise UsageError(f"The document is {error}.") from error
        rows = [row for row in every if row.region is None and row.exposure_s is None]
        study = cast("Mapping[str, object]", document.get("study", {}))
        if any(study.get(key) is None for key in ("width", "height", "cfa", "bit_depth")):
            raise UsageError("The results do not say how large the frames were; measure them again.")
        curves = cast("Mapping[str, Mapping[str, Mapping[str, object]]]", document.get("curves", {}))
        return cls(
            study=study,
            rows=tuple(row for row in at_main_temperature(rows) if RECOMMENDED in row.flags),
            curves={
                name: {title: cast("Sequence[object]", column["values"]) for title, column in curve.items()}
                for name, curve in curves.items()
            },
        )

    @property
    def width(self) -> int:
        """Of the visible mosaic [pixel]."""
        return int(cast("int", self.study["width"]))

    @property
    def height(self) -> int:
        """Of the visible mosaic [pixel]."""
        return int(cast("int", self.study["height"]))

    @property
    def cfa(self) -> str:
        """Order at the visible top-left pixel, or ``mono``."""
        return str(self.study["cfa"])

    @property
    def bit_depth(self) -> int:
        """Of the codes [bit]."""
        return int(cast("int", self.study["bit_depth"]))

    @property
    def series(self) -> Sequence[Mapping[str, object]]:
        """Kind, ISO, exposure and frames of every series that was read."""
        return cast("Sequence[Mapping[str, object]]", self.study.get("series", ()))

    @property
    def facts(self) -> Mapping[str, object]:
        """Facts about the camera that were given with the study, by the names a config has for them."""
        given = cast("Mapping[str, object]", self.study.get("camera", {}))
        return {name: given[name] for name in _FACTS if given.get(name) is not None}

    @property
    def isos(self) -> tuple[float | None, ...]:
        """ISOs that have a system gain, ascending."""
        found = {row.iso for row in self.rows if row.quantity == "system_gain" and row.measured.unit == "DN/e-"}
        return tuple(sorted(found, key=lambda iso: iso or 0.0))

    def at(self, quantity: str, unit: str, iso: float | None) -> list[Row]:
        """Return the rows of a figure at an ISO: that of all channels if there is one, else one a channel."""
        rows = [
            row
            for row in self.rows
            if (row.quantity, row.measured.unit, row.iso, row.snr_threshold) == (quantity, unit, iso, None)
        ]
        return [row for row in rows if row.channel == ALL] or [row for row in rows if row.channel != "G"]

    def value(self, quantity: str, unit: str, iso: float | None) -> float | None:
        """Return a figure at an ISO; None where it was not measured."""
        return _weighted(self.at(quantity, unit, iso))

    def pooled(self, quantity: str, unit: str) -> float | None:
        """Return a figure that does not depend on the ISO, from all ISOs together; None where it was not measured."""
        return _weighted([row for iso in (*self.isos, None) for row in self.at(quantity, unit, iso)])

    def level(self, quantity: str, channel: str, iso: float | None) -> float | None:
        """Return a level of a channel at an ISO, or that which all channels share [DN]."""
        for name in (channel, ALL):
            for row in self.rows:
                if (row.quantity, row.channel) == (quantity, name) and row.iso in {iso, None}:
                    return row.measured.value
        return None

    def system_gain(self, iso: float | None) -> float:
        """Return K at an ISO [DN/e-].

        Raises
        ------
        UsageError
            Where it was not measured.

        """
        found = self.value("system_gain", "DN/e-", iso)
        if found is None or found <= 0.0:
            raise UsageError(
                "The results hold no system gain: nothing is known in electrons, so no camera can be simulated. It "
                "takes flats of several exposures, or a chart, to measure it."
            )
        return found

    def read_noise_variance(self, iso: float | None, *, system_gain: float) -> float:
        """Return the temporal variance in the dark without rounding; from k_dark where no dark frame told it [e-^2]."""
        found = self.value("read_noise_variance", "e-^2", iso)
        if found is not None:
            return found
        k_dark = self.value("k_dark_variance", "1", iso)
        if k_dark is None:
            return 0.0
        return k_dark * (self.digital_maximum(iso) / system_gain) ** 2 - rounding_electrons2(system_gain=system_gain)

    def digital_maximum(self, iso: float | None) -> float:
        """Return D [DN]; of results that do not say it, the highest white level, or what the bits hold."""
        for quantity in ("digital_maximum", "white_level"):
            levels = [self.level(quantity, channel, iso) for channel in channels(self.cfa)]
            known = [level for level in levels if level is not None]
            if known:
                return max(known)
        return 2.0**self.bit_depth - 1.0

    def saturation_capacity(self, iso: float | None) -> float | None:
        """Return the charge at which pixels were seen to fill; None where the converter ended first [e-]."""
        rows = [row for row in self.at("saturation_capacity", "e-", iso) if _NO_CAPACITY.isdisjoint(row.flags)]
        return max((row.measured.value for row in rows), default=None)

    def filled_below_converter(self, iso: float | None) -> float | None:
        """Return the charge at which codes pile up though the converter goes on; None where they do not [e-]."""
        maximum, system_gain = self.digital_maximum(iso), self.system_gain(iso)
        found = [
            (white - (self.level("black_level", channel, iso) or 0.0)) / system_gain
            for channel in channels(self.cfa)
            if (white := self.level("white_level", channel, iso)) is not None and white < maximum
        ]
        return max(found, default=None)

    def shortest_unlit_s(self, iso: float | None) -> float:
        """Return the exposure that read noise belongs to [s]."""
        unlit = [
            float(cast("float", one["exposure_s"]))
            for one in self.series
            if one["kind"] in {"dark", "bias"} and one["iso"] == iso and one["exposure_s"] is not None
        ]
        return min(unlit, default=0.0)

    def signals(self, iso: float | None) -> Mapping[tuple[str, Light], float]:
        """Return the mean signal of flats by channel and light, of those that are on the curve: no pixels full [DN]."""
        found: dict[tuple[str, Light], float] = {}
        for name in ("exposure_response", "photon_transfer"):
            curve = self.curves.get(name, {})
            points = len(curve.get("iso", ()))
            for at, channel, kind, exposure_s, photons, signal, used in zip(
                *(curve.get(column, ()) for column in ("iso", "channel")),
                curve.get("kind", ("flat",) * points),
                curve.get("exposure_s", ()),
                curve.get("photons", (None,) * points),
                curve.get("signal", ()),
                curve.get("used", ("yes",) * points),
                strict=True,
            ):
                if at == iso and kind == "flat" and signal is not None and used == "yes":
                    light = (float(cast("float", exposure_s)), cast("float | None", photons))
                    found[str(channel), light] = float(cast("float", signal))
        return found

    def response(self) -> dict[str, float]:
        """Return the response of each channel relative to G1 over flats and patches; empty for one channel."""
        names = channels(self.cfa)
        if len(names) == 1:
            return {}
        ratios = {name: self._ratios(name) for name in names}
        return {name: round(statistics.median(found), 6) for name, found in ratios.items() if found}

    def _ratios(self, channel: str) -> list[float]:
        pairs: list[tuple[float, float]] = []
        for iso in self.isos:
            signals = self.signals(iso)
            pairs += [
                (signals[channel, light], green)
                for (name, light), green in signals.items()
                if name == "G1" and (channel, light) in signals
            ]
        points = self.patch_signals()
        pairs += [
            (points[channel, at, exposure_s, patch], green)
            for (name, at, exposure_s, patch), green in points.items()
            if name == "G1" and (channel, at, exposure_s, patch) in points
        ]
        strong = max((green for _, green in pairs), default=0.0) / 10.0
        return [mine / green for mine, green in pairs if green > strong]

    def patch_signals(self) -> Mapping[tuple[str, float | None, float, str], float]:
        """Return the mean signal of chart patches by channel, ISO, exposure and patch [DN]."""
        curve = self.curves.get("chart_points", {})
        columns = [curve.get(column, ()) for column in ("channel", "iso", "exposure_s", "patch", "signal", "used")]
        return {
            (str(channel), cast("float | None", iso), float(cast("float", exposure_s or 0.0)), str(patch)): float(
                cast("float", signal)
            )
            for channel, iso, exposure_s, patch, signal, used in zip(*columns, strict=True)
            if signal is not None and used == "yes"
        }


def _weighted(rows: Iterable[Row]) -> float | None:
    """Return the mean of rows by their errors; the plain mean where one has none."""
    every = list(rows)
    if not every:
        return None
    errors = [row.measured.std_error for row in every]
    if all(errors):
        weights = [1.0 / error**2 for error in errors if error]
        return sum(w * row.measured.value for w, row in zip(weights, every, strict=True)) / sum(weights)
    return sum(row.measured.value for row in every) / len(every)
