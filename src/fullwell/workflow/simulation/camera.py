"""A camera that somebody measured or published becomes a config of the simulator, with the design it was measured in.

`camera_from_results` takes a results document: its sensor, its levels of light, its frames. `camera_from_models` takes
noise models however they were stated (k's, EMVA 1288's figures, DNG NoiseProfile); a chart or a study is then made up
around them. What the results could not tell is left at what disturbs least, and `SimulatedCamera.said` says so.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from fullwell.errors import UsageError
from fullwell.figures.noise_model import GivenModel, native_values
from fullwell.raw.cfa import ALL, MONO, channels
from fullwell.simulate.config import SimulationConfig, config_from
from fullwell.workflow.simulation.measured_design import measured_chart, measured_lens, measured_series, varied_light
from fullwell.workflow.simulation.measured_figures import Figures

DEFAULT_ISO: Final = 100
_ROOM: Final = 4.0
"""Full well over what the converter holds, where no measurement saw a pixel fill."""
_MOST_ELECTRONS: Final = 1e7
_CHART_STEP: Final = 0.2486
_CHART_PATCHES: Final = 36


@dataclass(frozen=True, slots=True, kw_only=True)
class SimulatedCamera:
    """A config, and what was assumed where its source was silent.

    Parameters
    ----------
    config
        The config.
    said
        Sentences.

    """

    config: SimulationConfig
    said: tuple[str, ...] = ()


def camera_from_results(
    document: Mapping[str, object], *, seed: int = 1, folder: Path | None = None
) -> SimulatedCamera:
    """Return the camera and the design of a results document.

    Parameters
    ----------
    document
        ``results.json``, as JSON has it.
    seed
        Another seed is another camera of the same make.
    folder
        Where the results lie: their shading maps, if any, become the lens. None for a lens that shades nothing.

    Raises
    ------
    UsageError
        Where the results hold no system gain, or no frames that could be simulated.

    """
    figures = Figures.of(document)
    isos = figures.isos or (None,)
    said: list[str] = []
    base = isos[0]
    camera = {
        "name": "Simulated camera",
        "width": figures.width,
        "height": figures.height,
        "cfa": figures.cfa,
        "bit_depth": max(figures.bit_depth, 8),
        "white_level": _white(figures, base),
        "base_iso": _whole(base),
        "full_well": _full_well(figures, base, said),
        "dark_current": max(figures.pooled("dark_current", "e-/s") or 0.0, 0.0),
        **_warmth(figures),
        **_prnu(figures),
        **_at(figures, base),
        **figures.facts,
    }
    camera["at_iso"] = [{"iso": _whole(iso), **_at(figures, iso)} for iso in isos[1:]]
    response = figures.response()
    if response:
        camera["channel_response"] = response
    lens = measured_lens(folder, iso=base)
    if lens is None:
        said.append("no shading map was measured; the lens shades nothing")
    series = measured_series(figures, default_iso=DEFAULT_ISO, brightness=1.0 if lens is None else lens.mean)
    if any(varied_light(figures, iso) for iso in isos):
        said.append("the light was varied at one exposure; its flats are exposed in proportion to their photons")
    if (figures.pooled("dark_current", "e-/s") or 0.0) < 0.0:
        said.append("the dark current came out below zero; none is simulated")
    chart, flare = measured_chart(figures)
    document_of_config: dict[str, object] = {
        "seed": seed,
        "camera": camera,
        "lens": {"flare": flare} if lens is None else {"flare": flare, "shading": str(lens.path)},
        "chart": chart,
        "study": {"series": series},
    }
    config = config_from(document_of_config, name="the measured camera", folder=Path())
    return SimulatedCamera(config=config, said=tuple(said))


def camera_from_models(models: Sequence[GivenModel], *, design: str = "chart", seed: int = 1) -> SimulatedCamera:
    """Return a noise model that somebody stated as a camera.

    Parameters
    ----------
    models
        From `workflow.model_figures` or `workflow.model_files`; of several channels the greenest speaks for all.
    design
        ``chart``: two exposures, 1 and 1/8, of 36 patches 0.2486 D apart, as METHOD 9 has them; ``study``: flats of
        twelve levels, darks and bias frames.
    seed
        Another seed is another camera of the same make.

    Raises
    ------
    UsageError
        Where the models describe no camera, or ``design`` is neither.

    """
    if design not in {"chart", "study"}:
        raise UsageError(f'There is no design "{design}"; there are chart and study.')
    model = next((one for one in models if one.channel in {ALL, "G", "G1", MONO}), models[0])
    native, conventions = native_values(model), model.conventions
    said: list[str] = []
    white = round(conventions.white_level or conventions.digital_maximum)
    bits = min(max(math.ceil(math.log2(white + 1)), 8), 16)
    black = conventions.black_level
    if black is None:
        black = float(2 ** (bits - 5))
        said.append(f"the black level is not known; {black:g} DN is taken")
    if native.read_e2 < 0.0:
        raise UsageError(
            "The noise in the dark is less than its parts (rounding, DSNU, dark current): no camera has these figures."
        )
    if native.dsnu_e2 is None:
        said.append("DSNU is not known; all of the noise in the dark is taken for read noise")
    reach = (white - black) / native.system_gain
    full_well = min(_ROOM * reach, _MOST_ELECTRONS)
    if native.saturation_dn is not None and native.saturation_dn < white - black - 1.0:
        full_well = native.saturation_dn / native.system_gain
    iso = DEFAULT_ISO if model.iso is None else _whole(model.iso)
    camera: dict[str, object] = {
        "name": "Simulated camera",
        "bit_depth": bits,
        "white_level": white,
        "black_level": black,
        "base_iso": iso,
        "system_gain": native.system_gain,
        "full_well": full_well,
        "read_noise": math.sqrt(native.read_e2),
        "dsnu": math.sqrt(native.dsnu_e2 or 0.0),
        "dark_current": native.dark_current or 0.0,
        "prnu": 100.0 * math.sqrt(max(native.fixed or 0.0, 0.0)),
    }
    end = min(full_well, reach)
    made = _chart_design(end) if design == "chart" else _study_design(end)
    document: dict[str, object] = {
        **made,
        "seed": seed,
        "camera": {**camera, **made["camera"]},
        "study": {**made["study"], "isos": [iso]},
    }
    return SimulatedCamera(config=config_from(document, name="the stated camera", folder=Path()), said=tuple(said))


def _chart_design(electrons: float) -> dict[str, dict[str, object]]:
    """Return a chart whose lightest patch comes to 93 % of saturation, and again to an eighth of that."""
    densities = [round(_CHART_STEP * number, 4) for number in range(_CHART_PATCHES)]
    return {
        "camera": {
            "width": 1152,
            "height": 576,
            "cfa": "RGGB",
            "channel_response": {"R": 0.306, "G1": 1.0, "G2": 1.0, "B": 0.606},
        },
        "chart": {"densities": densities, "columns": 9, "fill": 1.0, "margin": 0.0},
        "study": {
            "chart": {"exposures_s": [0.02, 0.0025], "electrons": [0.93 * electrons, 0.93 * electrons / 8.0]},
        },
    }


def _study_design(electrons: float) -> dict[str, dict[str, object]]:
    """Return flats from 5 % to 95 % of saturation and two beyond it, darks, and bias frames."""
    shares = [0.05, 0.15, 0.25, 0.35, 0.45, 0.55, 0.65, 0.75, 0.85, 0.95, 1.2, 1.5]
    return {
        "camera": {"width": 640, "height": 480, "cfa": MONO},
        "study": {
            "flat": {
                "exposures_s": [round(0.02 * share, 6) for share in shares],
                "electrons": [share * electrons for share in shares],
                "frames": 4,
            },
            "dark": {"exposures_s": [0.5, 1.0, 2.0, 4.0, 6.0, 8.0], "frames": 8},
            "bias": {"exposures_s": [0.0001], "frames": 8},
        },
    }


def _at(figures: Figures, iso: float | None) -> dict[str, object]:
    """Return what belongs to an ISO: system gain, black level and noise in electrons."""
    system_gain = figures.system_gain(iso)
    exposure_s = figures.shortest_unlit_s(iso)
    current = max(figures.pooled("dark_current", "e-/s") or 0.0, 0.0)
    row = max(figures.value("read_noise_row_variance", "e-^2", iso) or 0.0, 0.0)
    column = max(figures.value("read_noise_column_variance", "e-^2", iso) or 0.0, 0.0)
    read = figures.read_noise_variance(iso, system_gain=system_gain)
    return {
        "system_gain": system_gain,
        "black_level": _black(figures, iso),
        "read_noise": math.sqrt(max(read - row - column - current * exposure_s, 0.0)),
        "read_noise_row": math.sqrt(row),
        "read_noise_column": math.sqrt(column),
        **_dsnu(figures, iso),
    }


def _warmth(figures: Figures) -> dict[str, float]:
    """Return what doubles the dark current, and the temperature at which it was measured [K, degC]."""
    doubling = figures.pooled("dark_current_doubling", "K")
    at_c = next((row.temperature_c for row in figures.rows if row.quantity == "dark_current"), None)
    return (
        {}
        if doubling is None or at_c is None
        else {"dark_current_doubling_c": doubling, "dark_current_reference_c": at_c}
    )


def _dsnu(figures: Figures, iso: float | None) -> dict[str, float]:
    """Return the spread of pixels, rows and columns; the whole as that of pixels where no parts were measured [e-]."""
    parts = {part: figures.value(f"dsnu_{part}_variance", "e-^2", iso) for part in ("pixel", "row", "column")}
    return _parts("dsnu", parts, figures.value("dsnu_variance", "e-^2", iso))


def _prnu(figures: Figures) -> dict[str, float]:
    """Return the spread of responses likewise [%]."""
    parts = {part: figures.pooled(f"prnu_{part}_variance", "%^2") for part in ("pixel", "row", "column")}
    whole = figures.pooled("prnu_variance", "%^2")
    if whole is None:
        whole = 1e4 * (figures.pooled("k_fpn_variance", "1") or 0.0)
    return _parts("prnu", parts, whole)


def _parts(name: str, parts: Mapping[str, float | None], whole: float | None) -> dict[str, float]:
    if parts["pixel"] is None:
        return {name: math.sqrt(max(whole or 0.0, 0.0))}
    own = {part: math.sqrt(max(variance or 0.0, 0.0)) for part, variance in parts.items()}
    return {name: own["pixel"], f"{name}_row": own["row"], f"{name}_column": own["column"]}


def _black(figures: Figures, iso: float | None) -> list[float] | float:
    """Return the black level of every site; of all where they share it."""
    levels = [figures.level("black_level", channel, iso) for channel in channels(figures.cfa)]
    known = [level for level in levels if level is not None]
    if not known:
        return 0.0
    mean = sum(known) / len(known)
    return [mean if level is None else level for level in levels]


def _white(figures: Figures, iso: float | None) -> int:
    return min(round(figures.digital_maximum(iso)), 2**figures.bit_depth - 1)


def _full_well(figures: Figures, iso: float | None, said: list[str]) -> float:
    """Return the measured capacity, or more than the converter holds where no pixel was seen to fill [e-]."""
    measured = figures.saturation_capacity(iso)
    if measured is None:
        measured = figures.filled_below_converter(iso)
    if measured is not None:
        return min(measured, _MOST_ELECTRONS)
    said.append("no pixel was seen to fill; the full well is beyond the converter's reach")
    return min(_ROOM * _white(figures, iso) / figures.system_gain(iso), _MOST_ELECTRONS)


def _whole(iso: float | None) -> int:
    return DEFAULT_ISO if iso is None else max(round(iso), 1)
