"""What the loop starts from: a measurement, a camera's config, or figures that somebody stated."""

import json
from collections.abc import Mapping
from dataclasses import dataclass, fields, replace
from pathlib import Path
from typing import Final, cast

from fullwell.errors import UsageError
from fullwell.figures.results import Curve, Row
from fullwell.report.reading import read_document
from fullwell.simulate.config import CAMERAS, SimulationConfig, config_from, config_tables, shipped_config
from fullwell.workflow.model_figures import StatedFigures, models_of_figures
from fullwell.workflow.simulation.camera import SimulatedCamera, camera_from_models, camera_from_results

FIGURES: Final = "figures"
"""Table of a TOML file that states a noise model instead of a camera."""
DESIGN: Final = "design"


@dataclass(frozen=True, slots=True, kw_only=True)
class Source:
    """Where the loop starts.

    Parameters
    ----------
    name
        What was given.
    kind
        ``results``, ``config`` or ``figures``.
    config
        The camera, and the design it is measured in.
    rows, curves
        What was measured; empty where nothing was.
    said
        What was assumed where the source is silent, in sentences.

    """

    name: str
    kind: str
    config: SimulationConfig
    rows: tuple[Row, ...] = ()
    curves: tuple[Curve, ...] = ()
    said: tuple[str, ...] = ()


def source_of(what: Path) -> Source:
    """Read what the loop starts from.

    Parameters
    ----------
    what
        ``results.json`` or its folder, a config, a TOML file with a ``[figures]`` table, or the name of a camera that
        comes with Fullwell.

    Raises
    ------
    UsageError
        Where it is none of these, or describes no camera.

    """
    if what.is_dir() or what.suffix.lower() == ".json":
        return _results(what)
    if not what.exists() and str(what) in CAMERAS:
        return Source(name=str(what), kind="config", config=shipped_config(str(what)))
    if what.suffix.lower() != ".toml" or not what.is_file():
        raise UsageError(
            f"{what} is nothing to start from: give results.json or the folder that holds it, a CONFIG.toml, or one of "
            f"the cameras that come with Fullwell: {', '.join(CAMERAS)}."
        )
    return _toml(what)


def _results(path: Path) -> Source:
    """Read a results document; its folder stands for it."""
    document, results = read_document(path)
    made = camera_from_results(document, folder=path if path.is_dir() else path.parent)
    return Source(
        name=str(path), kind="results", config=made.config, rows=results.rows, curves=results.curves, said=made.said
    )


def _toml(path: Path) -> Source:
    document = config_tables(path)
    if FIGURES not in document:
        return Source(name=str(path), kind="config", config=config_from(document, name=str(path), folder=path.parent))
    made = _stated(path, document)
    return Source(name=str(path), kind="figures", config=made.config, said=made.said)


def _stated(path: Path, document: Mapping[str, object]) -> SimulatedCamera:
    """Return the camera that a ``[figures]`` table states, in a design of METHOD 9."""
    table = document[FIGURES]
    known = {field.name for field in fields(StatedFigures)} - {"noise_profile"}
    foreign = [f"{key}" for key in document if key not in {FIGURES, DESIGN, "seed"}]
    stated = cast("dict[str, object]", table) if isinstance(table, dict) else {}
    foreign += [f"{FIGURES}.{key}" for key in stated if key not in known]
    if foreign:
        raise UsageError(
            f"{path}: {foreign[0]} is not a key that is known. Allowed: seed, {DESIGN} and [{FIGURES}] with "
            f"{', '.join(sorted(known))}."
        )
    numbers = {key: float(value) for key, value in stated.items() if isinstance(value, (int, float))}
    wrong = next((key for key in stated if key not in numbers or isinstance(stated[key], bool)), None)
    if wrong is not None:
        raise UsageError(f"{path}: {FIGURES}.{wrong} = {json.dumps(stated[wrong], default=str)} is not a number.")
    seed = document.get("seed", 1)
    if not isinstance(seed, int) or isinstance(seed, bool) or not 0 <= seed < 2**63:
        raise UsageError(f"{path}: seed = {seed} cannot be used; allowed: a whole number from 0 to 2^63 - 1.")
    models = models_of_figures(replace(StatedFigures(), **numbers))  # pyright: ignore[reportArgumentType]
    return camera_from_models(models, design=str(document.get(DESIGN, "chart")), seed=seed)
