"""What one measurement adds to the results, and how its rows are written."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

from fullwell.figures.results import Curve, Row
from fullwell.figures.saturation import bounded
from fullwell.findings import Finding
from fullwell.glossary import RECOMMENDED
from fullwell.units import Measured, square_root, student_975
from fullwell.workflow.measure.bursts import IsoBursts

_ISO = "\0"


@dataclass(frozen=True, slots=True, kw_only=True)
class Section:
    """Rows, findings and curves of one measurement."""

    rows: tuple[Row, ...] = ()
    findings: tuple[Finding, ...] = ()
    curves: tuple[Curve, ...] = ()


def joined(sections: Iterable[Section]) -> Section:
    """Return the sections one after the other, curves of one name as one table."""
    every = tuple(sections)
    return Section(
        rows=tuple(row for section in every for row in section.rows),
        findings=tuple(finding for section in every for finding in section.findings),
        curves=_merged(curve for section in every for curve in section.curves),
    )


def over_isos(sections: Iterable[tuple[IsoBursts, Section]]) -> tuple[Finding, ...]:
    """Return the findings of several ISOs, those that differ only by the ISO as one."""
    found: dict[tuple[str, str], list[tuple[IsoBursts, Finding]]] = {}
    for bursts, section in sections:
        for finding in section.findings:
            template = finding.message.replace(bursts.label, _ISO)
            found.setdefault((finding.code, template), []).append((bursts, finding))
    return tuple(_over_isos(template, same) for (_, template), same in found.items())


def _over_isos(template: str, same: Sequence[tuple[IsoBursts, Finding]]) -> Finding:
    (first, finding), *others = same
    if not others:
        return finding
    label = ", ".join([first.label, *(f"{bursts.iso:g}" for bursts, _ in others if bursts.iso is not None)])
    files = tuple(sorted({file for _, one in same for file in one.files}))
    return replace(finding, message=template.replace(_ISO, label), files=files)


def _merged(curves: Iterable[Curve]) -> tuple[Curve, ...]:
    by_name: dict[str, Curve] = {}
    for curve in curves:
        if (known := by_name.get(curve.name)) is None:
            by_name[curve.name] = curve
        else:
            columns = tuple(
                replace(old, values=old.values + new.values)
                for old, new in zip(known.columns, curve.columns, strict=True)
            )
            by_name[curve.name] = Curve(name=curve.name, columns=columns)
    return tuple(by_name.values())


def _above_zero(variance: Measured) -> Measured:
    """Keep the upper end of a variance's interval at what its error leaves above zero (METHOD 1.7)."""
    if variance.ci95 is None or variance.std_error is None or variance.ci95[1] > 0.0:
        return variance
    low = variance.ci95[0]
    return replace(variance, ci95=(low, student_975(variance.dof) * variance.std_error))


@dataclass(frozen=True, slots=True, kw_only=True)
class RowWriter:
    """Writes rows that belong to one ISO, or to all of them where ``bursts`` is None."""

    bursts: IsoBursts | None

    def row(
        self,
        quantity: str,
        channel: str,
        method: str,
        measured: Measured,
        *,
        source: str,
        n: int | None = None,
        exposure_s: float | None = None,
        region: str | None = None,
        snr_threshold: float | None = None,
        flags: Iterable[str] = (),
        recommended: bool = False,
    ) -> Row:
        """Return one row; ``recommended`` adds the flag of that name. A lower bound keeps its value alone."""
        every = {*flags, RECOMMENDED} if recommended else set(flags)
        return Row(
            quantity=quantity,
            channel=channel,
            method=method,
            measured=bounded(measured, every),
            n=n,
            iso=None if self.bursts is None else self.bursts.iso,
            exposure_s=exposure_s,
            temperature_c=None if self.bursts is None else self.bursts.temperature_c,
            region=region,
            snr_threshold=snr_threshold,
            flags=tuple(sorted(every)),
            source=source,
        )

    def root_and_variance(
        self,
        quantity: str,
        channel: str,
        method: str,
        variance: Measured,
        unit: str,
        *,
        source: str,
        n: int | None = None,
        exposure_s: float | None = None,
        region: str | None = None,
        flags: Iterable[str] = (),
        recommended: bool = True,
    ) -> tuple[Row, Row]:
        """Return the row of a square root, and its signed twin in the squared unit (RESULTS 2)."""
        own = set(flags)
        limit = {"upper-limit"} if variance.value <= 0.0 else set[str]()
        root = square_root(_above_zero(variance), unit)

        def write(name: str, measured: Measured, marks: set[str]) -> Row:
            return self.row(
                name,
                channel,
                method,
                measured,
                source=source,
                n=n,
                exposure_s=exposure_s,
                region=region,
                flags=marks,
                recommended=recommended,
            )

        return write(quantity, root, own | limit), write(f"{quantity}_variance", variance, own)
