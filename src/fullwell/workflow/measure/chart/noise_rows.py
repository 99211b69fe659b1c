"""Rows of the noise model: system gain, k's and read noise, per channel and of all (METHOD 1)."""

import math
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from fullwell.figures.results import Row
from fullwell.findings import Finding, Severity
from fullwell.fit.chart_noise import SharedModel
from fullwell.fit.noise_coefficients import NoiseCoefficientFit, boundary_variance, k_coefficients
from fullwell.fit.pooling import pool_channels
from fullwell.fit.unidentified_offset import offset_range, unidentified_dark
from fullwell.raw.cfa import ALL
from fullwell.units import DN, DN2, DN_PER_ELECTRON, ELECTRON, ELECTRON2, ONE, Measured
from fullwell.workflow.measure.chart.levels import ChartLevels
from fullwell.workflow.measure.chart.noise_model import ChartModel
from fullwell.workflow.measure.chart.shots import Shots
from fullwell.workflow.measure.section import RowWriter, Section

METHOD = "gamma-likelihood"
NAMES = ("k_dark", "k_shot", "k_fpn")
DIFFER = 0.01
"""p-value below which channels are said not to share their noise model."""
HALF_A_CODE = 0.5
"""Reach of a declared black level to either side [DN]."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Flags:
    """Flags of each figure of one channel, or of all."""

    k_dark: frozenset[str]
    k_shot: frozenset[str]
    k_fpn: frozenset[str]

    def of(self, name: str) -> frozenset[str]:
        """Return those of one coefficient."""
        return {"k_dark": self.k_dark, "k_shot": self.k_shot, "k_fpn": self.k_fpn}[name]


def noise_rows(shots: Shots, levels: ChartLevels, models: Sequence[ChartModel], shared: SharedModel | None) -> Section:
    """Write the noise model of every channel, and of all where they were fitted together.

    Parameters
    ----------
    shots, levels
        What was measured.
    models
        Of the channels, and that of ``all`` at the end where there is one.
    shared
        What the latter was found to be worth.

    """
    differ = _differing(models, shared)
    rows: list[Row] = []
    for model in models:
        flags = _flags(shots, levels, model, differ if model.channel == ALL else frozenset())
        ks = coefficients_of(levels, model)
        rows += _gain_rows(shots, model, flags)
        rows += _k_rows(shots, model, ks, flags)
        rows += _read_noise_rows(shots, levels, model, flags)
    return Section(rows=tuple(rows), findings=_findings(shots, levels, models, shared, differ))


def coefficients_of(levels: ChartLevels, model: ChartModel) -> NoiseCoefficientFit:
    """Return the k's of a model; without an identified black level k_dark holds all that it might be (METHOD 2.4)."""
    black = levels.of(model.channel)
    fitted = k_coefficients(
        model.coefficients,
        model.covariance,
        digital_maximum=levels.digital_maximum,
        dof=model.fit.dof,
        offset_std_error_dn=black.error_dn,
        offset_dof=black.level.dof,
    )
    if black.identified:
        return fitted
    dark = unidentified_dark(
        model.coefficients,
        model.covariance,
        shifts_dn=(-_reach(black.error_dn), _reach(black.error_dn)),
        digital_maximum=levels.digital_maximum,
        dof=model.fit.dof,
    )
    return replace(fitted, k_dark=dark.k_dark, k_dark_variance=dark.k_dark_variance)


def _reach(error_dn: float) -> float:
    """Return half the width of the uniform law that a standard error stands for."""
    return max(math.sqrt(3.0) * error_dn, HALF_A_CODE)


def _differing(models: Sequence[ChartModel], shared: SharedModel | None) -> frozenset[str]:
    """Return the coefficients that the channels do not share: C alone where that explains it (METHOD 1.10)."""
    if shared is None or shared.p_value >= DIFFER:
        return frozenset()
    if shared.physical_p_value >= DIFFER:
        return frozenset({"k_fpn"})
    apart: set[str] = set()
    for index, name in enumerate(NAMES):
        own = [
            Measured.normal(float(one.coefficients[index]), float(one.covariance[index, index]) ** 0.5, ONE)
            for one in models
            if one.channel != ALL
        ]
        if pool_channels(own)[1] < DIFFER:
            apart.add(name)
    return frozenset(apart or NAMES)


def _flags(shots: Shots, levels: ChartLevels, model: ChartModel, differ: Collection[str]) -> Flags:
    common = {"model-misfit"} if model.fit.misfit else set[str]()
    own: Mapping[str, set[str]] = {
        "k_dark": set() if levels.of(model.channel).identified else {"offset-not-identified"},
        "k_shot": set(),
        "k_fpn": set() if shots.has_bursts else {"mixed"},
    }
    marked = {
        name: frozenset(own[name] | common | ({"channels-differ"} if name in differ else set())) for name in NAMES
    }
    return Flags(**marked)


def _gain_rows(shots: Shots, model: ChartModel, flags: Flags) -> tuple[Row, ...]:
    if model.coefficients[1] <= 0.0:
        return ()
    measured = Measured.student(
        float(model.coefficients[1]), float(model.covariance[1, 1]) ** 0.5, model.fit.dof, DN_PER_ELECTRON
    )
    return (
        RowWriter(bursts=shots.bursts).row(
            "system_gain",
            model.channel,
            "photon-transfer",
            measured,
            source="METHOD 1.4" if shots.has_bursts else "METHOD 1.2",
            n=model.n,
            flags=flags.k_shot,
            recommended=True,
        ),
    )


def _k_rows(shots: Shots, model: ChartModel, ks: NoiseCoefficientFit, flags: Flags) -> tuple[Row, ...]:
    write = RowWriter(bursts=shots.bursts).root_and_variance
    variances = (ks.k_dark_variance, ks.k_shot_variance, ks.k_fpn_variance)
    return tuple(
        row
        for name, variance in zip(NAMES, variances, strict=True)
        for row in write(
            name,
            model.channel,
            METHOD,
            variance,
            ONE,
            source="METHOD 1.4" if shots.has_bursts else "METHOD 1.2",
            n=model.n,
            flags=flags.of(name),
        )
    )


def _read_noise_rows(shots: Shots, levels: ChartLevels, model: ChartModel, flags: Flags) -> tuple[Row, ...]:
    """Return the noise in the dark without quantization; only bursts leave the fixed pattern of the dark out of it."""
    dark = model.fit.coefficients[0] - shots.step_dn**2 / 12.0
    covariance = model.fit.covariance[:2, :2].copy()
    shot = float(model.coefficients[1])
    covariance[0, 0] += (shot * levels.of(model.channel).error_dn) ** 2
    marks = flags.k_dark | (set() if shots.has_bursts else {"mixed"})
    write = RowWriter(bursts=shots.bursts).root_and_variance
    rows = [
        *write(
            "read_noise",
            model.channel,
            "noise-model",
            boundary_variance(float(dark), float(covariance[0, 0]) ** 0.5, dof=model.fit.dof, unit=DN2),
            DN,
            source="METHOD 1.2",
            n=model.n,
            flags=marks,
        )
    ]
    if shot > 0.0:
        gradient = np.array([1.0 / shot**2, -2.0 * dark / shot**3])
        error = float(gradient @ covariance @ gradient) ** 0.5
        electrons = boundary_variance(float(dark) / shot**2, error, dof=model.fit.dof, unit=ELECTRON2)
        rows += write(
            "read_noise",
            model.channel,
            "noise-model",
            electrons,
            ELECTRON,
            source="METHOD 1.2",
            n=model.n,
            flags=marks,
        )
    return tuple(rows)


def _findings(
    shots: Shots,
    levels: ChartLevels,
    models: Sequence[ChartModel],
    shared: SharedModel | None,
    differ: Collection[str],
) -> tuple[Finding, ...]:
    findings = [*_offset_findings(shots, levels, models), *_misfit_findings(shots, models)]
    if shared is not None and differ:
        which = ", ".join(name for name in NAMES if name in differ)
        why = (
            "read noise and system gain are shared, the fixed pattern is each channel's own"
            if set(differ) == {"k_fpn"}
            else "read noise and system gain belong to the circuit, so look for a digital scaling of the raw values"
        )
        message = (
            f"the channels at {shots.bursts.label} do not share one noise model (p = {shared.p_value:.2g}; with a "
            f"fixed pattern for each p = {shared.physical_p_value:.2g}): {which} differ; {why}"
        )
        findings.append(Finding(code="channels-differ", severity=Severity.WARNING, message=message))
    elif shared is not None:
        message = f"the channels at {shots.bursts.label} share one noise model (p = {shared.p_value:.2g})"
        findings.append(Finding(code="channels-agree", severity=Severity.INFO, message=message))
    if not shots.has_bursts:
        message = (
            "one frame at each exposure: temporal noise and fixed pattern cannot be told apart, so k_fpn is an upper "
            "bound of the PRNU (texture of the chart is in it) and the dark noise holds the DSNU; take several frames "
            "at one exposure"
        )
        findings.append(Finding(code="single-chart-frames", severity=Severity.INFO, message=message))
    else:
        message = (
            "k_fpn holds the chart's texture beside the PRNU; two framings of the chart, shifted by three pixels or "
            "more (--separate), tell them apart"
        )
        findings.append(Finding(code="texture-in-fixed-pattern", severity=Severity.INFO, message=message))
    return tuple(findings)


def _offset_findings(shots: Shots, levels: ChartLevels, models: Sequence[ChartModel]) -> tuple[Finding, ...]:
    """Say by how much k_dark moves with the black level where nothing identifies it (METHOD 2.1, 2.4)."""
    if not models or levels.of(models[-1].channel).identified:
        return ()
    model = models[-1]
    black = levels.of(model.channel)
    if model.coefficients[0] <= 0.0:
        said = "the noise in the dark comes out at or below zero"
    elif model.coefficients[1] <= 0.0:
        said = "the noise does not grow with the signal as that of photons does: no level makes sense of the patches"
    else:
        dark = math.sqrt(float(model.coefficients[0])) / levels.digital_maximum
        relative = float(model.coefficients[1] / (2.0 * model.coefficients[0]))
        points = [point for channel in shots.channels for point in shots.points(channel) if point.admitted]
        darkest = min(point.mean_dn for point in points) - black.level.value
        low, high = offset_range(model.coefficients, darkest_dn=darkest)
        said = (
            f"dk_dark/doffset = {dark * relative:.3g} per DN ({100.0 * relative:.2f} % per DN), and every level from "
            f"{black.level.value + low:.1f} to {black.level.value + high:.1f} DN fits as well"
        )
    message = (
        f"the black level at {shots.bursts.label} is not identified: no noise measurement of one exposure can tell it. "
        f"With {black.level.value:.2f} DN, {said}; k_dark and read noise are intervals, no more. Add a shot three to "
        "four stops under, dark frames, or give it with --black"
    )
    return (Finding(code="offset-not-identified", severity=Severity.WARNING, message=message),)


def _misfit_findings(shots: Shots, models: Sequence[ChartModel]) -> tuple[Finding, ...]:
    misfits = [model for model in models if model.fit.misfit]
    findings: list[Finding] = []
    if misfits:
        worst = max(model.fit.deviance / model.fit.deviance_dof for model in misfits)
        message = (
            f"the noise model does not fit {', '.join(model.channel for model in misfits)} at {shots.bursts.label} "
            f"(deviance per degree of freedom up to {worst:.3g}): errors are scaled up; look at the residuals"
        )
        findings.append(Finding(code="noise-model-misfit", severity=Severity.WARNING, message=message))
    dropped = {model.channel: int((~model.fit.used).sum()) for model in models if model.channel != ALL}
    if any(dropped.values()):
        said = ", ".join(f"{count} of {channel}" for channel, count in dropped.items() if count)
        message = (
            f"variances that do not belong to the curve were left out at {shots.bursts.label}: {said}; dust, texture "
            "or an edge inside a patch does that"
        )
        findings.append(Finding(code="outlier-patches", severity=Severity.INFO, message=message))
    return tuple(findings)
