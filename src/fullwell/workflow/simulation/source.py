"""Where a simulated camera comes from: a config, a camera that ships, or what somebody measured or stated.

`source_from` reads what ``fullwell simulate --from`` is given: results.json or its folder, a DNG with a NoiseProfile,
or figures by the names that `fullwell model` has for them: ``k_dark=1.672e-4,k_shot=5.554e-3,digital_maximum=16383``.
"""

from dataclasses import fields
from pathlib import Path
from typing import Final

from fullwell.errors import UsageError
from fullwell.report.reading import read_document
from fullwell.simulate.config import read_config, shipped_config
from fullwell.workflow.model_figures import StatedFigures, models_of_figures
from fullwell.workflow.model_files import models_of_file
from fullwell.workflow.simulation.camera import SimulatedCamera, camera_from_models, camera_from_results

_PROFILE: Final = "noise_profile"


def chosen_camera(
    *,
    config: Path | None = None,
    camera: str | None = None,
    source: str | None = None,
    design: str | None = None,
    seed: int | None = None,
) -> SimulatedCamera:
    """Return the one camera that is asked for.

    Parameters
    ----------
    config
        TOML file.
    camera
        Name of a config that ships.
    source
        As for `source_from`.
    design
        ``chart`` or ``study``, for figures alone.
    seed
        In place of the config's own.

    Raises
    ------
    UsageError
        Where none or several are asked for, or what is asked for cannot be used.

    """
    asked = [one for one in (config, camera, source) if one is not None]
    if len(asked) != 1:
        raise UsageError("Give one of CONFIG.toml, --camera NAME and --from SOURCE. --list shows the cameras.")
    if source is not None:
        made = source_from(source, design=design)
    elif design is not None:
        raise UsageError(f"--design {design} is for --from with figures; a config has a design of its own.")
    else:
        made = SimulatedCamera(config=read_config(config) if config else shipped_config(camera or ""))
    if seed is None:
        return made
    if not 0 <= seed < 2**63:
        raise UsageError(f"--seed {seed}: give a whole number from 0 to 2^63 - 1.")
    return SimulatedCamera(config=made.config.with_seed(seed), said=made.said)


def source_from(text: str, *, design: str | None = None) -> SimulatedCamera:
    """Return the camera that a file or figures describe.

    Parameters
    ----------
    text
        Path of a results document, its folder, or a DNG; or figures, ``name=value`` with commas between them. A
        NoiseProfile is ``noise_profile=S:O``, or ``S:O:S:O:...`` for several planes.
    design
        ``chart`` (None) or ``study``; results have a design of their own.

    Raises
    ------
    UsageError
        Where it describes no camera.

    """
    if "=" in text and not Path(text).exists():
        return camera_from_models(models_of_figures(_stated(text)), design=design or "chart")
    path = Path(text)
    if not path.is_dir() and path.suffix.lower() != ".json":
        return camera_from_models(models_of_file(path), design=design or "chart")
    if design is not None:
        raise UsageError(f"--design {design}: results have a design of their own; leave it out.")
    return camera_from_results(read_document(path)[0], folder=path if path.is_dir() else path.parent)


def _stated(text: str) -> StatedFigures:
    names = [field.name for field in fields(StatedFigures)]
    numbers: dict[str, float] = {}
    profile: tuple[tuple[float, float], ...] = ()
    for item in text.split(","):
        name, _, value = (part.strip() for part in item.partition("="))
        if name not in names:
            raise UsageError(f"--from {item}: there is no figure {name}; there are {', '.join(names)}.")
        if name == _PROFILE:
            profile = _pairs(value)
        else:
            numbers[name] = _number(name, value)
    return StatedFigures(**numbers, noise_profile=profile)


def _pairs(text: str) -> tuple[tuple[float, float], ...]:
    values = [_number(_PROFILE, one) for one in text.split(":")]
    if len(values) % 2:
        raise UsageError(f"--from {_PROFILE}={text}: give pairs, S:O or S:O:S:O:...")
    return tuple(zip(values[0::2], values[1::2], strict=True))


def _number(name: str, text: str) -> float:
    try:
        return float(text)
    except ValueError as error:
        raise UsageError(f"--from {name}={text}: give a number.") from error
