"""A realistic study of six ISOs and four channels, made from a noise model without any pixels."""

import math

import numpy as np
from synthetic_pattern import pattern_curves, pattern_rows, response_pictures, shading_differences, shading_pictures
from synthetic_study import DARK_EXPOSURES, FLAT_EXPOSURES, ISOS, PIXELS, RESPONSE, curve, gain_at, row

from fullwell.figures.results import Curve, Results, Row
from fullwell.findings import Finding, Severity
from fullwell.report.pictures import DarkZoom, DifferencePicture, Pictures, RegionHistogram
from fullwell.units import DECIBEL, DN, DN2, DN_PER_ELECTRON, DN_PER_SECOND, ELECTRON, STOP, Measured, square_root


def _channel_rows(rng: np.random.Generator, iso: float, channel: str) -> list[Row]:
    system_gain = gain_at(iso)
    read_variance = (4.1 * system_gain) ** 2 + 0.35**2
    variance = Measured.normal(read_variance * (1 + rng.normal(0, 4e-4)), read_variance * 4e-4, DN2)
    noise = square_root(variance, DN)
    best = ("recommended",)
    full = min(6000.0, (1023 - 64) / system_gain)
    dynamic = 20 * math.log10(full / (math.sqrt(read_variance) / system_gain + 0.5))
    common = {"iso": iso, "n": PIXELS * 5}

    def best_row(quantity, method, measured, *flags, **others):
        return row(quantity, channel, method, measured, flags=tuple(sorted((*best, *flags))), **common, **others)

    rows = [
        best_row("black_level", "fused", Measured.student(64.0 + rng.normal(0, 3e-3), 3e-3, 3.0, DN)),
        row("black_level", channel, "metadata", Measured.exact(64.0, DN), **common),
        best_row("white_level", "measured", Measured.exact(1023.0, DN)),
        best_row("read_noise", "temporal-variance", noise),
        best_row("read_noise_variance", "temporal-variance", variance),
        best_row("read_noise", "temporal-variance", noise.scaled(1 / system_gain, ELECTRON)),
        row("read_noise", channel, "legacy-pair-difference", Measured.exact(1.018 * noise.value, DN), **common),
        row("read_noise", channel, "legacy-burst-mean", Measured.exact(0.911 * noise.value, DN), **common),
        best_row("read_noise_row", "anova", Measured.student(0.08 * system_gain / 0.17, 0.004, 40.0, DN)),
        best_row(
            "read_noise_column",
            "anova",
            Measured(value=0.0, unit=DN, ci95=(0.0, 0.021 * system_gain / 0.17)),
            "upper-limit",
        ),
        best_row(
            "dark_current",
            "mean-slope",
            Measured.student(rng.normal(0.064 * iso / 55.0, 0.02), 0.021, 3.0, DN_PER_SECOND),
            *(("model-misfit",) if iso == 299.0 else ()),
        ),
        row("dark_current", channel, "legacy-frame-slope", Measured.exact(0.07 * iso / 55.0, DN_PER_SECOND), **common),
        best_row(
            "system_gain",
            "photon-transfer",
            Measured.normal(system_gain * (1 + rng.normal(0, 6e-4)), 6e-4 * system_gain, DN_PER_ELECTRON),
        ),
        best_row(
            "saturation_capacity",
            "plateau",
            Measured.normal(full, 3.0, ELECTRON),
            *(("adc-limited", "lower-bound") if full < 6000.0 else ()),
        ),
        best_row("snr_max", "noise-model", Measured.normal(10 * math.log10(full), 0.01, DECIBEL)),
        best_row("dynamic_range", "noise-model", Measured.normal(dynamic, 0.012, DECIBEL), snr_threshold=1.0),
        best_row("dynamic_range", "noise-model", Measured.normal(dynamic / 6.0206, 0.002, STOP), snr_threshold=1.0),
    ]
    return rows


def _rows(rng: np.random.Generator) -> tuple[Row, ...]:
    rows = [one for iso in ISOS for channel in RESPONSE for one in _channel_rows(rng, iso, channel)]
    rows += [
        row(
            "system_gain",
            "all",
            "photon-transfer",
            Measured.normal(gain_at(iso), 3e-4 * gain_at(iso), DN_PER_ELECTRON),
            iso=iso,
            flags=("channels-differ", "recommended"),
        )
        for iso in ISOS
    ]
    for channel in RESPONSE:
        rows += [
            row(
                "read_noise_pre", channel, "amplification-fit", Measured.normal(0.699, 2e-4, DN), flags=("recommended",)
            ),
            row(
                "read_noise_post", channel, "amplification-fit", Measured.normal(0.35, 2e-3, DN), flags=("recommended",)
            ),
        ]
    return (*rows, *pattern_rows(rng))


def _transfer(rng: np.random.Generator) -> Curve:
    points = []
    for iso in ISOS:
        for channel, response in RESPONSE.items():
            k = gain_at(iso)
            dark = (4.1 * k) ** 2 + 0.35**2
            points.append((iso, channel, "bias", 1e-4, 0.01, dark, dark * 4e-4, PIXELS, dark, 0.3, "yes"))
            for exposure in FLAT_EXPOSURES:
                level = 900.0 * exposure / 0.03 * response
                for _ in range(110):
                    signal = level * rng.uniform(0.4, 1.0)
                    fitted = dark + k * signal
                    residual = rng.normal()
                    variance = fitted * (1 + residual * 0.011)
                    used = "no" if rng.uniform() < 0.01 else "yes"
                    points.append(
                        (
                            iso,
                            channel,
                            "flat",
                            exposure,
                            signal,
                            variance,
                            0.011 * fitted,
                            16380,
                            fitted,
                            residual,
                            used,
                        )
                    )
    columns = {"iso": "1", "channel": "", "kind": "", "exposure_s": "s", "signal": DN, "variance": DN2}
    columns |= {"variance_std_error": DN2, "dof": "1", "fitted": DN2, "residual": "1", "used": ""}
    return curve("photon_transfer", columns, points)


def _snr() -> Curve:
    points = []
    for iso in ISOS:
        k = gain_at(iso)
        full = min(6000.0, 959.0 / k)
        for channel in RESPONSE:
            for kind, electrons in (("model", np.geomspace(0.5, full, 60)), ("measured", np.geomspace(60, full, 5))):
                for one in electrons:
                    ratio = one / math.sqrt(one + 4.1**2 + (0.35 / k) ** 2 + (0.007 * one) ** 2)
                    points.append((iso, channel, one * k, one, ratio, kind))
    columns = {"iso": "1", "channel": "", "signal": DN, "signal_e": ELECTRON, "snr": "1", "kind": ""}
    return curve("snr", columns, points)


def _dark_signal(rng: np.random.Generator) -> Curve:
    points = []
    for iso in ISOS:
        for index, channel in enumerate(RESPONSE):
            slope = 0.064 * iso / 55.0
            for exposure in DARK_EXPOSURES:
                fitted = 64.0 + 0.004 * index + slope * exposure
                points.append((iso, channel, "dark", exposure, fitted + rng.normal(0, 0.002), 0.002, fitted))
    columns = {"iso": "1", "channel": "", "kind": "", "exposure_s": "s", "mean": DN, "std_error": DN, "fitted": DN}
    return curve("dark_signal", columns, points)


def _histograms(rng: np.random.Generator) -> tuple[Curve, Curve]:
    columns = {"iso": "1", "channel": "", "exposure_s": "s", "code": DN, "count": "1"}
    dark, flat = [], []
    for iso in ISOS:
        sigma = math.hypot(4.1 * gain_at(iso), 0.35)
        for channel, response in RESPONSE.items():
            codes, counts = np.unique(np.rint(rng.normal(64.0, sigma, 60000)), return_counts=True)
            dark += [(iso, channel, 1e-4, int(code), int(n) * 60) for code, n in zip(codes, counts, strict=True)]
            dark.append((iso, channel, 1e-4, 400, 3))
            for exposure in FLAT_EXPOSURES:
                level = 900.0 * exposure / 0.03 * response
                codes = np.arange(64, 1024, 4)
                shape = np.exp(-0.5 * ((codes - 64 - 0.8 * level) / (0.12 * level + 6)) ** 2)
                flat += [
                    (iso, channel, exposure, int(code), int(n))
                    for code, n in zip(codes, 1e5 * shape, strict=True)
                    if n >= 1.0
                ]
    return curve("dark_histogram", columns, dark), curve("flat_histogram", columns, flat)


def _response(rng: np.random.Generator) -> Curve:
    points = []
    for iso in ISOS:
        for channel, response in RESPONSE.items():
            for exposure in FLAT_EXPOSURES:
                fitted = 800.0 * exposure / 0.03 * response
                off = rng.normal(0, 0.15)
                points.append((iso, channel, exposure, fitted * (1 + off / 100), fitted, off))
    columns = {"iso": "1", "channel": "", "exposure_s": "s", "signal": DN, "fitted": DN, "deviation": "%"}
    return curve("exposure_response", columns, points)


def _read_noise() -> Curve:
    points = []
    for channel in RESPONSE:
        for iso in ISOS:
            sigma = math.hypot(4.1 * gain_at(iso), 0.35)
            points.append((iso, channel, sigma, sigma * 2e-3, sigma, sigma / gain_at(iso)))
    columns = {"iso": "1", "channel": "", "read_noise": DN, "std_error": DN, "fitted": DN, "read_noise_e": ELECTRON}
    return curve("read_noise_iso", columns, points)


def _frame_means(rng: np.random.Generator) -> Curve:
    points = []
    for kind, exposures in (("flat", FLAT_EXPOSURES), ("dark", DARK_EXPOSURES), ("bias", (1e-4,))):
        for iso in ISOS:
            for exposure in exposures:
                flicker = rng.normal(0, 1e-3, 5)
                for channel, response in RESPONSE.items():
                    level = 64.0 + (900.0 * exposure / 0.03 * response if kind == "flat" else 0.0)
                    for frame in range(5):
                        mean = level * (1 + flicker[frame] * (kind == "flat")) + rng.normal(0, 2e-3)
                        points.append((kind, iso, exposure, channel, frame, mean))
    columns = {"kind": "", "iso": "1", "exposure_s": "s", "channel": "", "frame": "1", "mean": DN}
    return curve("frame_means", columns, points)


def _study() -> dict[str, object]:
    files = [
        {
            "path": f"PRNU_DSNU/ISO_{iso:g}/IMG_{index}.dng",
            "size": 9_310_212,
            "xxh3_128": f"{rng_hash:032x}",
            "kind": "flat",
            "iso": iso,
            "exposure_s": exposure,
        }
        for iso in ISOS
        for index, (exposure, rng_hash) in enumerate(zip(FLAT_EXPOSURES, range(1, 99), strict=False))
    ]
    return {
        "camera": {"name": "Google Pixel 4a (IMX363)", "base_iso": 55.0, "pixel_pitch_um": 1.4},
        "width": 2016,
        "height": 1512,
        "cfa": "BGGR",
        "bit_depth": 10,
        "black_level": {"values": [64, 64, 64, 64], "source": "metadata", "tag": "BlackLevel"},
        "white_level": {"values": [1023], "source": "metadata", "tag": "WhiteLevel"},
        "settings": {"iso": [], "tile": 64, "crop": None},
        "series": [{"kind": "flat", "iso": 55.0, "exposure_s": 0.002, "temperature_c": None, "frames": 5}],
        "files": files,
        "excluded": [{"path": "PRNU_DSNU/notes.dng", "code": "not-a-raw-file", "reason": "the file is plain text"}],
    }


def synthetic_results(seed: int = 1) -> Results:
    rng = np.random.default_rng(seed)
    findings = (
        Finding(
            code="file-truncated",
            severity=Severity.ERROR,
            message="the file ends 1 204 bytes early: it is left out, everything else is measured without it",
            files=("PRNU_DSNU/ISO_99/IMG_7.dng",),
        ),
        Finding(
            code="exposure-deviates",
            severity=Severity.WARNING,
            message="signal is not proportional to exposure at ISO 798: 0.002 s +1.3 % against the longer half",
        ),
        Finding(
            code="dark-current-resolution",
            severity=Severity.INFO,
            message="at ISO 55 these dark exposures can resolve a dark signal of 0.042 DN/s (95 %, all channels).",
        ),
    )
    dark, flat = _histograms(rng)
    return Results(
        study=_study(),
        rows=_rows(rng),
        findings=findings,
        curves=(
            _transfer(rng),
            _snr(),
            _dark_signal(rng),
            dark,
            flat,
            _response(rng),
            _read_noise(),
            _frame_means(rng),
            *pattern_curves(rng),
        ),
        run={
            "version": "0.1.0",
            "command": ["fullwell", "characterize", "data/pixel-4a", "-o", "out"],
            "study": "data/pixel-4a",
            "time": "2025-11-23T16:00:00+00:00",
        },
    )


def synthetic_pictures(seed: int = 2) -> Pictures:
    rng = np.random.default_rng(seed)
    differences = []
    for iso in ISOS:
        sigma = math.sqrt(2) * math.hypot(4.1 * gain_at(iso), 0.35)
        image = np.rint(rng.normal(0, sigma, (576, 768)) + rng.normal(0, 0.1 * sigma, (576, 1))).astype(np.int16)
        regions = []
        for name, x, y in (("centre", 320, 220), ("top left", 20, 20), ("bottom right", 620, 440)):
            codes, counts = np.unique(image[y : y + 128, x : x + 128], return_counts=True)
            std = float(image[y : y + 128, x : x + 128].std())
            regions.append(
                RegionHistogram(
                    name=name, x=x, y=y, width=128, height=128, codes=codes.astype(float), counts=counts, std_dn=std
                )
            )
        names = (f"ReadNoise/ISO_{iso:g}/IMG_0.dng", f"ReadNoise/ISO_{iso:g}/IMG_1.dng")
        differences.append(DifferencePicture(iso=iso, frames=names, image=image, regions=tuple(regions)))
    zoom = rng.normal(0, 0.4, (48, 64)).astype(np.float32)
    zoom[20, 30] = 9.0
    return Pictures(
        differences=tuple(differences),
        dark_zooms=(DarkZoom(iso=55.0, image=zoom, title="centre, 64 x 48 pixels"),),
        shading=shading_pictures(),
        shading_differences=shading_differences(),
        responses=response_pictures(),
    )
