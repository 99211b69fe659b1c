"""System gain from flat bursts: variance against signal, gamma likelihood (METHOD 1)."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from fullwell.figures.results import Column, Curve, Row
from fullwell.findings import Finding, Severity
from fullwell.fit.photon_transfer import PhotonTransferFit, fit_photon_transfer
from fullwell.fit.pooling import SIGNIFICANCE, pool_channels
from fullwell.units import DN, DN2, ONE, Measured
from fullwell.workflow.measure.bursts import IsoBursts
from fullwell.workflow.measure.levels import ChannelLevels
from fullwell.workflow.measure.read_noise import choose_burst
from fullwell.workflow.measure.section import RowWriter, Section
from fullwell.workflow.measure.transfer_points import (
    TransferPoint,
    before_saturation,
    correlation_inflation,
    transfer_point,
    unlit_for_transfer,
)


@dataclass(frozen=True, slots=True, kw_only=True)
class ChannelTransfer:
    """The photon-transfer curve of one channel.

    Parameters
    ----------
    points
        Unlit and flat bursts by ascending signal.
    on_curve
        Which of them the fit was given; the others are saturated, or single frames.
    fit
        None where the points are too few.

    """

    channel: str
    points: tuple[TransferPoint, ...]
    on_curve: tuple[bool, ...]
    fit: PhotonTransferFit | None

    @property
    def system_gain(self) -> Measured | None:
        """Return K [DN/e-], None where it was not measured or is not positive."""
        if self.fit is None or self.fit.system_gain.value <= 0.0:
            return None
        return self.fit.system_gain

    @property
    def beyond_the_turn(self) -> tuple[TransferPoint, ...]:
        """Return the points whose variance has fallen though no value lies on the white level: the pixels are full."""
        return tuple(
            point for point, good in zip(self.points, self.on_curve, strict=True) if point.admitted and not good
        )


def measure_photon_transfer(
    bursts: IsoBursts, levels: Sequence[ChannelLevels]
) -> tuple[Section, tuple[ChannelTransfer, ...]]:
    """Fit the photon-transfer curve of every channel at one ISO."""
    transfers = tuple(_transfer(bursts, level, terms=2) for level in levels)
    if any(transfer.fit is not None and transfer.fit.misfit for transfer in transfers):
        bent = tuple(_transfer(bursts, level, terms=3) for level in levels)
        if all(transfer.fit is not None and not transfer.fit.misfit for transfer in bent):
            transfers = bent
    misfit = any(transfer.fit is not None and transfer.fit.misfit for transfer in transfers)
    rows = [row for transfer in transfers for row in _rows(bursts, transfer, misfit=misfit)]
    rows += _pooled(bursts, transfers)
    curves = tuple(_curve(bursts, transfer) for transfer in transfers if transfer.fit is not None)
    return Section(rows=tuple(rows), findings=_findings(bursts, transfers), curves=curves), transfers


def _transfer(bursts: IsoBursts, levels: ChannelLevels, *, terms: Literal[2, 3]) -> ChannelTransfer:
    """Fit the straight line, or a signed curvature with it (METHOD 10.1)."""
    every = [transfer_point(burst, levels) for burst in (*unlit_for_transfer(bursts, levels.channel), *bursts.flats)]
    points = sorted(every, key=lambda point: (point.signal_dn, point.burst.series.key))
    kept = before_saturation(points)
    chosen = [point for point, good in zip(points, kept, strict=True) if good]
    lit = sum(point.burst in bursts.flats for point in chosen)
    enough = lit >= 1 and len({point.signal_dn for point in chosen}) >= terms
    fit = _fit(bursts, levels.channel, chosen, terms=terms) if enough else None
    return ChannelTransfer(channel=levels.channel, points=tuple(points), on_curve=tuple(kept), fit=fit)


def _fit(
    bursts: IsoBursts, channel: str, points: Sequence[TransferPoint], *, terms: Literal[2, 3]
) -> PhotonTransferFit:
    unlit = choose_burst(bursts)
    inflation = [
        1.0 if unlit is None else correlation_inflation(unlit.plane(channel), point.variance_dn2) for point in points
    ]
    return fit_photon_transfer(
        np.array([point.signal_dn for point in points]),
        np.array([point.variance_dn2 for point in points]),
        np.array([point.dof for point in points]) / np.array(inflation),
        n=np.array([point.n for point in points]),
        terms=terms,
    )


def _rows(bursts: IsoBursts, transfer: ChannelTransfer, *, misfit: bool) -> tuple[Row, ...]:
    """Return the system gain; one channel's misfit is a warning for all, since they share the sensor's physics."""
    measured = transfer.system_gain
    if measured is None or transfer.fit is None:
        return ()
    return (
        RowWriter(bursts=bursts).row(
            "system_gain",
            transfer.channel,
            "photon-transfer",
            measured,
            source="METHOD 1.2",
            n=sum(point.n for point, good in zip(transfer.points, transfer.on_curve, strict=True) if good),
            flags=("model-misfit",) if misfit else (),
            recommended=True,
        ),
    )


def _pooled(bursts: IsoBursts, transfers: Sequence[ChannelTransfer]) -> tuple[Row, ...]:
    known = [transfer.system_gain for transfer in transfers if transfer.system_gain is not None]
    if len(transfers) < 2 or len(known) < len(transfers):
        return ()
    pooled, p_value = pool_channels(known)
    flags = {"channels-differ"} if p_value < SIGNIFICANCE else set[str]()
    if any(transfer.fit is not None and transfer.fit.misfit for transfer in transfers):
        flags.add("model-misfit")
    n = sum(point.n for transfer in transfers for point in transfer.points)
    write = RowWriter(bursts=bursts).row
    return (
        write(
            "system_gain", "all", "photon-transfer", pooled, source="METHOD 1.10", n=n, flags=flags, recommended=True
        ),
    )


def _curve(bursts: IsoBursts, transfer: ChannelTransfer) -> Curve:
    points = [point for point in transfer.points if point.admitted]
    fit = transfer.fit
    if fit is None:
        raise ValueError("a curve needs a fit")
    kept = iter(zip(fit.used, fit.residuals, strict=True))
    on_curve = [good for point, good in zip(transfer.points, transfer.on_curve, strict=True) if point.admitted]
    judged = [next(kept) if good else (False, None) for good in on_curve]
    variances = [point.variance_dn2 for point in points]
    fitted = np.polynomial.polynomial.polyval(np.array([point.signal_dn for point in points]), fit.coefficients)
    return Curve(
        name="photon_transfer",
        columns=(
            Column(name="iso", unit="1", values=(bursts.iso,) * len(points)),
            Column(name="channel", unit="", values=(transfer.channel,) * len(points)),
            Column(name="kind", unit="", values=tuple(point.burst.kind.value for point in points)),
            Column(name="exposure_s", unit="s", values=tuple(point.burst.exposure_s for point in points)),
            Column(name="photons", unit="p", values=tuple(point.burst.series.photons for point in points)),
            Column(name="signal", unit=DN, values=tuple(point.signal_dn for point in points)),
            Column(name="variance", unit=DN2, values=tuple(variances)),
            Column(
                name="variance_std_error",
                unit=DN2,
                values=tuple(point.variance_dn2 * (2.0 / point.dof) ** 0.5 for point in points),
            ),
            Column(name="dof", unit="1", values=tuple(point.dof for point in points)),
            Column(name="fitted", unit=DN2, values=tuple(fitted.tolist())),
            Column(name="residual", unit=ONE, values=tuple(None if r is None else float(r) for _, r in judged)),
            Column(name="used", unit="", values=tuple("yes" if used else "no" for used, _ in judged)),
        ),
    )


def _findings(bursts: IsoBursts, transfers: Sequence[ChannelTransfer]) -> tuple[Finding, ...]:
    if not bursts.flats:
        return ()
    if all(burst.frames < 2 for burst in bursts.flats):
        message = (
            f"flats at {bursts.label} are single frames: temporal noise cannot be told from fixed pattern, so the "
            "system gain is not measured; take two frames or more at each exposure"
        )
        return (Finding(code="single-flat-frames", severity=Severity.WARNING, message=message),)
    findings: list[Finding] = []
    unmeasured = [transfer.channel for transfer in transfers if transfer.system_gain is None]
    if unmeasured:
        message = (
            f"system gain of {', '.join(unmeasured)} at {bursts.label} is not measured: too few levels below "
            "saturation; take darker flats, or dark frames beside them"
        )
        findings.append(Finding(code="too-few-levels", severity=Severity.WARNING, message=message))
    misfits = [transfer for transfer in transfers if transfer.fit is not None and transfer.fit.misfit]
    if misfits:
        worst = max(t.fit.deviance / t.fit.deviance_dof for t in misfits if t.fit is not None)
        message = (
            f"variance against signal of {', '.join(t.channel for t in misfits)} at {bursts.label} is not the straight "
            f"line of photon noise (deviance per degree of freedom up to {worst:.3g}): errors of the system gain are "
            "scaled up; look at the residuals"
        )
        findings.append(Finding(code="photon-transfer-misfit", severity=Severity.WARNING, message=message))
    bent = [t.channel for t in transfers if t.fit is not None and t.fit.coefficients.size > 2]
    if bent:
        message = (
            f"the photon-transfer curve of {', '.join(bent)} at {bursts.label} bends: brighter-fatter or a non-linear "
            "response; the system gain is its slope at low signal, from a fit with a signed curvature"
        )
        findings.append(Finding(code="photon-transfer-bends", severity=Severity.WARNING, message=message))
    untested = [t.channel for t in transfers if t.fit is not None and t.fit.deviance_dof < 1]
    if untested:
        message = (
            f"the photon-transfer line of {', '.join(untested)} at {bursts.label} rests on two levels: its "
            "straightness cannot be tested; take more exposures"
        )
        findings.append(Finding(code="photon-transfer-untested", severity=Severity.WARNING, message=message))
    return tuple(findings)
