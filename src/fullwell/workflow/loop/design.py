"""The design a camera is measured in again: that of its study, on as few pixels as tell its figures."""

from dataclasses import dataclass, replace
from typing import Final

from fullwell.frames.chart.patches import Patch
from fullwell.simulate.config import SimulationConfig
from fullwell.simulate.plan import plan
from fullwell.simulate.tables import ChartTable, PatchTable

MOST_PIXELS: Final = 400_000
"""Pixels of a frame of flat light: a larger one is halved until it has no more."""
LARGEST_PATCH: Final = 100
"""Edge of a patch of a chart: 2500 pixels of each of four planes, as METHOD 1.6 counts [pixel]."""
_GAP: Final = 24
RULE: Final = (
    f"sides of a frame are halved until it has {MOST_PIXELS} pixels or fewer, with the same field of view; patches of "
    f"a chart are cut to {LARGEST_PATCH} x {LARGEST_PATCH} pixels and laid side by side; series, exposures and numbers "
    "of frames stay"
)


@dataclass(frozen=True, slots=True, kw_only=True)
class Design:
    """What is simulated, and how large its frames are beside those of the source.

    Parameters
    ----------
    config
        What is simulated.
    size, original_size
        Width and height of the frames, and of those of the source [pixel].
    frames
        Frames of one camera.

    """

    config: SimulationConfig
    size: tuple[int, int]
    original_size: tuple[int, int]
    frames: int

    @property
    def reduced(self) -> bool:
        """Whether the frames are smaller than those of the source."""
        return self.size != self.original_size


def design_of(config: SimulationConfig, *, full: bool) -> Design:
    """Return the design of a config: as large as it is, or reduced by `RULE`."""
    smaller = config if full else _reduced(config)
    return Design(
        config=smaller,
        size=_size(smaller),
        original_size=_size(config),
        frames=len(plan(smaller)),
    )


def _size(config: SimulationConfig) -> tuple[int, int]:
    return config.sensor.width, config.sensor.height


def _reduced(config: SimulationConfig) -> SimulationConfig:
    chart = config.chart
    if chart is None:
        while config.sensor.width * config.sensor.height > MOST_PIXELS:
            config = config.halved()
        return config
    grey = all(patch.density is not None for patch in chart.measured)
    large = any(max(patch.width, patch.height) > LARGEST_PATCH for patch in chart.measured)
    spread = config.sensor.width * config.sensor.height > 4 * sum(one.width * one.height for one in chart.measured)
    return _packed(config, chart.measured) if grey and (large or spread) and _in_focus(config) else config


def _in_focus(config: SimulationConfig) -> bool:
    """Tell whether a patch looks the same wherever it lies."""
    return config.lens.shading == "none"


def _packed(config: SimulationConfig, patches: tuple[Patch, ...]) -> SimulationConfig:
    """Lay patches, cut to size, side by side in a frame that just holds them."""
    pitch = _GAP + min(LARGEST_PATCH, max(max(one.width, one.height) for one in patches))
    columns = max(round((1.5 * len(patches)) ** 0.5), 1)
    rows = -(-len(patches) // columns)
    tables = [
        PatchTable(
            name=one.name,
            x=_GAP // 2 + at % columns * pitch,
            y=_GAP // 2 + at // columns * pitch,
            width=min(one.width, LARGEST_PATCH),
            height=min(one.height, LARGEST_PATCH),
            density=one.density,
        )
        for at, one in enumerate(patches)
    ]
    camera = config.table.camera.model_copy(update={"width": columns * pitch, "height": rows * pitch})
    chart = ChartTable(patches=tables, surround=config.table.chart.surround)
    return replace(config, table=config.table.model_copy(update={"camera": camera, "chart": chart}))
