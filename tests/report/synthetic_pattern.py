"""Lens shading and fixed pattern of the synthetic study: rows, curves and pictures, made without any pixels."""

import math

import numpy as np
from synthetic_study import FLAT_EXPOSURES, ISOS, RESPONSE, curve, gain_at, row

from fullwell.figures.results import Curve, Row
from fullwell.report.pictures import ResponsePicture, ShadingDifferencePicture, ShadingPicture
from fullwell.units import DN, DN_PER_SECOND, ELECTRON, ELECTRON_PER_SECOND, ONE, PERCENT, Measured, square_root

PRNU = 0.7
MODELS = ("cos4", "radial", "poly44", "poly66", "p-spline", "legacy-poly22")
CORNERS = (0.42, 0.365, 0.372, 0.37, 0.3702, 0.31)
STUDY_CROP = "917,1505,1318,968"
WIDTH, HEIGHT = 2016, 1512


def tiles() -> list[tuple[int, int, int, int]]:
    return [(900 + 64 * (index % 4), 628 + 64 * (index // 4), 64, 64) for index in range(16)]


def _pattern_rows(rng: np.random.Generator, iso: float, channel: str) -> list[Row]:
    k = gain_at(iso)
    false = 1.3 * (iso / 55.0) ** 0.4
    rows = []
    for part, share in (("", 1.0), ("_row", 0.06), ("_column", -0.002), ("_pixel", 0.94)):
        variance = Measured.normal(share * PRNU**2 * (1 + rng.normal(0, 4e-3)), 4e-3 * PRNU**2, "%^2")
        flags = ("recommended",) if variance.value > 0 else ("recommended", "upper-limit")
        rows.append(
            row(f"prnu{part}", channel, "flat-dark-stack", square_root(variance, PERCENT), iso=iso, flags=flags)
        )
        for unit, factor in ((DN, 1.0), (ELECTRON, 1.0 / k)):
            dark = Measured.normal(share * (0.9 * k * factor) ** 2, 0.01 * (0.9 * k * factor) ** 2, f"{unit}^2")
            rows.append(row(f"dsnu{part}", channel, "dark-stack", square_root(dark, unit), iso=iso, flags=flags))
    rows.append(row("prnu", channel, "exposure-slope", Measured.normal(PRNU * 1.01, 0.02, PERCENT), iso=iso))
    legacy = channel.replace("G1", "G").replace("G2", "")
    if legacy:
        green = 0.72 if legacy == "G" else 1.0
        for method, quantity, value, unit in (
            ("legacy-slope-std", "prnu", false * green, PERCENT),
            ("legacy-intercept-std", "dsnu", 2.4 * k / 0.17 * green, DN),
        ):
            rows.append(row(quantity, legacy, method, Measured.exact(value, unit), iso=iso))
            rows.append(row(quantity, legacy, method, Measured.exact(1.6 * value, unit), iso=iso, region=STUDY_CROP))
    return rows


def pattern_rows(rng: np.random.Generator) -> list[Row]:
    rows = [one for iso in ISOS for channel in RESPONSE for one in _pattern_rows(rng, iso, channel)]
    rows += [
        row("prnu", "all", "legacy-slope-std", Measured.exact(25.0, PERCENT), iso=iso, region=STUDY_CROP)
        for iso in ISOS
    ]
    rows.append(row("dsnu", "all", "legacy-std-intercept", Measured.exact(3.3, DN), iso=55.0))
    for iso in ISOS:
        for channel in RESPONSE:
            dark = Measured.student(0.38 + rng.normal(0, 0.1), 0.12, 3.0, ELECTRON_PER_SECOND)
            rows.append(row("dark_current", channel, "mean-slope", dark, iso=iso, flags=("recommended",)))
            for exposure in FLAT_EXPOSURES:
                for model, corner in zip(MODELS, CORNERS, strict=True):
                    error = None if model.startswith("legacy") else 3e-4
                    for quantity, value in (
                        ("shading_corner", corner),
                        ("shading_edge_x", 0.5 + 0.5 * corner),
                        ("shading_edge_y", 0.65 + 0.35 * corner),
                        ("shading_residual_rms", 3e-4 + 0.1 * abs(corner - 0.37)),
                    ):
                        at = value * (1 + rng.normal(0, 3e-4))
                        measured = Measured.normal(at, error, ONE) if error else Measured.exact(at, ONE)
                        rows.append(row(quantity, channel, model, measured, iso=iso, exposure_s=exposure))
    return rows


def pattern_curves(rng: np.random.Generator) -> list[Curve]:
    profile, by_tile, regions, repeats, spread, same, legacy = [], [], [], [], [], [], []
    for iso in ISOS:
        k = gain_at(iso)
        for channel, response in RESPONSE.items():
            column = np.arange(0, 1008, 4)
            shape = (1 + ((column - 490) * 2.8e-3 / 4.38) ** 2) ** -2.0
            before = 800 * response * shape * (1 + rng.normal(0, 0.004, len(column)))
            profile += [
                (iso, 0.03, channel, int(x), one, one / at) for x, one, at in zip(column, before, shape, strict=True)
            ]
            by_tile += [(iso, channel, *tile, PRNU * (1 + rng.normal(0, 0.03)), 0.021) for tile in tiles()]
            sigma = math.hypot(4.1 * k, 0.35)
            regions += [
                (iso, channel, 504 * (i % 4), 378 * (i // 4), 504, 378, sigma * (1 + rng.normal(0, 2e-3)), sigma * 2e-3)
                for i in range(16)
            ]
        for channel, spread_of in (("all", 25.0), ("R", 1.4), ("G", 1.0), ("B", 1.4)):
            legacy += [(iso, channel, *tile, spread_of * (1 + rng.normal(0, 0.02))) for tile in tiles()]
        sigma = math.hypot(4.1 * k, 0.35)
        for repeat in range(1, 6):
            noise = sigma * (1 + rng.normal(0, 2e-3))
            repeats.append((iso, repeat, noise, noise * math.sqrt(0.8)))
    for exposure in FLAT_EXPOSURES:
        spread += [(55.0, exposure, 65.0 + 5200 * exposure + rng.normal(0, 0.3), 65.0 + 5200 * exposure)] * 5
    for quantity, unit, mean in (("prnu", PERCENT, 0.7), ("dsnu", ELECTRON, 0.9), ("dark_current", "e-/s", 0.38)):
        for channel, p_value in zip(RESPONSE, (0.41, 0.02, 1e-6, 0.8), strict=True):
            same.append((quantity, channel, unit, mean, 5.2, 5.0, p_value))
    place = {"x": "pixel", "y": "pixel", "width": "pixel", "height": "pixel"}
    at = {"iso": "1", "channel": ""}
    return [
        curve(
            "shading_profile",
            {"iso": "1", "exposure_s": "s", "channel": "", "column": "pixel", "before": DN, "after": DN},
            profile,
        ),
        curve("prnu_tiles", {**at, **place, "prnu": PERCENT, "std_error": PERCENT}, by_tile),
        curve("prnu_tiles_legacy", {**at, **place, "prnu": PERCENT}, legacy),
        curve("read_noise_regions", {**at, **place, "read_noise": DN, "std_error": DN}, regions),
        curve("read_noise_repeats", {"iso": "1", "repeat": "1", "flow1": DN, "flow2": DN}, repeats),
        curve("std_exposure", {"iso": "1", "exposure_s": "s", "std": DN, "fitted": DN}, spread),
        curve(
            "iso_constancy",
            {"quantity": "", "channel": "", "unit": "", "mean": "", "chi_square": "1", "dof": "1", "p_value": "1"},
            same,
        ),
    ]


def _shape(rows: np.ndarray, columns: np.ndarray, *, power: float = 2.0, tilt: float = 0.0) -> np.ndarray:
    y, x = (rows[:, None] - 390) * 2.8e-6 * 2, (columns[None, :] - 495) * 2.8e-6 * 2
    return (1 + (x**2 + y**2) / 4.38e-3**2) ** -power * (1 + tilt * x / 2.8e-3)


def shading_pictures(seed: int = 3) -> tuple[ShadingPicture, ...]:
    rng = np.random.default_rng(seed)
    rows, columns = np.linspace(6, 749, 48), np.linspace(6, 1001, 64)
    pictures = []
    for iso in ISOS:
        for exposure in FLAT_EXPOSURES:
            for index, (channel, response) in enumerate(RESPONSE.items()):
                normalized = _shape(rows, columns, power=1.8 + 0.05 * index, tilt=0.01 * (index - 1))
                normalized /= normalized.max()
                fitted = 900.0 * exposure / 0.03 * response * normalized
                measured = fitted * (1 + rng.normal(0, 1.5e-3, fitted.shape))
                measured[10, 20] = np.nan
                cos4 = _shape(rows, columns)
                polynomial = 1 - 0.9 * (1 - normalized)
                pictures.append(
                    ShadingPicture(
                        iso=iso,
                        exposure_s=exposure,
                        channel=channel,
                        model="p-spline" if index else "radial",
                        rows=rows,
                        columns=columns,
                        measured=measured,
                        fitted=fitted,
                        normalized=normalized,
                        residual=measured / fitted - 1,
                        cos4=cos4 / cos4.max(),
                        legacy=polynomial / polynomial.max(),
                    )
                )
    return tuple(pictures)


def shading_differences(seed: int = 4) -> tuple[ShadingDifferencePicture, ...]:
    rng = np.random.default_rng(seed)
    pictures = []
    for iso in ISOS:
        for exposure in FLAT_EXPOSURES:
            base = (iso, exposure) == (55.0, FLAT_EXPOSURES[0])
            smooth = np.add.outer(np.linspace(-1, 1, 30) ** 2, np.linspace(-1, 1, 40) ** 2)
            over = np.zeros((30, 40)) if base else rng.normal(0, 0.7) * smooth + rng.normal(0, 0.5, (30, 40))
            pictures.append(
                ShadingDifferencePicture(
                    iso=iso,
                    exposure_s=exposure,
                    base_iso=55.0,
                    base_exposure_s=FLAT_EXPOSURES[0],
                    difference=4e-4 * over,
                    over_error=over,
                    p_value=1.0 if base else float(rng.uniform() ** 3),
                )
            )
    return tuple(pictures)


def response_pictures(seed: int = 5) -> tuple[ResponsePicture, ...]:
    rng = np.random.default_rng(seed)
    pictures = []
    for iso in ISOS[:2]:
        for kind, edge in (("crop", 120), ("tile", 32)):
            x = np.linspace(-1, 1, edge)
            slope = 26000.0 * (1 - 0.04 * np.add.outer(x**2, x**2)) * (1 + rng.normal(0, 0.007, (edge, edge)))
            title = (
                f"slope of every pixel of G1 at 1360, 1028, {'central crop' if kind == 'crop' else 'one tile of it'}"
            )
            pictures.append(
                ResponsePicture(iso=iso, channel="G1", title=title, image=slope, unit=DN_PER_SECOND, kind=kind)
            )
    return tuple(pictures)
