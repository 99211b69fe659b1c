"""Tiles of a plane that hardly saw light: left out, never a reason to stop."""

from collections import Counter
from pathlib import Path

from fullwell.testing.studies import simulated_study, simulation
from fullwell.workflow.characterize import measure
from fullwell.workflow.options import Options

ELECTRONS = [0.5, 2.0]
"""Over a read noise of 30 e-: the surface of a tile of 64 pixels, known to some electrons, falls below zero in some."""


def test_tiles_without_light_leave_the_channel_out(tmp_path: Path) -> None:
    config = simulation(
        camera={"width": 1024, "height": 768, "read_noise": 30.0},
        study={
            "isos": [100],
            "flat": {"exposures_s": [0.001, 0.004], "electrons": ELECTRONS, "frames": 2},
            "dark": {"exposures_s": [0.002], "frames": 2},
        },
    )
    root = simulated_study(tmp_path / "study", config).root
    rows = measure(root, options=Options(workers=2)).results.rows
    named = (row for row in rows if row.region is not None)
    tiles = Counter(
        (row.quantity, row.channel) for row in named if row.method in {"exposure-slope", "exposure-intercept"}
    )
    # the crop and its sixteen tiles, or nothing: PRNU is a share of light that some tiles do not show, DSNU is not
    prnu, dsnu = (
        [number for (found, _), number in tiles.items() if found == quantity] for quantity in ("prnu", "dsnu")
    )
    assert (set(prnu) | {17}, dsnu) == ({17}, [17] * 4)
    assert len(prnu) < 4
