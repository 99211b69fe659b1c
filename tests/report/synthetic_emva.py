"""An EMVA 1288 campaign as its evaluation leaves it: rows and curves from a linear camera, without any pixels."""

import math

import numpy as np

from fullwell.figures.results import Column, Curve, Results, Row
from fullwell.findings import Finding, Severity
from fullwell.units import Measured, square_root

METHOD = "emva1288-4.0-linear"
CORRECTED = "emva1288-4.0-linear-hp-corrected"
PACKAGE = "emva1288-py-1.0"
SHAPE = (480, 640)
AREA_UM2 = 11.9

CAMPAIGN = {
    "vendor": "Example Optics",
    "model": "C-1 *beta* #1",
    "serial_number": "S$42_<7>",
    "company": "Example Lab @ home",
    "date": "2026-05-04",
    "data_type": "single",
    "sensor_type": "CMOS",
    "sensor_diagonal_mm": 11.0,
    "shutter_type": "global",
    "interface": "GigE",
    "f_number": 8.0,
    "frame_rate_hz": 30.0,
}
LIGHT = {"wavelength_nm": 530.0, "fwhm_nm": 33.0, "nonuniformity_percent": 1.2, "calibration_error_percent": 3.0}

UNITS = {
    "photons": "p",
    "exposure_s": "s",
    "frequency": "cycles/pixel",
    "index": "pixel",
    "share": "%",
    "snr": "1",
    "snr_total": "1",
    "ideal": "1",
    "pixels": "1",
    "model": "1",
    "top_fraction": "1",
    "variance": "DN^2",
    "variance_total": "DN^2",
    "dark_variance": "DN^2",
    "variance_std_error": "DN^2",
    "spatial_variance": "DN^2",
    "dark_variance_fitted": "DN^2",
    "deviation_std_error": "%",
}
FLAGS = {"in_range", "in_linearity", "saturation", "measured", "method", "iso", "temperature_c", "channel", "direction"}


def curve(name, parts, **units):
    """Return the parts, one a channel and ISO, as one curve."""
    columns = {}
    for method, iso, channel, values in parts:
        length = len(next(iter(values.values())))
        place = {"method": method, "iso": iso, "temperature_c": None, "channel": channel}
        for key, column in {key: [value] * length for key, value in place.items()}.items():
            columns.setdefault(key, []).extend(column)
        for key, column in values.items():
            columns.setdefault(key, []).extend(
                value if isinstance(value, str) or value is None else float(value) for value in column
            )
    return Curve(
        name=name,
        columns=tuple(
            Column(name=key, unit=units.get(key, UNITS.get(key, "" if key in FLAGS else "DN")), values=tuple(values))
            for key, values in columns.items()
        ),
    )


class Camera:
    """One channel at one ISO."""

    def __init__(self, *, iso, channel, response, photons_known, seed):
        self.iso, self.channel = iso, channel
        self.gain = 0.4 * iso / 100.0
        self.eta = 0.6 * response if photons_known else None
        self.photons_known = photons_known
        self.noise_e, self.dsnu_e, self.prnu = 2.4, 0.7, 0.0068
        self.full_e = (4095.0 - 64.0) / self.gain
        self.rng = np.random.default_rng(seed)

    def sweep(self):
        signal_e = np.linspace(0.0, self.full_e * 1.02, 50)
        signal = np.minimum(signal_e * self.gain, self.full_e * self.gain)
        dark = (self.noise_e * self.gain) ** 2 + 1.0 / 12.0
        variance = np.where(signal_e < self.full_e * 0.995, self.gain * signal, 0.2 * self.gain * signal)
        variance = variance * (1.0 + self.rng.normal(0.0, 2e-3, 50))
        spatial = (self.dsnu_e * self.gain) ** 2 + (self.prnu * signal) ** 2
        peak = signal.max()
        return {
            "exposure_s": np.linspace(0.0, 0.05, 50) + 2e-5,
            "photons": list(signal_e / self.eta) if self.photons_known else [None] * 50,
            "signal": signal,
            "mean": signal + 64.0,
            "dark_mean": np.full(50, 64.0),
            "variance_total": variance + dark,
            "dark_variance": np.full(50, dark),
            "variance": variance,
            "variance_std_error": (variance + dark) * math.sqrt(2.0 / 3e5),
            "noise": np.sqrt(variance + dark),
            "mean_difference": self.rng.normal(0.0, 0.01, 50),
            "spatial_variance": spatial,
            "top_fraction": np.where(signal < peak, 0.0, 0.01),
            "snr": signal / np.sqrt(variance + dark),
            "snr_total": signal / np.sqrt(variance + dark + spatial),
            "in_range": (signal <= 0.7 * peak).astype(float),
            "in_linearity": ((signal >= 0.05 * peak) & (signal <= 0.95 * peak)).astype(float),
            "saturation": (np.arange(50) == 49).astype(float),
        }

    def rows(self, method=METHOD):
        def row(quantity, value, unit, error=None, *, by=method, twin=False, **more):
            measured = Measured.exact(value, unit) if error is None else Measured.student(value, error, 48.0, unit)
            flags = ()
            if twin:
                measured = square_root(measured, unit)
                flags = ("upper-limit",) if measured.value <= 0.0 else ()
            return Row(
                quantity=quantity,
                channel=self.channel,
                method=by,
                measured=measured,
                iso=self.iso,
                n=SHAPE[0] * SHAPE[1],
                flags=flags,
                source="EMVA1288 10.1",
                **more,
            )

        threshold = math.sqrt((self.noise_e**2 + 1.0 / 12.0 / self.gain**2) + 0.25) + 0.5
        rows = [
            row("system_gain", self.gain, "DN/e-", self.gain * 2e-3),
            row("conversion_factor", 1.0 / self.gain, "e-/DN", 2e-3 / self.gain),
            row("dark_noise", self.noise_e, "e-", 0.01),
            row("dark_noise", self.noise_e * self.gain, "DN", 0.004),
            row("snr_max", math.sqrt(self.full_e), "1", 0.1),
            row("snr_max", 10.0 * math.log10(self.full_e), "dB", 0.01),
            row("inverse_snr_max", 100.0 / math.sqrt(self.full_e), "%", 1e-3),
            row("sensitivity_threshold", threshold, "e-", 0.01, snr_threshold=1.0),
            row("sensitivity_threshold", 105.0, "e-", 0.1, snr_threshold=10.0),
            row("sensitivity_threshold_per_area", threshold / AREA_UM2, "e-/um^2", 0.001, snr_threshold=1.0),
            row("saturation_capacity", self.full_e, "e-", 20.0),
            row("saturation_capacity_per_area", self.full_e / AREA_UM2, "e-/um^2", 2.0),
            row("dynamic_range", self.full_e / threshold, "1", 12.0),
            row("dynamic_range", 20.0 * math.log10(self.full_e / threshold), "dB", 0.03),
            row("linearity_error", 0.14, "%"),
            row("dark_signal", 64.0, "DN", 0.002),
        ]
        rows += self._pattern_rows(row, method)
        if self.photons_known:
            rows += [
                row("quantum_efficiency", 100.0 * self.eta, "%", 0.2),
                row("responsivity", self.gain * self.eta, "DN/p", 1e-4),
                row("sensitivity_threshold", threshold / self.eta, "p", 0.02, snr_threshold=1.0),
                row("saturation_capacity", self.full_e / self.eta, "p", 30.0),
                row("dark_current", 2.22, "e-/s", 0.4),
                row("dark_current_from_variance", -0.3, "e-/s", 1.1),
            ]
        return rows

    def _pattern_rows(self, row, method):
        rows = []
        for name, unit, whole in (("dsnu", "e-", self.dsnu_e**2), ("prnu", "%", (100.0 * self.prnu) ** 2)):
            for part, share in (("", 1.0), ("_row", -0.001), ("_column", 0.02), ("_pixel", 0.97)):
                for by, lost in ((method, 0.99), *(((CORRECTED, 1.0),) if method == METHOD else ())):
                    rows.append(row(f"{name}{part}", whole * share * lost, unit, 0.004 * whole, by=by, twin=True))
        return rows

    def curves(self):
        sweep, rng = self.sweep(), self.rng
        photons, signal = sweep["photons"], sweep["signal"]
        keep = sweep["in_linearity"] > 0
        found = {
            "emva_sweep": sweep,
            "emva_characteristic": {
                "photons": photons,
                "exposure_s": sweep["exposure_s"],
                "signal": signal,
                "fitted": signal,
                "in_range": sweep["in_range"],
            },
            "emva_stability": {key: sweep[key] for key in ("signal", "noise", "mean_difference")},
            "emva_photon_transfer": {
                **{
                    key: sweep[key]
                    for key in ("signal", "variance", "variance_total", "dark_variance", "variance_std_error")
                },
                "fitted": self.gain * signal,
                "in_range": sweep["in_range"],
                "saturation": sweep["saturation"],
            },
            "emva_snr": {key: sweep[key] for key in ("photons", "exposure_s", "snr", "snr_total")},
            "emva_linearity": {
                "photons": [value for value, kept in zip(photons, keep, strict=True) if kept],
                "exposure_s": sweep["exposure_s"][keep],
                "signal": signal[keep],
                "fitted": signal[keep],
                "deviation": rng.normal(0.0, 0.1, int(keep.sum())),
                "deviation_std_error": np.full(int(keep.sum()), 0.05),
                "in_range": np.ones(int(keep.sum())),
            },
        }
        return {**found, **self._with_photons(sweep), **self._patterns()}

    def _with_photons(self, sweep):
        if not self.photons_known:
            return {}
        model = np.geomspace(1.0, 4.0 * self.full_e, 60)
        electrons = self.eta * model
        dark_e2 = self.noise_e**2 + 1.0 / 12.0 / self.gain**2
        times = np.linspace(0.1, 10.0, 6)
        mean, variance = 64.0 + 0.9 * times, 1.0 + 0.36 * times
        return {
            "emva_snr_model": {
                "photons": model,
                "snr": electrons / np.sqrt(dark_e2 + electrons),
                "snr_total": electrons / np.sqrt(dark_e2 + self.dsnu_e**2 + electrons + (self.prnu * electrons) ** 2),
                "ideal": np.sqrt(model),
            },
            "emva_dark_mean": {
                "exposure_s": sweep["exposure_s"],
                "dark_mean": sweep["dark_mean"],
                "measured": [1.0] * 50,
            },
            "emva_dark_current": {
                "exposure_s": times,
                "dark_mean": mean + self.rng.normal(0.0, 0.02, 6),
                "dark_mean_fitted": mean,
                "dark_variance": variance + self.rng.normal(0.0, 0.02, 6),
                "dark_variance_fitted": variance,
            },
        }

    def _patterns(self):
        found, rng = {}, self.rng
        for which, level in (("dsnu", self.dsnu_e * self.gain), ("prnu", 100.0 * self.prnu)):
            spectrum, profile = {}, {}
            for direction, size in (("horizontal", SHAPE[1]), ("vertical", SHAPE[0])):
                frequency = np.arange(size // 2 + 1) / size
                for key, values in {
                    "direction": [direction] * len(frequency),
                    "frequency": frequency,
                    "amplitude": level * np.sqrt(rng.gamma(200.0, 1.0 / 200.0, len(frequency))),
                    "pattern": np.full(len(frequency), level),
                    "temporal": np.full(len(frequency), 3.0 * level),
                }.items():
                    spectrum.setdefault(key, []).extend(values)
                base = (64.0 if which == "dsnu" else 2000.0) + np.sin(np.arange(size) / 60.0)
                for key, values in {
                    "direction": [direction] * size,
                    "index": np.arange(size),
                    "middle": base + rng.normal(0.0, level, size),
                    "mean": base,
                    "maximum": base + 4.0 * level,
                    "minimum": base - 4.0 * level,
                }.items():
                    profile.setdefault(key, []).extend(values)
            found[f"emva_spectrogram_{which}"] = spectrum
            found[f"emva_profile_{which}"] = profile
            deviation = np.linspace(-8.0 * level, 8.0 * level, 200)
            bell = SHAPE[0] * SHAPE[1] * 0.08 * np.exp(-0.5 * (deviation / level) ** 2)
            found[f"emva_histogram_{which}"] = {
                "deviation": deviation,
                "pixels": np.maximum(np.round(bell), (rng.random(200) < 0.1).astype(float)),
                "model": bell,
            }
            away = np.linspace(0.0, 8.0 * level, 120)
            share = 100.0 * np.exp(-0.5 * (away / level) ** 2) + 1e-3
            found[f"emva_accumulated_{which}"] = {"deviation": away, "share": share, "pixels": share * 3072.0}
        return found


def synthetic_campaign(*, isos=(100.0,), channels=("mono",), photons_known=True, method=METHOD, campaign=CAMPAIGN):
    """Return the results of a campaign."""
    cameras = [
        Camera(iso=iso, channel=name, response=1.0 - 0.15 * at, photons_known=photons_known, seed=int(iso) + at)
        for iso in isos
        for at, name in enumerate(channels)
    ]
    parts = {}
    for camera in cameras:
        for name, values in camera.curves().items():
            parts.setdefault(name, []).append((method, camera.iso, camera.channel, values))
    percent = {"amplitude": "%", "pattern": "%", "temporal": "%"}
    curves = tuple(
        curve(name, many, **(percent if name == "emva_spectrogram_prnu" else {}), **_of_linearity(name))
        for name, many in parts.items()
    )
    cfa = "mono" if tuple(channels) == ("mono",) else "RGGB"
    return Results(
        study={
            "camera": {"name": "C-1", "pixel_pitch_um": 3.45},
            "emva": campaign,
            "light": LIGHT if photons_known else {},
            "width": SHAPE[1],
            "height": SHAPE[0],
            "cfa": cfa,
            "bit_depth": 12,
            "black_level": {"values": [64.0], "source": "manifest", "tag": None},
            "settings": {"profile": method},
            "series": [
                {"kind": "flat", "iso": iso, "exposure_s": 2e-5, "temperature_c": 25.0, "frames": 2} for iso in isos
            ],
            "files": [],
        },
        rows=tuple(row for camera in cameras for row in camera.rows(method)),
        findings=(
            Finding(
                code="emva-few-steps",
                severity=Severity.WARNING,
                message="The sweep has 40 steps; 50 are asked for.",
            ),
        ),
        curves=curves,
    )


def _of_linearity(name):
    return {"deviation": "%"} if name == "emva_linearity" else {}
