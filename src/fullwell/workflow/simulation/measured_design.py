"""The design of a measured study: its series with their light, and the chart it looked at."""

import math
import statistics
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final, cast

from fullwell.raw.cfa import MONO
from fullwell.workflow.shading.saved import map_files, saved_maps, suitable_map
from fullwell.workflow.simulation.measured_figures import Figures, Light

_SHORTEST_S: Final = 1e-6
"""Exposure of bias frames whose files do not tell it."""
_DARKEST: Final = 6.0
"""Density of a patch whose signal is lost in its noise."""

Entry = dict[str, object]


@dataclass(frozen=True, slots=True, kw_only=True)
class MeasuredLens:
    """A shading map that was measured.

    Parameters
    ----------
    path
        The file.
    mean
        Relative illumination of G1 or the one channel, over the plane [1].

    """

    path: Path
    mean: float


def measured_lens(folder: Path | None, *, iso: float | None) -> MeasuredLens | None:
    """Return the map that suits an ISO best of those beside the results; None where there is none."""
    files = [] if folder is None else map_files(folder)
    if folder is None or not files:
        return None
    chosen = suitable_map(saved_maps(folder), iso=iso)
    leading = next((one for one in chosen.channels if one.channel in {"G1", MONO}), chosen.channels[0])
    path = next(file for file in files if file.stem == chosen.stem)
    return MeasuredLens(path=path.resolve(), mean=float(leading.normalized.mean()))


def measured_series(figures: Figures, *, default_iso: int, brightness: float = 1.0) -> list[Entry]:
    """Return every series that was measured, as ``[[study.series]]`` has them; scenes are left out.

    Parameters
    ----------
    figures
        The results.
    default_iso
        What frames that tell no ISO are given.
    brightness
        Mean over the plane of what the lens lets through where it lets through most [1].

    """
    found: list[Entry] = []
    for one in figures.series:
        kind, frames = str(one["kind"]), int(cast("int", one["frames"]))
        iso = cast("float | None", one["iso"])
        light = _light_of(one)
        electrons = _electrons(figures, kind, iso, light)
        if kind == "scene" or frames < 1 or iso not in figures.isos or electrons is None:
            continue
        entry: Entry = {
            "kind": kind,
            "iso": default_iso if iso is None else max(round(iso), 1),
            "exposure_s": _exposure_s(figures, kind, iso, light),
            "frames": frames,
        }
        if one.get("temperature_c") is not None:
            entry["temperature_c"] = one["temperature_c"]
        if electrons:
            entry["electrons"] = electrons / (brightness if kind == "flat" else 1.0)
        found.append(entry)
    return found


def varied_light(figures: Figures, iso: float | None) -> Sequence[float]:
    """Return the photons of the flats at an ISO where some have the exposure in common; none where none have [p]."""
    lights = [_light_of(one) for one in figures.series if one["kind"] == "flat" and one["iso"] == iso]
    photons = [each for _, each in lights if each]
    shared = len({exposure_s for exposure_s, _ in lights}) < len(lights)
    return photons if shared and len(set(photons)) == len(lights) else ()


def _light_of(series: Mapping[str, object]) -> Light:
    return float(cast("float", series["exposure_s"] or _SHORTEST_S)), cast("float | None", series.get("photons"))


def _exposure_s(figures: Figures, kind: str, iso: float | None, light: Light) -> float:
    """Return the exposure of a series: of flats whose light was varied the longest, in proportion to the light."""
    exposure_s, photons = light
    every = varied_light(figures, iso) if kind == "flat" else ()
    if not every or photons is None:
        return exposure_s
    longest = max(_light_of(one)[0] for one in figures.series if one["kind"] == "flat" and one["iso"] == iso)
    return longest * photons / max(every)


def _electrons(figures: Figures, kind: str, iso: float | None, light: Light) -> float | None:
    """Return the electrons of a series at response 1: 0 in the dark, None where nobody knows them [e-]."""
    if kind == "flat":
        return flat_electrons(figures, iso, light)
    return chart_electrons(figures, iso, light[0]) if kind == "chart" else 0.0


def flat_electrons(figures: Figures, iso: float | None, light: Light) -> float | None:
    """Return what a flat exposure came to in G1 or the one channel [e-].

    Exposures that clip are told by those that do not, in proportion to their photons or else their time; None without
    any.
    """
    signals = {one: dn for (name, one), dn in figures.signals(iso).items() if name in {"G1", MONO}}
    if not signals:
        return None
    system_gain = figures.system_gain(iso)
    if light in signals:
        return max(signals[light], 0.0) / system_gain
    by_photons = light[1] is not None and all(photons for _, photons in signals)

    def amount(of: Light) -> float:
        exposure_s, photons = of
        return (photons or 0.0) if by_photons else exposure_s

    rate = statistics.median(dn / amount(one) for one, dn in signals.items())
    return max(rate * amount(light), 0.0) / system_gain


def chart_electrons(figures: Figures, iso: float | None, exposure_s: float) -> float | None:
    """Return what a perfect white would have come to in G1 or the one channel in a shot of the chart [e-]."""
    lights = _patch_lights(figures)
    whites = [
        signal / lights[patch]
        for (name, at, seconds, patch), signal in figures.patch_signals().items()
        if name in {"G1", MONO} and at == iso and seconds == exposure_s and lights.get(patch, 0.0) > 0.0
    ]
    return statistics.median(whites) / figures.system_gain(iso) if whites else None


def measured_chart(figures: Figures) -> tuple[Entry, float]:
    """Return the chart of a study as ``[chart]`` has it, and the flare; an empty table where there was none.

    With every density known and a flare measured, both are taken as they are, the flare as a share of a perfect white
    and not of the lightest patch. Else the densities are those that the signals amount to, with flare and lens in them.
    """
    patches = cast("Sequence[Mapping[str, object]]", figures.study.get("patches", ()))
    if not patches:
        return {}, 0.0
    first = patches[0]["scene"]
    own = [patch for patch in patches if patch["scene"] == first]
    flare = _flare(figures, own)
    stated = flare is not None
    lights = _patch_lights(figures)
    tables: list[Entry] = []
    for patch in own:
        density = cast("float", patch["density"]) if stated else _density(lights.get(str(patch["name"]), 0.0))
        tables.append({**{key: patch[key] for key in ("name", "x", "y", "width", "height")}, "density": density})
    return {"patches": tables}, min(max(flare or 0.0, 0.0), 0.999) if stated else 0.0


def _patch_lights(figures: Figures) -> Mapping[str, float]:
    """Return the light of each patch relative to a perfect white, or to the lightest patch where densities lack."""
    patches = cast("Sequence[Mapping[str, object]]", figures.study.get("patches", ()))
    flare = _flare(figures, patches)
    if flare is not None:
        return {str(one["name"]): 10.0 ** -cast("float", one["density"]) + flare for one in patches}
    signals = figures.patch_signals()
    leading = [key for key in signals if key[0] in {"G1", MONO}]
    brightest = {key[1:3]: max(signals[one] for one in leading if one[1:3] == key[1:3]) for key in leading}
    lights: dict[str, list[float]] = {}
    for key in leading:
        lights.setdefault(key[3], []).append(signals[key] / brightest[key[1:3]])
    return {patch: statistics.median(found) for patch, found in lights.items()}


def _flare(figures: Figures, patches: Sequence[Mapping[str, object]]) -> float | None:
    """Return stray light relative to a perfect white; None where it was not measured or a density is not known [1]."""
    flare = figures.pooled("flare", "1")
    if flare is None or any(patch["density"] is None for patch in patches):
        return None
    return flare * 10.0 ** -min(cast("float", patch["density"]) for patch in patches)


def _density(light: float) -> float:
    return min(-math.log10(light), _DARKEST) if light > 10.0**-_DARKEST else _DARKEST
