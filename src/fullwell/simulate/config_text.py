"""A config as TOML: what `config.parse_config` reads back as the same tables."""

import json
from collections.abc import Mapping, Sequence
from typing import Final, cast

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
