import numpy as np
import pytest

from fullwell.fit.channel_ratios import channel_ratio
from fullwell.fit.flare import fit_flare

DENSITIES = 0.2486 * np.arange(36)
RESPONSE, FLARE = 15_000.0, 2.4e-4


def _shots(rng, sets, *, scatter=0.0, offset_error=0.0, n=2500):
    """Signals of one channel above an offset that errs, and the standard errors of the means."""
    density = DENSITIES + scatter * rng.standard_normal((sets, DENSITIES.size))
    light = RESPONSE * (10.0**-density + FLARE)
    error = np.sqrt((7.5 + 0.5 * light + 3e-5 * light**2) / n)
    wrong = offset_error * rng.standard_normal((sets, 1))
    return light + error * rng.standard_normal(light.shape) + wrong, error


@pytest.mark.parametrize(("scatter", "offset_error"), [(0.0, 0.0), (0.0, 0.02), (0.01, 0.006)])
def test_flare_comes_out_and_covers(scatter, offset_error):
    """Chart exact, or 0.01 density off; the offset exact or not: unbiased, pulls of unit width."""
    sets = 400
    rng = np.random.default_rng(240)
    signal, error = _shots(rng, sets, scatter=scatter, offset_error=offset_error)
    found = [
        fit_flare(s, e, DENSITIES, offset_std_error_dn=offset_error, identified=True)
        for s, e in zip(signal, error, strict=True)
    ]
    values = np.array([one.flare.value for one in found])
    assert abs(values.mean() - FLARE) <= 4.0 * values.std() / np.sqrt(sets)
    covered = np.mean([one.flare.ci95[0] <= FLARE <= one.flare.ci95[1] for one in found])
    assert covered >= 0.95 - 4.0 * np.sqrt(0.95 * 0.05 / sets), covered
    pulls = [(one.flare.value - FLARE) / one.flare.std_error for one in found]
    assert np.std(pulls) == pytest.approx(1.0, abs=0.2)
    response = [one.response.ci95[0] <= RESPONSE <= one.response.ci95[1] for one in found]
    assert np.mean(response) >= 0.95 - 4.0 * np.sqrt(0.95 * 0.05 / sets)
    if scatter:
        assert np.mean([one.density_scatter for one in found]) == pytest.approx(scatter, rel=0.1)
    else:
        assert np.mean([one.density_scatter for one in found]) < 0.002
    if offset_error:
        assert found[0].flare_at_offset.std_error < found[0].flare.std_error


@pytest.mark.parametrize(("tilt", "falloff", "scatter"), [(0.05, 0.0, 0.0), (0.05, 0.05, 0.005)])
def test_uneven_light_is_not_taken_for_flare(tilt, falloff, scatter):
    """Four rows of six patches, the dark ones below: light tilted by 5 % put flare 23 % too high."""
    sets, n = 200, 1800
    rng = np.random.default_rng(245)
    densities = 0.13 * np.arange(24)
    places = np.array([(number % 6, number // 6) for number in range(24)], np.float64)
    across, down = ((places - places.mean(axis=0)) / 5.0).T
    lit = (1.0 + tilt * (across + down)) / (1.0 + 4.0 * falloff * (across**2 + down**2))
    truth = FLARE / lit[0]
    found = []
    for density in densities + scatter * rng.standard_normal((sets, densities.size)):
        light = RESPONSE * (10.0**-density * lit + FLARE)
        error = np.sqrt((1.0 + 0.5 * light) / n)
        signal = light + error * rng.standard_normal(light.size)
        found.append(fit_flare(signal, error, densities, offset_std_error_dn=0.0, identified=True, places=places).flare)
    values = np.array([one.value for one in found])
    assert abs(values.mean() - truth) <= 4.0 * values.std() / np.sqrt(sets)
    covered = np.mean([one.ci95[0] <= truth <= one.ci95[1] for one in found])
    assert covered >= 0.95 - 4.0 * np.sqrt(0.95 * 0.05 / sets), covered


def test_patches_in_one_line_tell_no_surface_across_it():
    densities = 0.13 * np.arange(24)
    places = np.stack([np.arange(24.0), np.zeros(24)], axis=-1)
    light = RESPONSE * (10.0**-densities * np.linspace(1.0, 0.9, 24) + FLARE)
    found = fit_flare(light, np.full(24, 0.05), densities, offset_std_error_dn=0.0, identified=True, places=places)
    assert found.uneven
    assert found.dof == 24 - 4
    assert found.flare.value == pytest.approx(FLARE, rel=1e-4)


def test_flare_and_offset_add_alike():
    """An offset 3 DN too low is read as 3 DN of flare: so without an identified offset there is none."""
    rng = np.random.default_rng(241)
    signal, error = (part[0] for part in _shots(rng, 1))
    right, wrong = (
        fit_flare(signal + shift, error, DENSITIES, offset_std_error_dn=0.0, identified=True) for shift in (0.0, 3.0)
    )
    assert (wrong.flare.value - right.flare.value) * RESPONSE == pytest.approx(3.0, rel=1e-2)
    assert wrong.chi_square == pytest.approx(right.chi_square, abs=1e-3)
    with pytest.raises(ValueError, match="add alike"):
        fit_flare(signal, error, DENSITIES, offset_std_error_dn=0.29, identified=False)


def test_clipped_patches_still_name_the_lightest():
    light = RESPONSE * (10.0**-DENSITIES + FLARE)
    error = np.full(light.shape, 0.05)
    light[:4] = np.nan
    found = fit_flare(light, error, DENSITIES, offset_std_error_dn=0.0, identified=True)
    assert found.response.value == pytest.approx(RESPONSE, rel=1e-9)
    assert found.flare.value == pytest.approx(FLARE, rel=1e-6)


def test_charts_that_tell_nothing_are_refused():
    with pytest.raises(ValueError, match="three patches"):
        fit_flare([3.0, 2.0, 2.1], [0.1] * 3, [0.1, 0.5, 0.5], offset_std_error_dn=0.0, identified=True)
    with pytest.raises(ValueError, match="darker with density"):
        fit_flare([1.0, 20.0, 300.0], [0.1] * 3, [0.1, 1.5, 3.0], offset_std_error_dn=0.0, identified=True)


@pytest.mark.parametrize("tint", [0.0, 0.01])
def test_channel_ratio_covers(tint):
    """Patches that are neutral, and patches that are not quite."""
    sets, n, offset_error = 2000, 2500, 0.01
    rng = np.random.default_rng(242)
    light = RESPONSE * (10.0**-DENSITIES + FLARE)
    covered, values = [], []
    for _ in range(sets):
        one = 0.306 * light * (1.0 + tint * rng.standard_normal(light.size))
        shots = []
        for level in (one, light):
            variance = (7.5 + 0.5 * level) / n
            noise = np.sqrt(variance) * rng.standard_normal(level.size)
            shots += [level + noise + offset_error * rng.standard_normal(), variance]
        found = channel_ratio(*shots, offset_std_error_dn=offset_error)
        values.append(found.value)
        covered.append(found.ci95[0] <= 0.306 <= found.ci95[1])
    assert abs(np.mean(values) - 0.306) <= 4.0 * np.std(values) / np.sqrt(sets)
    assert np.mean(covered) >= 0.93, np.mean(covered)


def test_a_ratio_needs_a_reference():
    with pytest.raises(ValueError, match="reference"):
        channel_ratio([1.0], [0.1], [-1.0], [0.1])
    alone = channel_ratio([1.0], [0.01], [2.0], [0.01])
    assert alone.value == 0.5
    assert alone.std_error == pytest.approx(np.sqrt(0.01 + 0.25 * 0.01) / 2.0)
