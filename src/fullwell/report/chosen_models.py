"""Which shading model was chosen for each plane: told by the curve of all models, or by the pictures."""

from collections.abc import Mapping, Sequence
from typing import TypeAlias

from fullwell.figures.results import Curve
from fullwell.report.curves import table_named
from fullwell.report.pictures import ShadingPicture

Chosen: TypeAlias = Mapping[tuple[float | None, float, str], str]
"""Name of the model by ISO, exposure [s] and channel."""


def chosen_models(curves: Sequence[Curve], pictures: Sequence[ShadingPicture]) -> Chosen:
    """Return the model of every plane of every burst that one was chosen for."""
    chosen = {(one.iso, one.exposure_s, one.channel): one.model for one in pictures}
    table = table_named(curves, "shading_models")
    if table is None:
        return chosen
    columns = (table.values(name) for name in ("iso", "exposure_s", "channel", "model", "chosen"))
    for iso, exposure_s, channel, model, said in zip(*columns, strict=True):
        if said == "yes" and isinstance(exposure_s, (int, float)):
            known = float(iso) if isinstance(iso, (int, float)) else None
            chosen[(known, float(exposure_s), str(channel))] = str(model)
    return chosen
