"""Shots of a chart as curves, rows and pictures, made from a noise model without any pixels."""

import math

import numpy as np
from synthetic_study import curve, row

from fullwell.figures.results import Curve, Results, Row
from fullwell.report.pictures import ChartPicture, Pictures, RenderedPoints
from fullwell.units import DECIBEL, DN, DN2, DN_PER_ELECTRON, ELECTRON, ONE, STOP, Measured

MAXIMUM = 16383.0
BLACK = 511.62
DARK, SHOT, FIXED = (1.672e-4 * MAXIMUM) ** 2, 5.554e-3**2 * MAXIMUM, 5.477e-3**2
RESPONSE = {"R": 0.306, "G1": 1.0, "G2": 1.0, "B": 0.606}
DENSITIES = 0.2486 * np.arange(36)
FLARE = 2.4e-4
DOF = 2494.0
Points = list[tuple[object, ...]]


def variance_at(signal: float) -> float:
    return DARK + SHOT * signal + FIXED * signal**2


def _points(rng: np.random.Generator, iso: float, ratios: tuple[float, ...]) -> tuple[Points, Points, Points]:
    points, tonal, bracket = [], [], []
    for number, ratio in enumerate(ratios):
        for channel, response in RESPONSE.items():
            for index, density in enumerate(DENSITIES):
                light = ratio * response * 14760.0 * (10.0**-density + FLARE)
                fitted = variance_at(light)
                signal = light + rng.normal(0.0, math.sqrt(fitted / 2500.0))
                residual = rng.normal()
                variance = fitted * (1.0 + residual * math.sqrt(2.0 / DOF))
                name, used = f"P{index + 1}", "no" if index == 1 and number == 0 and channel == "B" else "yes"
                error = variance * math.sqrt(2.0 / DOF)
                where = (iso, "a.dng", number, ratio / 50, 1, name, channel, density)
                judged = (fitted, None if used == "no" else residual, used)
                points.append((*where, signal + BLACK, signal, variance, error, DOF, None, 0.0, *judged))
                if number == 0:
                    inside = math.log10(signal / (MAXIMUM - BLACK)) if signal > 0.0 else None
                    pixel = math.log10((signal + BLACK) / MAXIMUM)
                    tonal.append((iso, channel, name, -density, pixel, inside, None if index in (0, 35) else 0.9))
                bracket.append((iso, "a.dng", channel, name, number, ratio, signal + BLACK, signal, residual, used))
    return points, tonal, bracket


def chart_curves(isos: tuple[float, ...] = (100.0,), ratios: tuple[float, ...] = (1.0, 0.125)) -> tuple[Curve, ...]:
    rng = np.random.default_rng(5)
    made = [_points(rng, iso, ratios) for iso in isos]
    points, tonal, bracket = ([line for one in made for line in one[part]] for part in range(3))
    models = [
        (iso, channel, DARK, SHOT, FIXED, BLACK, MAXIMUM, "highest code", 30.1, 33.0)
        for iso in isos
        for channel in (*RESPONSE, "all")
    ]
    head = {"iso": ONE, "scene": "", "exposure": ONE, "exposure_s": "s", "frames": ONE, "patch": "", "channel": ""}
    head |= {"density": ONE, "mean": DN, "signal": DN, "variance": DN2, "variance_std_error": DN2, "dof": ONE}
    head |= {"temporal_variance": DN2, "clipped": ONE, "fitted": DN2, "residual": ONE, "used": ""}
    model = {"iso": ONE, "channel": "", "dark": DN2, "shot": DN_PER_ELECTRON, "fixed_pattern": ONE, "black_level": DN}
    model |= {"digital_maximum": DN, "convention": "", "deviance": ONE, "deviance_dof": ONE}
    response = {"iso": ONE, "channel": "", "patch": "", "log_exposure": ONE, "log_pixel": ONE, "log_signal": ONE}
    exposures = {"iso": ONE, "scene": "", "channel": "", "patch": "", "exposure": ONE, "ratio": ONE, "mean": DN}
    return (
        curve("chart_points", head, points),
        curve("chart_noise_model", model, models),
        curve("chart_tonal_response", {**response, "slope": ONE}, tonal),
        curve("chart_bracket", {**exposures, "signal": DN, "residual": ONE, "used": ""}, bracket),
    )


def _channel_rows(iso: float, channel: str) -> list[Row]:
    best = ("recommended",)

    def one(quantity, method, measured, *flags, **others):
        return row(quantity, channel, method, measured, iso=iso, flags=tuple(sorted(flags)), **others)

    rows = [
        one("black_level", "fused", Measured.normal(BLACK, 0.006, DN), *best),
        one("black_level", "exposure-bracket", Measured.normal(BLACK, 0.006, DN)),
        one("black_level", "metadata", Measured.exact(512.0, DN)),
        one("black_level", "legacy-offset-ratio", Measured.exact(514.9, DN), "offset-not-identified"),
        one("system_gain", "photon-transfer", Measured.normal(SHOT, 0.002, DN_PER_ELECTRON), *best),
        one("read_noise", "noise-model", Measured.normal(5.4, 0.02, ELECTRON), "mixed", *best),
        one("saturation_capacity", "temporal-variance-peak", Measured.exact(14760.0, DN), "lower-bound", *best),
        one("saturation_capacity", "temporal-variance-peak", Measured.exact(29280.0, ELECTRON), "lower-bound", *best),
        one("saturation_capacity", "legacy-max-noise-patch", Measured.exact(29280.0, ELECTRON)),
        one("snr_max", "noise-model", Measured.exact(41.95, DECIBEL), "lower-bound", *best),
        one("camera_dynamic_range", "iso15739-like", Measured.exact(74.2, DECIBEL), *best),
        one("camera_dynamic_range", "iso15739-like", Measured.exact(68.6, DECIBEL), region="patch:P9"),
        one("flare", "density-fit", Measured.normal(FLARE, 2e-6, ONE), *best),
    ]
    for name, value in (("k_dark", 1.672e-4), ("k_shot", 5.554e-3), ("k_fpn", 5.477e-3)):
        rows.append(one(name, "gamma-likelihood", Measured.normal(value, 2e-3 * value, ONE), *best))
        published = Measured.exact(1.01 * value, ONE)
        rows += [one(name, f"legacy-imatest-{objective}", published) for objective in ("variance", "sigma")]
    for threshold, decibel in ((1.0, 73.83), (10.0**0.5, 62.13), (10.0, 47.45)):
        at = {"snr_threshold": threshold}
        for quantity, method, less in (
            ("dynamic_range", "noise-model", 0.0),
            ("camera_dynamic_range", "scene-referenced", 0.9),
        ):
            rows.append(one(quantity, method, Measured.normal(decibel - less, 0.01, DECIBEL), *best, **at))
            rows.append(one(quantity, method, Measured.normal((decibel - less) / 6.0206, 0.002, STOP), *best, **at))
        rows.append(one("dynamic_range", "legacy-patch", Measured.exact(decibel + 4.0, DECIBEL), **at))
    return rows


def chart_rows(isos: tuple[float, ...] = (100.0,)) -> tuple[Row, ...]:
    return tuple(one for iso in isos for channel in (*RESPONSE, "all") for one in _channel_rows(iso, channel))


def chart_results(isos: tuple[float, ...] = (100.0,), ratios: tuple[float, ...] = (1.0, 0.125)) -> Results:
    return Results(study={}, rows=chart_rows(isos), findings=(), curves=chart_curves(isos, ratios))


def chart_pictures(iso: float = 100.0) -> Pictures:
    image = np.full((240, 400, 3), 8, np.uint8)
    patches = []
    for index in range(36):
        x, y = 8.0 + 43.0 * (index % 9), 8.0 + 58.0 * (index // 9)
        image[int(y) : int(y) + 36, int(x) : int(x) + 36] = max(8, int(120 * 10 ** (-DENSITIES[index] / 2.2)))
        patches.append((f"P{index + 1}", x + 6.0, y + 6.0, 24.0, 24.0))
    rng = np.random.default_rng(6)
    mean = np.sort(rng.uniform(0.02, 1.0, (3, 36)), axis=1)
    noise = 0.01 * rng.uniform(0.3, 1.0, (3, 36))
    noise[0, 5] = np.nan
    return Pictures(
        charts=(
            ChartPicture(
                iso=iso,
                title="a.dng",
                image=image,
                patches=tuple(patches),
                confidence=0.87,
                corners=((2.0, 2.0), (398.0, 2.0), (398.0, 238.0), (2.0, 238.0)),
                left_out=("P1",),
            ),
        ),
        rendered=(RenderedPoints(iso=iso, file="scene.jpg", channels=("R", "G", "B"), mean=mean, noise=noise),),
    )
