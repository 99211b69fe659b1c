import numpy as np
import pytest
from scipy.stats import kstest

from fullwell.fit.black_level import METADATA_STD_ERROR, Evidence, declared, fuse, paule_mandel_std_error
from fullwell.fit.pooling import equal_mean, pool_channels, weighted_mean
from fullwell.units import DN, Measured


def _evidence(method, value, error, dof=None):
    return Evidence(method=method, measured=Measured.student(value, error, dof, DN))


def test_agreeing_evidence_is_weighted_and_covers():
    rng = np.random.default_rng(24)
    errors = np.array([0.01, 0.03, METADATA_STD_ERROR])
    covered, consistent = [], []
    for _ in range(2000):
        values = 64.0 + errors * rng.standard_normal(3)
        fused = fuse(
            [
                _evidence("dark-frames", values[0], errors[0]),
                _evidence("optical-black", values[1], errors[1]),
                _evidence("metadata", values[2], errors[2]),
            ]
        )
        consistent.append(fused.consistent)
        if fused.consistent:
            covered.append(fused.measured.ci95[0] <= 64.0 <= fused.measured.ci95[1])
    assert abs(np.mean(covered) - 0.951) <= 4.0 * np.sqrt(0.951 * 0.049 / len(covered))
    assert abs(np.mean(consistent) - 0.99) <= 4.0 * np.sqrt(0.99 * 0.01 / 2000)


def test_errors_with_few_degrees_of_freedom_neither_cry_wolf_nor_boast():
    """Dark frames with three degrees of freedom against a well-known level: Welch keeps the size, t the coverage."""
    rng = np.random.default_rng(25)
    pulls, rejected = [], []
    for _ in range(3000):
        dark_error = 0.01 * np.sqrt(rng.chisquare(3) / 3)
        fused = fuse(
            [
                _evidence("dark-frames", rng.normal(64.0, 0.01), dark_error, 3.0),
                _evidence("metadata", 64.0, METADATA_STD_ERROR),
            ]
        )
        rejected.append(not fused.consistent)
        pulls.append((fused.measured.value - 64.0) / fused.measured.std_error)
    assert np.mean(rejected) <= 0.01 + 4.0 * np.sqrt(0.01 * 0.99 / 3000)
    assert kstest(pulls, "t", args=(3,)).pvalue > 1e-3


def test_disagreement_prefers_what_identifies_the_offset():
    fused = fuse(
        [
            declared(66.0),
            _evidence("dark-frames", 64.0, 0.01),
            _evidence("exposure-bracket", 64.01, 0.01),
            _evidence("optical-black", 64.5, 0.01),
        ]
    )
    assert not fused.consistent
    assert fused.preferred == ("dark-frames", "exposure-bracket")
    assert fused.measured.value == pytest.approx(64.005)
    assert fused.random_effects_std_error > 10.0 * fused.measured.std_error
    assert fused.identified


def test_a_declared_level_alone_identifies_nothing():
    fused = fuse([declared(64.0)])
    assert not fused.identified
    assert fused.measured.std_error == pytest.approx(0.5 / np.sqrt(3.0))
    assert fused.preferred == ("metadata",)
    with pytest.raises(ValueError, match="at least one"):
        fuse([])


def test_paule_mandel_makes_q_its_expectation():
    measured = [Measured.normal(value, 0.01, DN) for value in (1.0, 1.2, 0.9)]
    error = paule_mandel_std_error(measured)
    assert error == pytest.approx(np.std([1.0, 1.2, 0.9], ddof=1) / np.sqrt(3.0), rel=1e-6)


def test_pooled_channels_cover_and_the_test_keeps_its_size():
    rng = np.random.default_rng(26)
    for dof in (None, 20.0, 3.0):
        covered, p_values = [], []
        for _ in range(2000):
            errors = np.array([0.1, 0.12, 0.1, 0.15])
            estimated = errors if dof is None else errors * np.sqrt(rng.chisquare(dof, 4) / dof)
            values = 5.0 + errors * rng.standard_normal(4)
            pooled, p_value = pool_channels(
                [Measured.student(value, error, dof, DN) for value, error in zip(values, estimated, strict=True)]
            )
            covered.append(pooled.ci95[0] <= 5.0 <= pooled.ci95[1])
            p_values.append(p_value)
        assert abs(np.mean(covered) - 0.95) <= 4.0 * np.sqrt(0.95 * 0.05 / 2000), dof
        assert np.mean(np.array(p_values) < 0.05) <= 0.05 + 4.0 * np.sqrt(0.05 * 0.95 / 2000), dof


def test_pooling_what_has_no_error():
    exact = [Measured.exact(1.0, DN), Measured.exact(3.0, DN)]
    assert pool_channels(exact) == (Measured.exact(2.0, DN), 1.0)
    one = Measured.normal(1.0, 0.1, DN)
    assert pool_channels([one]) == (one, 1.0)
    with pytest.raises(ValueError, match="standard error"):
        weighted_mean(exact)


def test_plain_mean():
    mean = equal_mean([Measured.student(1.0, 0.3, 4.0, DN), Measured.student(3.0, 0.4, 4.0, DN)])
    assert mean.value == 2.0
    assert mean.std_error == pytest.approx(0.25)
    assert mean.dof == pytest.approx(0.25**2 * 4.0 / (0.09**2 + 0.16**2))
