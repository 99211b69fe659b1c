"""Pulls of every quantity of a full study, a new sensor for every seed: normal, whatever the degrees of freedom.

A few seeds here; a hundred were run when this was written, with bounds as METHOD 9 has them.
"""

from typing import Final

import numpy as np
import pytest

from fullwell.figures.calibration import normal_p_value
from fullwell.testing import simulation
from fullwell.workflow.loop.comparison import Figure
from fullwell.workflow.loop.repeats import repeats_of, run_repeats
from fullwell.workflow.loop.tally import Tally

SEEDS: Final = 12
ALL_CHANCE: Final = 1e-3
"""Probability that a tool without fault fails, over all quantities together (Bonferroni)."""
STUDY: Final = {
    "isos": [100],
    "flat": {"exposures_s": [0.001, 0.002, 0.004, 0.014], "electrons": [900.0, 1800.0, 3600.0, 12600.0], "frames": 4},
    "dark": {"exposures_s": [0.5, 1.0, 2.0, 4.0], "frames": 4},
    "bias": {"exposures_s": [0.0001], "frames": 8},
}
EXPECTED: Final = {
    ("black_level", "fused"),
    ("read_noise", "temporal-variance"),
    ("read_noise_row", "anova"),
    ("read_noise_column", "anova"),
    ("dark_current", "mean-slope"),
    ("dark_current", "variance-slope"),
    ("system_gain", "photon-transfer"),
    ("k_dark", "gamma-likelihood"),
    ("k_shot", "gamma-likelihood"),
    ("k_fpn", "gamma-likelihood"),
    ("dsnu", "dark-stack"),
    ("dsnu", "exposure-intercept"),
    ("prnu", "flat-dark-stack"),
    ("prnu", "exposure-slope"),
}


@pytest.fixture(scope="module")
def pulls(tmp_path_factory: pytest.TempPathFactory) -> dict[tuple[str, str], np.ndarray]:
    """Pulls by quantity and method over seeds and channels, in the native unit."""
    config = simulation(seed=4000, camera={"width": 256, "height": 192, "read_noise_column": 0.2}, study=STUDY)
    repeats = repeats_of(config, SEEDS + 1, folder=tmp_path_factory.mktemp("pulls"), keep=False)
    tally = Tally()
    for shares in run_repeats(repeats, workers=1, done=lambda: None):
        tally.add(shares)
    found: dict[tuple[str, str], list[np.ndarray]] = {}
    for figure in tally.ledgers:
        if _counts(figure):
            found.setdefault((figure[0], figure[2]), []).append(tally.pulls(figure))
    joined = {name: np.concatenate(parts) for name, parts in found.items()}
    return {name: part for name, part in joined.items() if part.size}


def _counts(figure: Figure) -> bool:
    quantity, channel, method, unit = figure[:4]
    native = {"dark_current": "DN/s", "system_gain": "DN/e-", "prnu": "%"}.get(quantity, "DN")
    unit_fits = unit == ("1" if quantity.startswith("k_") else native)
    return unit_fits and channel != "all" and method != "metadata" and not quantity.endswith("_variance")


def test_every_quantity_has_pulls(pulls: dict[tuple[str, str], np.ndarray]) -> None:
    assert set(pulls) >= EXPECTED
    assert all(pulls[name].size >= 4 * SEEDS for name in EXPECTED)


def test_pulls_are_normal(pulls: dict[tuple[str, str], np.ndarray]) -> None:
    p_values = {name: normal_p_value(part) or 0.0 for name, part in pulls.items()}
    assert not {name: p for name, p in p_values.items() if p < ALL_CHANCE / len(pulls)}


def test_pulls_have_no_mean(pulls: dict[tuple[str, str], np.ndarray]) -> None:
    means = {name: part.mean() for name, part in pulls.items()}
    assert not {name: mean for name, mean in means.items() if abs(mean) > 4.0 / np.sqrt(pulls[name].size)}
