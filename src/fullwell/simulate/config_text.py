"""A config as TOML: what `config.parse_config` reads back as the same tables."""

import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Final, cast

from fullwell.simulate.config import SimulationConfig
from fullwell.simulate.pictures import SUFFIXES
from fullwell.simulate.tables import ConfigTable

_ONE_LINE: Final = 100
"""Width that a list or an inline table may take before it is broken [characters]."""


def config_text(table: ConfigTable) -> str:
    """Return a config as TOML, without what stands at its default.

    Examples
    --------
    >>> from fullwell.simulate.tables import CameraTable
    >>> print(config_text(ConfigTable(seed=7, camera=CameraTable(width=64, read_noise=1.5))), end="")
    seed = 7
    <BLANKLINE>
    [camera]
    width = 64
    read_noise = 1.5

    """
    document = cast("Mapping[str, object]", table.model_dump(exclude_defaults=True))
    lines = [f"seed = {table.seed}"]
    for name, section in document.items():
        if isinstance(section, Mapping):
            lines += ["", *_section(name, cast("Mapping[str, object]", section))]
    return "\n".join(lines) + "\n"


def self_contained(config: SimulationConfig, folder: str) -> tuple[ConfigTable, tuple[Path, ...]]:
    """Return a config whose files lie in a folder beside it, and where they lie now.

    Parameters
    ----------
    config
        The config.
    folder
        Name of the folder.

    """
    table = config.table
    files: list[Path] = []

    def beside(name: str) -> str:
        files.append(config.folder / name)
        return f"{folder}/{Path(name).name}"

    lens, chart, study = table.lens, table.chart, table.study
    if lens.shading not in {"none", "cos4"}:
        lens = lens.model_copy(update={"shading": beside(lens.shading)})
    if isinstance(chart.densities, str):
        chart = chart.model_copy(update={"densities": beside(chart.densities)})
    if chart.name is not None and chart.name.endswith(".toml"):
        chart = chart.model_copy(update={"name": beside(chart.name)})
    if study.scene is not None:
        subjects = [beside(one) if one.lower().endswith(SUFFIXES) else one for one in study.scene.subjects]
        study = study.model_copy(update={"scene": study.scene.model_copy(update={"subjects": subjects})})
    series = [
        one.model_copy(update={"subject": beside(one.subject)})
        if one.subject and one.subject.lower().endswith(SUFFIXES)
        else one
        for one in study.series
    ]
    study = study.model_copy(update={"series": series})
    told = table.model_copy(update={"lens": lens, "chart": chart, "study": study})
    return told, tuple(dict.fromkeys(files))


def _section(name: str, section: Mapping[str, object]) -> list[str]:
    """Return a table; lists of tables stand below it, each under a heading of its own."""
    plain = {key: value for key, value in section.items() if value is not None and not _tables(value)}
    lines = [f"[{name}]", *(f"{key} = {_value(value)}" for key, value in plain.items())]
    for key, value in section.items():
        for one in _tables(value):
            lines += ["", f"[[{name}.{key}]]", *(f"{word} = {_value(said)}" for word, said in one.items())]
    return lines


def _tables(value: object) -> list[Mapping[str, object]]:
    """Return a list of tables without what is None in them; an empty list for anything else."""
    if not isinstance(value, list):
        return []
    found = [cast("Mapping[str, object]", one) for one in cast("Sequence[object]", value) if isinstance(one, Mapping)]
    return [{word: said for word, said in one.items() if said is not None} for one in found]


def _value(value: object) -> str:
    if isinstance(value, Mapping):
        return (
            "{" + ", ".join(f"{key} = {_value(one)}" for key, one in cast("Mapping[str, object]", value).items()) + "}"
        )
    if isinstance(value, (list, tuple)):
        words = [_value(one) for one in cast("Sequence[object]", value)]
        flat = f"[{', '.join(words)}]"
        return flat if len(flat) <= _ONE_LINE else "[\n    " + ",\n    ".join(words) + ",\n]"
    if isinstance(value, float) and value.is_integer() and abs(value) < 1e15:
        return f"{value:.1f}"
    return json.dumps(value, ensure_ascii=False)
