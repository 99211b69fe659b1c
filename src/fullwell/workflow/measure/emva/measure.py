"""One ISO evaluated by a profile: every channel is a camera of its own."""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace

from fullwell.errors import UsageError
from fullwell.figures.emva1288.spline_gate import LIMIT
from fullwell.figures.results import Row
from fullwell.findings import Finding, Severity
from fullwell.frames.series import Study
from fullwell.glossary import RECOMMENDED
from fullwell.workflow.measure.bursts import IsoBursts
from fullwell.workflow.measure.emva.curves import package_curves, sweep_curves
from fullwell.workflow.measure.emva.linear import LinearFits, fit_linear
from fullwell.workflow.measure.emva.linear_rows import linear_rows, missing
from fullwell.workflow.measure.emva.package_rows import evaluate_package, package_rows, why_not
from fullwell.workflow.measure.emva.spatial_curves import spatial_curves
from fullwell.workflow.measure.emva.spatial_rows import filtered_rows, package_spatial_rows
from fullwell.workflow.measure.emva.stacks import Stacks, averages, choose_stacks, pattern_of
from fullwell.workflow.measure.emva.steps import sweep_findings, temperature_findings
from fullwell.workflow.measure.emva.untold import with_untold
from fullwell.workflow.measure.emva.writer import LINEAR, PACKAGE
from fullwell.workflow.measure.section import Section, joined
from fullwell.workflow.measure.white_level import WhiteLevel

PROFILES = (LINEAR, PACKAGE)


def profiles_named(text: str) -> tuple[str, ...]:
    """Return the ids of profiles, one or several with commas between them.

    Raises
    ------
    UsageError
        There is none of that name; the sentence lists them.

    """
    names = [name.strip() for name in text.split(",")]
    unknown = [name for name in names if name not in PROFILES]
    if unknown:
        raise UsageError(f"--profile {unknown[0]}: give {' or '.join(PROFILES)}, or both with a comma between them.")
    return tuple(name for name in PROFILES if name in names)


def measure_emva(study: Study, bursts: IsoBursts, whites: Sequence[WhiteLevel], *, profiles: Sequence[str]) -> Section:
    """Evaluate the bursts of one ISO by each of some profiles."""
    found = joined([_measured(study, bursts, whites, profile=profile) for profile in profiles])
    every = dict.fromkeys((*temperature_findings(bursts), *_too_few_photons(bursts, found.rows), *found.findings))
    return replace(found, findings=_over_channels(bursts, every))


def _too_few_photons(bursts: IsoBursts, rows: Iterable[Row]) -> Iterator[Finding]:
    """Say where more electrons than photons are counted, beyond the error where there is one."""
    efficiencies: dict[str, float] = {}
    for row in rows:
        measured = row.measured
        if row.quantity == "quantum_efficiency" and (measured.ci95 or (measured.value,))[0] > 100.0:
            efficiencies.setdefault(row.channel, measured.value)
    if efficiencies:
        told = ", ".join(f"{channel} {value:.4g} %" for channel, value in efficiencies.items())
        message = (
            f"no camera has such a quantum efficiency at {bursts.label}: {told}. The photons that were given are too "
            "few; check irradiance, wavelength, pixel area, and the units of all these and of the exposures"
        )
        yield Finding(code="emva-efficiency", severity=Severity.WARNING, message=message)


def _over_channels(bursts: IsoBursts, findings: Iterable[Finding]) -> tuple[Finding, ...]:
    """Return findings with those that differ only by the channel as one."""
    same: dict[Finding, list[str]] = {}
    for finding in findings:
        channel = next((one for one in bursts.channels if f" {one} at {bursts.label}" in finding.message), "")
        template = finding.message.replace(f" {channel} at {bursts.label}", f" \0 at {bursts.label}", 1)
        same.setdefault(replace(finding, message=template), []).append(channel)
    return tuple(
        replace(finding, message=finding.message.replace("\0", ", ".join(channels)))
        for finding, channels in same.items()
    )


def _measured(study: Study, bursts: IsoBursts, whites: Sequence[WhiteLevel], *, profile: str) -> Section:
    sections: list[Section] = []
    for white in whites:
        top_code = float(white.seen) if white.piles_up else None
        fits = fit_linear(bursts, white.channel, top_code=top_code)
        if fits is None:
            sections.append(Section(findings=(_nothing(bursts, profile),)))
            continue
        half = fits.saturation.signal / 2.0
        stacks = choose_stacks(bursts, white.channel, half_saturation=half)
        if profile == PACKAGE:
            sections.append(_package(study, bursts, white.channel, fits, stacks))
            continue
        found = _linear(study, bursts, white.channel, fits, stacks)
        sections.append(replace(found, rows=with_untold(found.rows, bursts, white.channel, fits)))
    return joined(sections)


def with_recommendations(own: Sequence[Row], rows: Sequence[Row]) -> tuple[Row, ...]:
    """Return the profile's rows, recommended where nothing of Fullwell's own gives the figure (RESULTS 2)."""
    taken = {_identity(row) for row in own if RECOMMENDED in row.flags}
    marked: list[Row] = []
    for row in rows:
        if row.region is None and row.exposure_s is None and _identity(row) not in taken:
            taken.add(_identity(row))
            marked.append(replace(row, flags=tuple(sorted({*row.flags, RECOMMENDED}))))
        else:
            marked.append(row)
    return tuple(marked)


def _identity(row: Row) -> tuple[object, ...]:
    return (row.quantity, row.channel, row.measured.unit, row.iso, row.temperature_c, row.snr_threshold)


def _linear(study: Study, bursts: IsoBursts, channel: str, fits: LinearFits, stacks: Stacks | None) -> Section:
    gain = None if fits.system_gain is None else fits.system_gain.measured
    rows = linear_rows(bursts, channel, fits, area_um2=study.camera.area_um2, nominal=study.light.nominal)
    findings = [*sweep_findings(bursts, fits.sweep, fits.darks), *_saturation(bursts, channel, fits)]
    findings += _gate(bursts, channel, fits)
    findings += [_missing(bursts, channel, reason) for reason in missing(fits)]
    found = None if stacks is None else averages(stacks, channel)
    if stacks is None or found is None:
        findings.append(_no_stacks(bursts, small=stacks is not None))
        return Section(rows=rows, findings=tuple(findings), curves=sweep_curves(bursts, channel, fits))
    if stacks.bright is None:
        findings.append(_missing(bursts, channel, "PRNU: no stack of flats with a stack of darks at its exposure"))
    spatial = filtered_rows(bursts, channel, stacks, found, system_gain=gain)
    return Section(
        rows=(*rows, *spatial),
        findings=(*findings, *_half(bursts, channel, fits, stacks)),
        curves=(
            *sweep_curves(bursts, channel, fits, pattern=pattern_of(found, stacks.signal(channel))),
            *spatial_curves(bursts, channel, stacks, found),
        ),
    )


def _package(study: Study, bursts: IsoBursts, channel: str, fits: LinearFits, stacks: Stacks | None) -> Section:
    found = evaluate_package(fits.sweep)
    findings = list(sweep_findings(bursts, fits.sweep, fits.darks))
    rows: tuple[Row, ...] = ()
    curves = ()
    if found is None:
        reason = why_not(fits.sweep) or "its steps are too few"
        findings.append(_missing(bursts, channel, f"the package's figures of the sweep: {reason}"))
    else:
        rows = package_rows(bursts, channel, fits.sweep, found, area_um2=study.camera.area_um2)
        curves = package_curves(bursts, channel, fits.sweep, found)
    if stacks is None:
        findings.append(_no_stacks(bursts, small=False))
    else:
        gain = None if found is None else found.system_gain
        rows = (*rows, *package_spatial_rows(bursts, channel, stacks, system_gain=gain))
    return Section(rows=rows, findings=tuple(findings), curves=curves)


def _nothing(bursts: IsoBursts, profile: str) -> Finding:
    message = f"nothing at {bursts.label} can be evaluated by {profile}: it needs pairs of flats and of darks"
    return Finding(code="emva-nothing", severity=Severity.WARNING, message=message)


def _missing(bursts: IsoBursts, channel: str, reason: str) -> Finding:
    message = f"not given for {channel} at {bursts.label}: {reason}"
    return Finding(code="emva-not-given", severity=Severity.WARNING, message=message)


def _no_stacks(bursts: IsoBursts, *, small: bool) -> Finding:
    reason = (
        "the plane is smaller than 20 x 20 pixels, too small for the high-pass filter"
        if small
        else "there is no stack of three or more dark frames; take 16 or more, and as many flats at the same exposure"
    )
    message = f"DSNU and PRNU by EMVA 1288 are not given at {bursts.label}: {reason}"
    return Finding(code="emva-no-stacks", severity=Severity.WARNING, message=message)


def _saturation(bursts: IsoBursts, channel: str, fits: LinearFits) -> tuple[Finding, ...]:
    """Say how saturation was found where no step lies in the window."""
    found, sweep = fits.saturation, fits.sweep
    lower, upper = found.bracket
    steps = (
        f"between {sweep.mean[lower]:.6g} DN ({100.0 * sweep.top_fraction[lower]:.3g} % of the pixels at the highest "
        f"code) and {sweep.mean[upper]:.6g} DN ({100.0 * sweep.top_fraction[upper]:.3g} %)"
    )
    if sweep.exposure is not None:
        unit = "photons" if fits.by_photons else "s"
        steps += f", {sweep.exposure[lower]:.6g} and {sweep.exposure[upper]:.6g} {unit}"
    at = f"{channel} at {bursts.label}"
    if found.mode == "interpolated":
        message = (
            f"no step of {at} has 0.1 to 0.2 % of its pixels at the highest code: saturation is interpolated {steps}"
        )
    elif found.mode == "bracketed":
        message = (
            f"the pixels at the highest code jump past the window of 0.1 to 0.2 % for {at}: saturation lies {steps}; "
            f"the noise below puts it at {found.mean:.6g} DN. Add steps there"
        )
    elif found.mode == "peak":
        message = (
            f"no code piles up at the top for {at}, but the noise falls beyond {found.mean:.6g} DN: the full well lies "
            "below the range of the converter, and the step of the largest variance is taken, which reads low"
        )
    elif found.mode == "unreached":
        message = (
            f"no code piles up at the top for {at}: the sweep may end before saturation, its last step is taken for it"
        )
    else:
        return ()
    severity = Severity.INFO if found.mode == "interpolated" else Severity.WARNING
    return (Finding(code=f"emva-saturation-{found.mode}", severity=severity, message=message),)


def _gate(bursts: IsoBursts, channel: str, fits: LinearFits) -> tuple[Finding, ...]:
    gate = fits.gate
    if gate is None or gate.deviation < LIMIT:
        return ()
    if gate.floor > 0.015:
        reason = f"noise alone makes {100.0 * gate.floor:.2g} % of it: more pixels or steps are needed to tell"
    else:
        reason = "one system gain does not describe this camera; Release 4.0 General applies"
    message = (
        f"the slope of the photon transfer of {channel} at {bursts.label} strays by {100.0 * gate.deviation:.2g} % "
        f"from one system gain, EMVA 1288 Linear allows 3 %: {reason}"
    )
    return (Finding(code="emva-not-linear", severity=Severity.WARNING, message=message),)


def _half(bursts: IsoBursts, channel: str, fits: LinearFits, stacks: Stacks) -> tuple[Finding, ...]:
    if stacks.bright is None:
        return ()
    share = stacks.signal(channel) / fits.saturation.signal
    if 0.4 <= share <= 0.6:
        return ()
    message = (
        f"the bright stack of {channel} at {bursts.label} lies at {100.0 * share:.0f} % of saturation; EMVA 1288 wants "
        "50 %"
    )
    return (Finding(code="emva-stack-level", severity=Severity.INFO, message=message),)
