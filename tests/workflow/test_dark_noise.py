"""Total dark noise: its error counts once what read noise and DSNU have in common."""

from pathlib import Path

import numpy as np
from scipy.stats import chi2

from fullwell.testing import simulation
from fullwell.workflow.loop.repeats import repeats_of, run_repeats
from fullwell.workflow.loop.tally import Tally

CAMERAS = 16
SHORTEST_S = 0.5
STUDY = {
    "isos": [100],
    "flat": {"exposures_s": [0.001, 0.004, 0.014], "electrons": [900.0, 3600.0, 12600.0], "frames": 2},
    "dark": {"exposures_s": [SHORTEST_S, 4.0], "frames": 2},
    "bias": {"exposures_s": [0.0001], "frames": 2},
}
CHANCE = 1e-3
"""Probability that a tool without fault fails."""


def test_total_dark_noise_scatters_as_its_errors_say(tmp_path: Path) -> None:
    config = simulation(seed=4000, camera={"width": 96, "height": 64}, study=STUDY)
    tally = Tally()
    for shares in run_repeats(
        repeats_of(config, CAMERAS + 1, folder=tmp_path, keep=False), workers=1, done=lambda: None
    ):
        tally.add(shares)
    chosen = [
        figure
        for figure in tally.ledgers
        if figure[0] == "total_dark_noise" and figure[1] != "all" and figure[3] == "DN" and figure[6] == SHORTEST_S
    ]
    pulls = np.concatenate([tally.pulls(figure) for figure in chosen])
    assert pulls.size == 4 * CAMERAS
    low, high = chi2.ppf([CHANCE / 2.0, 1.0 - CHANCE / 2.0], pulls.size)
    assert low < pulls @ pulls < high
