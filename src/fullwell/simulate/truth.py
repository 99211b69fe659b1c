"""The true values of what a measurement of a simulated study reports, by the definitions of the glossary."""

import math
from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import dataclass

from fullwell.frames.series import Kind
from fullwell.glossary import SNR_THRESHOLDS
from fullwell.model.noise import noise_coefficients
from fullwell.model.photon_transfer import signal_at_snr, signal_to_noise
from fullwell.model.sensor import SensorParameters
from fullwell.raw.cfa import ALL, channels
from fullwell.simulate.config import SimulationConfig
from fullwell.simulate.lens_truth import Shading, true_shading
from fullwell.simulate.plan import PlannedFrame, plan
from fullwell.units import (
    DECIBEL,
    DN,
    DN2,
    DN_PER_ELECTRON,
    DN_PER_SECOND,
    ELECTRON,
    ELECTRON2,
    ELECTRON_PER_SECOND,
    ONE,
    PERCENT,
    STOP,
    VOLT,
    VOLT_PER_SECOND,
)


@dataclass(frozen=True, slots=True, kw_only=True)
class TrueValue:
    """One true value, with the names a result row has for it.

    Parameters
    ----------
    quantity, channel, unit
        As in a result row.
    iso
        None for what holds at every ISO.
    value
        The truth, in ``unit``.
    snr_threshold
        None where it does not apply.
    exposure_s
        None for what holds at every exposure, or for the figure that is not told by exposure [s].
    temperature_c
        None for what holds at every temperature of the study [deg C].

    """

    quantity: str
    channel: str
    unit: str
    iso: float | None
    value: float
    snr_threshold: float | None = None
    exposure_s: float | None = None
    temperature_c: float | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class _Unlit:
    """The unlit frames that noise and fixed pattern in the dark are measured on."""

    exposure_s: float = 0.0
    temperature_c: float | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class _Place:
    """One channel of one camera at one ISO; ``site`` is its place in the CFA cell."""

    config: SimulationConfig
    channel: str
    site: int
    iso: float
    frames: tuple[PlannedFrame, ...]
    shadings: tuple[Shading, ...]

    @property
    def sensor(self) -> SensorParameters:
        return self.config.sensor_at(self.iso)

    @property
    def unlit(self) -> tuple[PlannedFrame, ...]:
        """Dark and bias frames at the ISO."""
        return tuple(
            frame for frame in self.frames if frame.kind in {Kind.DARK, Kind.BIAS} and frame.exposure.iso == self.iso
        )

    @property
    def unlit_with_flats(self) -> tuple[PlannedFrame, ...]:
        """Those at the temperature of most flats, where an ISO is measured."""
        warm = Counter(
            frame.exposure.temperature_c
            for frame in self.frames
            if frame.kind is Kind.FLAT and frame.exposure.iso == self.iso
        )
        chosen = {most for most, _ in warm.most_common(1)}
        return tuple(frame for frame in self.unlit if frame.exposure.temperature_c in chosen) or self.unlit

    @property
    def straight(self) -> bool:
        """Whether signal and variance grow with the light as the noise model says, up to the full well."""
        return not (self.sensor.nonlinearity or self.sensor.brighter_fatter)

    @property
    def shares_levels(self) -> bool:
        """Whether it is one channel, or all with one black level: else they have no level or range in common."""
        return self.channel != ALL or len(set(self.sensor.black_level)) == 1

    @property
    def system_gain(self) -> float:
        return self.sensor.system_gain_at(self.iso)

    def row(
        self,
        quantity: str,
        unit: str,
        value: float,
        *,
        snr_threshold: float | None = None,
        exposure_s: float | None = None,
        temperature_c: float | None = None,
    ) -> TrueValue:
        return TrueValue(
            quantity=quantity,
            channel=self.channel,
            unit=unit,
            iso=self.iso,
            value=value,
            snr_threshold=snr_threshold,
            exposure_s=exposure_s,
            temperature_c=temperature_c,
        )

    def noise_rows(self, quantity: str, noise: float, *, exposure_s: float | None = None) -> Iterator[TrueValue]:
        """Yield a noise in electrons, DN and volts, and its variance."""
        noise_dn = noise * self.system_gain
        yield self.row(quantity, ELECTRON, noise, exposure_s=exposure_s)
        yield self.row(quantity, DN, noise_dn, exposure_s=exposure_s)
        yield self.row(f"{quantity}_variance", ELECTRON2, noise**2, exposure_s=exposure_s)
        yield self.row(f"{quantity}_variance", DN2, noise_dn**2, exposure_s=exposure_s)
        if self.config.voltage_swing_v is not None:
            volts = noise_dn * self.config.voltage_swing_v / self.sensor.white_level
            yield self.row(quantity, VOLT, volts, exposure_s=exposure_s)


def true_values(config: SimulationConfig) -> tuple[TrueValue, ...]:
    """Return the true value of every figure a measurement of the study may report, in every unit it may have.

    Temporal noise is that of one pixel without quantization, whatever it shares with its row, column or frame
    included. The noise model's coefficients, and SNR and range by them, are those within a single frame, with DSNU and
    quantization but no noise of whole frames, relative to the white level, as the rows define them.
    """
    named = [*enumerate(channels(config.sensor.cfa))]
    if len(named) > 1:
        named.append((0, ALL))
    rows: list[TrueValue] = []
    frames = plan(config)
    shadings = true_shading(config) if any(frame.kind is Kind.FLAT for frame in frames) else ()
    for site, channel in named:
        for iso in config.isos:
            place = _Place(config=config, channel=channel, site=site, iso=float(iso), frames=frames, shadings=shadings)
            for part in _PARTS:
                rows += part(place)
        rows += _before_and_after(config, channel)
    return tuple(rows)


def _levels(place: _Place) -> Iterator[TrueValue]:
    sensor, chart = place.sensor, place.config.chart
    if chart is not None and any(
        frame.kind is Kind.CHART and frame.exposure.iso == place.iso for frame in place.frames
    ):
        yield place.row("flare", ONE, place.config.lens.flare / chart.lightest)
    if place.shares_levels:
        yield place.row("black_level", DN, sensor.black_level[place.site])
    if sensor.saturation_at(place.iso, place.site) < sensor.full_well:
        yield place.row("white_level", DN, float(sensor.white_level))
    yield place.row("digital_maximum", DN, float(sensor.white_level))
    yield place.row("system_gain", DN_PER_ELECTRON, place.system_gain)


def _unlit_noise(place: _Place) -> Iterator[TrueValue]:
    sensor = place.sensor
    unlit = _shortest_unlit(place)
    noises = [
        ("read_noise", sensor.dark_noise_at(place.iso, _read_noise_exposure_s(place), unlit.temperature_c)),
        ("read_noise_row", sensor.read_noise_row),
        ("read_noise_column", sensor.read_noise_column),
        *_dsnu_parts(place, unlit),
    ]
    for quantity, noise in noises:
        yield from place.noise_rows(quantity, noise)


def _longer_darks(place: _Place) -> Iterator[TrueValue]:
    """Yield DSNU and the total dark noise of every dark burst: the one grows with exposure where pixels differ."""
    sensor, unlit = place.sensor, _shortest_unlit(place)
    pattern = dict(_dsnu_parts(place, unlit)).get("dsnu")
    if pattern is None:
        return
    darks = [frame.exposure for frame in place.unlit_with_flats if frame.kind is Kind.DARK]
    for exposure_s, temperature_c in dict.fromkeys((one.exposure_s, one.temperature_c) for one in darks):
        own = _Unlit(exposure_s=exposure_s, temperature_c=temperature_c)
        if own != unlit:
            yield from place.noise_rows("dsnu", dict(_dsnu_parts(place, own))["dsnu"], exposure_s=exposure_s)
        total = math.hypot(sensor.dark_noise_at(place.iso, exposure_s, temperature_c), pattern)
        yield place.row("total_dark_noise", ELECTRON, total, exposure_s=exposure_s)
        yield place.row("total_dark_noise", DN, total * place.system_gain, exposure_s=exposure_s)


def _shading(place: _Place) -> Iterator[TrueValue]:
    """Yield how much the lens shades; nothing where the response bends, or for channels together."""
    if place.channel == ALL or not place.straight or not place.shadings:
        return
    own = place.shadings[place.site]
    for quantity, value in (
        ("shading_corner", own.corner),
        ("shading_edge_x", own.edge_x),
        ("shading_edge_y", own.edge_y),
    ):
        yield place.row(quantity, ONE, value)


def _dsnu_parts(place: _Place, unlit: _Unlit) -> list[tuple[str, float]]:
    """Return DSNU and its parts; none where hot pixels leave it without a spread that a sample would show [e-]."""
    sensor = place.sensor
    if sensor.hot_pixels * sensor.hot_pixel_current > 0.0:
        return []
    pixel = math.hypot(sensor.dsnu, sensor.dark_current_spread * sensor.warmth(unlit.temperature_c) * unlit.exposure_s)
    return [
        ("dsnu", math.hypot(pixel, sensor.dsnu_row, sensor.dsnu_column)),
        ("dsnu_row", sensor.dsnu_row),
        ("dsnu_column", sensor.dsnu_column),
        ("dsnu_pixel", pixel),
    ]


def _dark_current(place: _Place) -> Iterator[TrueValue]:
    """Yield the dark current of the mean pixel at each temperature, and what doubles it."""
    sensor = place.sensor
    warm = sorted({frame.exposure.temperature_c for frame in place.unlit}, key=lambda one: one or 0.0)
    for temperature_c in warm or [None]:
        rate = sensor.mean_dark_current(temperature_c)
        rate_dn = rate * place.system_gain
        told = None if len(warm) < 2 else temperature_c
        yield place.row("dark_current", ELECTRON_PER_SECOND, rate, temperature_c=told)
        yield place.row("dark_current", DN_PER_SECOND, rate_dn, temperature_c=told)
        if place.config.voltage_swing_v is not None:
            volts = rate_dn * place.config.voltage_swing_v / sensor.white_level
            yield place.row("dark_current", VOLT_PER_SECOND, volts, temperature_c=told)
    if len(warm) > 1 and sensor.dark_current_doubling_c is not None:
        yield place.row("dark_current_doubling", "K", sensor.dark_current_doubling_c)


def _response(place: _Place) -> Iterator[TrueValue]:
    """Yield PRNU and the noise coefficients; nothing where a bent response or its neighbours' charge changes them."""
    sensor = place.sensor
    if not place.straight:
        return
    prnu = math.hypot(sensor.prnu, sensor.prnu_row, sensor.prnu_column)
    for quantity, share in (
        ("prnu", prnu),
        ("prnu_row", sensor.prnu_row),
        ("prnu_column", sensor.prnu_column),
        ("prnu_pixel", sensor.prnu),
    ):
        yield place.row(quantity, PERCENT, 100.0 * share)
        yield place.row(f"{quantity}_variance", f"{PERCENT}^2", (100.0 * share) ** 2)
    parts = dict(_dsnu_parts(place, _Unlit()))
    if "dsnu" not in parts:
        return
    ks = noise_coefficients(
        system_gain=place.system_gain,
        digital_maximum=float(sensor.white_level),
        dark_noise=sensor.dark_noise_at(place.iso, 0.0, of_frames=False),
        prnu=prnu,
        offset_spread=parts["dsnu"],
    )
    for quantity, value in (("k_dark", ks.k_dark), ("k_shot", ks.k_shot), ("k_fpn", ks.k_fpn)):
        yield place.row(quantity, ONE, value)
        yield place.row(f"{quantity}_variance", ONE, value**2)


def _range(place: _Place) -> Iterator[TrueValue]:
    sensor, system_gain = place.sensor, place.system_gain
    parts = dict(_dsnu_parts(place, _Unlit()))
    if not place.shares_levels or not place.straight or sensor.dual_conversion_ratio or "dsnu" not in parts:
        return
    fixed = sensor.prnu**2 + sensor.prnu_row**2 + sensor.prnu_column**2
    electrons = sensor.saturation_at(place.iso, place.site)
    level = electrons * system_gain
    in_frame = math.hypot(sensor.dark_noise_at(place.iso, 0.0, of_frames=False), parts["dsnu"])
    dark = (in_frame * system_gain) ** 2 + 1.0 / 12.0
    snr = float(signal_to_noise(level, dark=dark, shot=system_gain, fixed_pattern=fixed))
    yield place.row("saturation_capacity", ELECTRON, electrons)
    yield place.row("saturation_capacity", DN, level)
    yield place.row("snr_max", ONE, snr)
    yield place.row("snr_max", DECIBEL, 20.0 * math.log10(snr))
    for threshold in SNR_THRESHOLDS:
        ratio = level / signal_at_snr(threshold, dark=dark, shot=system_gain, fixed_pattern=fixed)
        if math.isfinite(ratio) and ratio > 0.0:
            yield place.row("dynamic_range", ONE, ratio, snr_threshold=threshold)
            yield place.row("dynamic_range", DECIBEL, 20.0 * math.log10(ratio), snr_threshold=threshold)
            yield place.row("dynamic_range", STOP, math.log2(ratio), snr_threshold=threshold)


_PARTS: tuple[Callable[[_Place], Iterator[TrueValue]], ...] = (
    _levels,
    _unlit_noise,
    _longer_darks,
    _dark_current,
    _response,
    _range,
    _shading,
)


def _before_and_after(config: SimulationConfig, channel: str) -> Iterator[TrueValue]:
    """Yield the noise before the amplifier at an amplification of 1, and that after it, where ISO tells them apart."""
    sensor = config.sensor
    if config.table.camera.at_iso or sensor.dual_conversion_ratio:
        return
    shared = sensor.read_noise_row**2 + sensor.read_noise_column**2 + sensor.read_noise_frame**2
    shared += sensor.rts_pixels * sensor.rts_amplitude**2
    before = math.sqrt(sensor.read_noise**2 + shared) * sensor.system_gain
    for quantity, value in (("read_noise_pre", before), ("read_noise_post", sensor.read_noise_post)):
        yield TrueValue(quantity=quantity, channel=channel, unit=DN, iso=None, value=value)
        yield TrueValue(quantity=f"{quantity}_variance", channel=channel, unit=DN2, iso=None, value=value**2)


def _shortest_unlit(place: _Place) -> _Unlit:
    """Return the exposure DSNU is measured at: the shortest of which there are two frames, of any if there are none."""
    every = [frame.exposure for frame in place.unlit_with_flats]
    times = Counter(one.exposure_s for one in every)
    usable = [one for one in every if times[one.exposure_s] > 1] or every
    first = min(usable, key=lambda one: one.exposure_s, default=None)
    return _Unlit() if first is None else _Unlit(exposure_s=first.exposure_s, temperature_c=first.temperature_c)


def _read_noise_exposure_s(place: _Place) -> float:
    """Return the exposure read noise is told for: that of bias frames, else none where darks of several tell [s]."""
    taken = Counter((frame.kind, frame.exposure.exposure_s) for frame in place.unlit_with_flats)
    biases, darks = (
        [exposure_s for (kind, exposure_s), frames in taken.items() if kind is wanted and frames > 1]
        for wanted in (Kind.BIAS, Kind.DARK)
    )
    return min(biases or darks, default=0.0) if biases or len(darks) < 2 else 0.0
